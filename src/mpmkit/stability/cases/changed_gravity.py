"""A column at rest under its weight, of which gravity changes a little."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.exact import Column, SuddenColumn
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import momentum_error, rounding, run

CHANGE = 0.01
SETTLED = Column(H=50.0, E=1e5, rho=80.0, g=0.981)  # strains up to 4 %
ADDED = SuddenColumn(H=50.0, modulus=1e5, rho=80.0, g=CHANGE * 0.981)
SWING = 2.0 * CHANGE * SETTLED.rho * SETTLED.g * SETTLED.H
"""The most that stress at the base changes by: twice the static change [Pa]."""


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Stresses of all particles during three periods, against the exact wave."""
    from mpmkit.boundaries import Symmetry
    from mpmkit.effects import Gravity
    from mpmkit.materials import NeoHookean

    cells, periods = (25, 1) if quick else (100, 3)
    h = SETTLED.H / cells
    Y = (np.arange(2 * cells) + 0.5) * h / 2.0
    F = np.tile(np.eye(3), (len(Y), 1, 1))
    F[:, 0, 0] = SETTLED.stretch(Y)
    sim = simulation(composition, mpm.Grid(0.0, SETTLED.H + 2.0 * h, h))
    column = NeoHookean(E=SETTLED.E, nu=SETTLED.nu, rho=SETTLED.rho)
    x = Y + SETTLED.displacement(Y)
    sim += mpm.Body.from_arrays(x, h / 2.0, column, F=F, size=(h / 4.0,), name="column")
    sim += Symmetry("xmin"), Gravity((-(1.0 + CHANGE) * SETTLED.g,))
    lowest = overshoot = noise = 0.0
    for t in np.linspace(0.0, periods * ADDED.period, 20 * periods + 1)[1:]:
        now = run(sim, float(t)).particles("column")
        lowest = min(lowest, float((now["x"][:, 0] - x).mean()))
        change = now["stress"][:, 0] - SETTLED.stress(Y)
        overshoot = max(overshoot, float(-change.min()) / SWING)
        noise = max(noise, float(np.abs(change - ADDED.stress(Y, t)).max()) / SWING)
    static = float(ADDED.displacement(Y, 0.5 * ADDED.period).mean())
    return [
        Figure("largest mean displacement / exact - 1", lowest / static - 1.0, 0.05),
        Figure("largest change of stress / exact - 1", max(0.0, overshoot - 1.0), 0.1),
        Figure("deviation from the exact stress / largest change", noise, 0.2),
        Figure("change of the momentum", momentum_error(sim, ADDED.c), rounding(composition, 1e-10)),
    ]


CASE = Case(
    name="changed-gravity",
    title="A column at rest under its weight, and one per cent more gravity",
    failure="A state of rest that is none on the grid rings by itself; a mild change sets off noise that grows to NaN.",
    criterion="One per cent more: mean displacement at most twice the static change, within 5 %; no stress changes by more than twice the "
    "static change at the base, plus 10 %; none is off the exact wave by more than 20 % of that.",
    source="d'Alembert's solution, exact overshoot 2; thread 749 of cb-geo/mpm",
    dim=1,
    measure=measure,
)
