"""Fixed time steps that are too large: a little above the limit, or unchanged when the grid is refined."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import mpmkit as mpm
from mpmkit.errors import StabilityError
from mpmkit.exact import VibratingBar
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import fixed, run
from mpmkit.stability.cases._tubes import MODULUS, RHO, WAVE, drift, rubber

EXACT = VibratingBar(L=1.0, E=MODULUS, rho=RHO, v0=1e-3 * WAVE, ends="fixed-fixed")
CELLS, ABOVE = 16, 1.01
UNNOTICED = 1e9


def bar(composition: Composition, cells: int, dt: float) -> mpm.Simulation:
    """A bar between walls in its first mode, stepped with dt."""
    from mpmkit.boundaries import Symmetry

    sim = simulation(fixed(composition, dt), mpm.Grid(0.0, 1.0, 1.0 / cells))
    sim += mpm.Body(mpm.Box(0.0, 1.0), rubber(), v=f"{EXACT.v0} * sin(pi * x)", particles_per_cell=2, name="bar")
    sim += Symmetry("all")
    return sim


def gained(sim: mpm.Simulation, periods: int) -> float:
    """Energy that the bar has gained in so many periods (means of a period), from every step: a period has few."""
    with tempfile.TemporaryDirectory() as folder:
        sim += mpm.Record(str(Path(folder) / "bar.vtkhdf"), history=1, checkpoint=False)
        return max(0.0, drift(run(sim, periods * EXACT.period), EXACT.period))


def refused_after(sim: mpm.Simulation, steps: int, dt: float) -> tuple[float, float]:
    """Steps until the time step is refused by name, `UNNOTICED` if it never is, and the time step that the message advises."""
    try:
        run(sim, steps * dt)
    except StabilityError as error:
        found = re.search(r"is above the stable limit .* at step (\d+).* To fix: dt <= (\S+) s", str(error), re.DOTALL)
        if found:
            return float(found.group(1)), float(found.group(2))
    return UNNOTICED, ABOVE * dt


def limit(cells: int) -> float:
    """The largest time step that the rule h / (c + |v|) allows; components may be known to allow less."""
    return 1.0 / cells / (WAVE + EXACT.v0)


def above(composition: Composition, quick: bool) -> list[Figure]:
    """One per cent above the limit, and what the message advises."""
    dt = ABOVE * limit(CELLS)
    late, advised = refused_after(bar(composition, CELLS, dt), 200, dt)
    return [
        Figure("steps before it is refused", late, 5.0),
        Figure("energy gained with what is advised", gained(bar(composition, CELLS, advised), 3 if quick else 20), 0.01),
    ]


def refined(composition: Composition, quick: bool) -> list[Figure]:
    """A step that is right for a grid, on that with half the spacing."""
    _, dt = refused_after(bar(composition, CELLS, limit(CELLS) * ABOVE), 1, limit(CELLS))
    return [
        Figure("energy gained on the coarse grid", gained(bar(composition, CELLS, dt), 3), 0.01),
        Figure("steps before it is refused on the fine grid", refused_after(bar(composition, 2 * CELLS, dt), 200, dt)[0], 5.0),
    ]


SOURCE = "Courant, Friedrichs and Lewy (1928), doi:10.1007/BF01448839; threads 3162 and 8345 of taichi, in which users met it"
CASES = (
    Case(
        name="step-above-limit",
        title="A fixed time step one per cent above the limit",
        failure="Just above the limit the shortest waves grow by some per cent in a step: nothing is seen for a hundred steps, then "
        "everything is lost within ten.",
        criterion="Refused by name within 5 steps. With what the message advises, 80 % of the limit of these components, a bar in its "
        "first mode does not gain 1 % of energy in 20 periods (mean of a period).",
        source=SOURCE,
        dim=1,
        measure=above,
    ),
    Case(
        name="refined-at-same-step",
        title="A grid is refined to half its spacing, the time step left as it was",
        failure="The limit is proportional to the spacing: what was right on the coarse grid is far above it on the fine one.",
        criterion="With what is advised for it the coarse grid does not gain 1 % of energy in 3 periods; the fine grid refuses within 5 "
        "steps.",
        source=SOURCE,
        dim=1,
        measure=refined,
    ),
)
