"""A column on which gravity is switched on."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.exact import SuddenColumn
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import run

EXACT = SuddenColumn(H=50.0, modulus=1e5, rho=80.0, g=0.01)  # strains of 4e-4: linear
LIMIT = 0.01


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Displacement of the uppermost particle after half a period; when the column is up again, by its mean velocity."""
    from mpmkit.boundaries import Symmetry
    from mpmkit.effects import Gravity
    from mpmkit.materials import LinearElastic

    cells = 25 if quick else 100
    h = EXACT.H / cells
    sim = simulation(composition, mpm.Grid(0.0, EXACT.H + 3 * h, h))
    column = LinearElastic(E=EXACT.modulus, nu=0.0, rho=EXACT.rho)
    sim += mpm.Body(mpm.Box(0.0, EXACT.H), column, particles_per_cell=2, name="column")
    sim += Symmetry("xmin"), Gravity((-EXACT.g,))
    top = sim.particles("column")["x"][-1, 0]
    sunk = run(sim, 0.5 * EXACT.period).particles("column")["x"][-1, 0] - top
    history = run(sim, 1.1 * EXACT.period).history
    t, v = history["t"], history["momentum_x"]
    up = int(np.flatnonzero((v[:-1] > 0.0) & (v[1:] <= 0.0))[0])
    back = t[up] + (t[up + 1] - t[up]) * v[up] / (v[up] - v[up + 1])
    return [
        Figure("overshoot / twice the static displacement - 1", float(sunk / EXACT.displacement(top, 0.5 * EXACT.period) - 1.0), LIMIT),
        Figure("period / exact - 1", float(back / EXACT.period - 1.0), LIMIT),
    ]


CASE = Case(
    name="sudden-load",
    title="Gravity is switched on under a column at rest",
    failure="A load in full from the first step on rings at the frequency of the grid; damping, a wrong lumped mass at the free end "
    "or forces that reach the nodes late change how far the column sinks.",
    criterion="The top sinks to twice its static displacement, within 1 %, and is back after 4 H / c, within 1 %.",
    source="d'Alembert's solution, mpmkit.exact.SuddenColumn",
    dim=1,
    measure=measure,
)
