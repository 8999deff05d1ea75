"""Two bars pulled apart until their edges have drifted past nodes."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import rounding, run

F, L, E, RHO = 1.0, 0.5, 1e4, 1.0
C = float(np.sqrt(E / RHO))
UNTIL = 20.0 * L / C


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Pull at the outer ends, with as many empty cells between the bars as no node sees both; look every half transit."""
    from mpmkit.boundaries import TwoPointTraction
    from mpmkit.materials import LinearElastic

    n = 50 if quick else 250  # particles of each bar, one in a cell
    h = L / n
    gap = (composition.shape.nodes - 1) * h
    sim = simulation(composition, mpm.Grid(-20 * h, 2 * L + gap + 20 * h, h, lateral="stress"))
    elastic = LinearElastic(E=E, nu=0.0, rho=RHO)
    sim += mpm.Body(mpm.Box(0.0, L), elastic, particles_per_cell=1, name="left")
    sim += mpm.Body(mpm.Box(L + gap, 2 * L + gap), elastic, particles_per_cell=1, name="right")
    sim += TwoPointTraction(body="left", traction=(-F,), face="xmin"), TwoPointTraction(body="right", traction=(F,), face="xmax")
    if composition.contact is not None:
        sim += composition.contact
    centre = {body: sim.particles(body)["x"].mean() for body in ("left", "right")}
    largest = 0.0
    for t in np.linspace(0.0, UNTIL, 41)[1:]:
        largest = max(largest, float(np.abs(run(sim, t).particles()["stress"]).max()))
    way = 0.5 * F / (RHO * L) * UNTIL**2
    history = sim.history
    moved = {body: sim.particles(body)["x"].mean() - centre[body] for body in centre}
    return [
        Figure("largest stress / traction", largest / F, 4.0),
        Figure("momentum / impulse of one traction", float(np.abs(history["momentum_x"]).max() / (F * UNTIL)), rounding(composition, 1e-9)),
        Figure("centre of a bar / h, error", max(abs(moved["left"] + way), abs(moved["right"] - way)) / h, 1e-3),
    ]


CASE = Case(
    name="tiny-mass",
    title="Two bars pulled apart: free edges drift past nodes",
    failure="As the last particle of a free edge drifts away from a node, the node's mass tends to zero faster than its force where "
    "the slope of the shape function does not: its acceleration has no bound. Stress last without a second mapping reaches stresses "
    "of 10^9 times the load.",
    criterion="500 particles, until 20 L / C: largest stress below 4 times the traction (exactly 2), momentum of both bars to 1e-9 of the "
    "impulse, centres within 1e-3 h of free acceleration. The gap has as many empty cells as no node sees both bars.",
    source="Chen and Brannon (2002), SAND2002-0482, section 4, test (e) and Figs 11, 12",
    dim=1,
    measure=measure,
)
