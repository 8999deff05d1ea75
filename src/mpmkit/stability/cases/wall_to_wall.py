"""A body that fills the domain from wall to wall, in motion."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.exact import VibratingBar
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import run
from mpmkit.stability.cases._tubes import MODULUS, RHO, WAVE, drift, rubber

EXACT = VibratingBar(L=1.0, E=MODULUS, rho=RHO, v0=1e-3 * WAVE, ends="fixed-fixed")


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """The lowest mode: its energy, and the time of its last passage through rest."""
    from mpmkit.boundaries import Symmetry

    cells, periods = (40, 3) if quick else (40, 20)
    sim = simulation(composition, mpm.Grid(0.0, 1.0, 1.0 / cells))
    sim += mpm.Body(mpm.Box(0.0, 1.0), rubber(), v=f"{EXACT.v0} * sin(pi * x)", particles_per_cell=2, name="bar")
    sim += Symmetry("all")
    mode = np.sin(np.pi * sim.particles("bar")["x"][:, 0])
    # The mode passes through zero at a quarter and three quarters of each period.
    around = (periods - 0.25 + np.linspace(-0.05, 0.05, 5)) * EXACT.period
    part = [float((run(sim, float(t)).particles("bar")["v"][:, 0] * mode).sum()) for t in around]
    passed = float(np.interp(0.0, part, around)) if part[0] < 0.0 < part[-1] else np.inf
    return [
        Figure("change of the mean energy of a period", drift(sim, EXACT.period), 0.005),
        Figure("period / exact - 1", passed / ((periods - 0.25) * EXACT.period) - 1.0, 0.005),
    ]


CASE = Case(
    name="wall-to-wall",
    title="A bar that fills the domain from wall to wall vibrates",
    failure="Every particle at a wall has its nodes cut or folded, and no cell of the domain is empty: what is wrong at a wall is not seen "
    "beside a free surface, here it shifts the period.",
    criterion="In 20 periods of the lowest mode the mean energy of a period (velocities lag by half a step) changes by less than 0.5 %, "
    "the period is exact to 0.5 %.",
    source="Graff (1975), Wave Motion in Elastic Solids, chapter 2",
    dim=1,
    measure=measure,
)
