"""Fast particles against what is thin: a wall on a face of the domain, a plate of one layer of particles."""

from __future__ import annotations

import attrs
import numpy as np

import mpmkit as mpm
from mpmkit.errors import StabilityError
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import momentum_error, rounding, run
from mpmkit.stability.cases._tubes import WAVE, rubber

FAST, H = 100.0, 1.0  # over the wave speed
CFL = 1.0


def at_wall(composition: Composition, place: float) -> float:
    """1 if a particle that starts at `place` cells from the wall gets behind it, with the largest steps, else 0."""
    from mpmkit.boundaries import Symmetry

    fastest = attrs.evolve(composition, integrator=attrs.evolve(composition.integrator, cfl=CFL))
    sim = simulation(fastest, mpm.Grid(0.0, 12.0, H))
    sim += mpm.Body.from_arrays([12.0 - place], 0.5, rubber(), v=FAST * WAVE, size=(0.25,), name="particle")
    sim += Symmetry("all")
    try:
        run(sim, 40.0 * H / (FAST * WAVE))
    except StabilityError as error:
        return float("left the domain" in str(error))
    return 0.0


def wall(composition: Composition, quick: bool) -> list[Figure]:
    """From many places, so that particles come to the last cell anywhere in it."""
    places = np.linspace(5.0, 6.0, 6 if quick else 21)
    return [Figure("particles behind the wall", sum(at_wall(composition, float(p)) for p in places), 0.0)]


def through(composition: Composition, place: float) -> tuple[float, float]:
    """How far a projectile gets behind the middle of a plate of one particle, in cells; error of the momentum."""
    sim = simulation(composition, mpm.Grid(0.0, 40.0, H))
    x = 10.0 - place + 0.5 * np.arange(4)
    sim += mpm.Body.from_arrays(x, 0.5, rubber(100.0), v=WAVE, size=(0.25,), name="projectile")
    sim += mpm.Body.from_arrays([13.25], 0.5, rubber(100.0, 100.0), size=(0.25,), name="plate")
    if composition.contact is not None:
        sim += composition.contact
    behind = -np.inf
    for t in np.linspace(0.0, 8.0 * H / WAVE, 41)[1:]:
        run(sim, float(t))
        behind = max(behind, float(sim.particles("projectile")["x"].max() - sim.particles("plate")["x"].min()))
    return behind / H, momentum_error(sim, WAVE)


def plate(composition: Composition, quick: bool) -> list[Figure]:
    """From several places; the plate is half a cell thin."""
    found = np.array([through(composition, float(p)) for p in np.linspace(0.0, 1.0, 3 if quick else 11)])
    return [
        Figure("way behind the middle of the plate / cell", max(0.0, float(found[:, 0].max())), 0.0),
        Figure("change of the momentum", float(found[:, 1].max()), rounding(composition, 1e-10)),
    ]


CASES = (
    Case(
        name="thin-wall",
        title="A particle at a hundred times its wave speed meets a wall of no thickness",
        failure="A particle that moves by more than a cell in a step never sees the nodes of the wall.",
        criterion="With cfl = 1, the largest steps there are, and starts all over a cell: no particle is ever behind the wall.",
        source="A particle moves by less than a cell in a step, and the nodes of the face are those of the last cell. Thread 600 of "
        "Genesis, "
        "in which particles pass a rigid box",
        dim=1,
        measure=wall,
    ),
    Case(
        name="thin-plate",
        title="A projectile meets a heavy plate of one layer of particles",
        failure="The normal of a plate that is thinner than a cell is a difference of two gradients that cancel; once the projectile's "
        "middle is behind the plate's, contact pushes it out on the wrong side.",
        criterion="At the wave speed of rubber a hundred times softer, from starts all over a cell: no particle gets behind the plate's "
        "middle; "
        "momentum to rounding.",
        source="Impenetrability; thread 600 of Genesis",
        dim=1,
        measure=plate,
        contact=True,
    ),
)
