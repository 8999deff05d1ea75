"""Particles on the faces of the domain, and one rounding error from them."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import rounding, run

CELLS, H, SPEED = 10, 0.1, 0.25  # 0.1 is no number of the machine: the faces are rounded
START, WAY = 0.25, 0.4
FACES = (0.0, 1.0)


def sliding(composition: Composition, x: float) -> list[float]:
    """A particle at `x` flies along the face in y: errors of x, of y, and stress over modulus."""
    from mpmkit.boundaries import Wall
    from mpmkit.materials import NeoHookean

    material = NeoHookean(E=1.0, nu=0.0, rho=1.0)
    sim = simulation(composition, mpm.Grid((0.0, 0.0), (1.0, 1.0), H))
    sim += mpm.Body.from_arrays([[x, START]], 0.25 * H * H, material, v=(0.0, SPEED), size=(0.25 * H, 0.25 * H), name="particle")
    sim += Wall("all", condition="slip")
    end = run(sim, WAY / SPEED).particles("particle")
    return [abs(float(end["x"][0, 0]) - x), abs(float(end["x"][0, 1]) - START - WAY), float(np.abs(end["stress"]).max())]


def pressed(composition: Composition, steps: int) -> float:
    """Particles a few rounding errors from the upper corner, which they fly at and gravity presses them into: how far outside they get."""
    from mpmkit.boundaries import Wall
    from mpmkit.effects import Gravity
    from mpmkit.materials import NeoHookean

    sim = simulation(composition, mpm.Grid((0.0, 0.0), (1.0, 1.0), H))
    x = 1.0 - np.finfo(float).eps * np.array([[1.0, 2.0], [3.0, 5.0], [8.0, 13.0], [21.0, 34.0]])
    sim += mpm.Body.from_arrays(
        x, 0.25 * H * H, NeoHookean(E=1.0, nu=0.0, rho=1.0), v=(SPEED, SPEED), size=(0.25 * H, 0.25 * H), name="particle"
    )
    sim += Wall("all", condition="slip"), Gravity((0.1, 0.07))
    end = run(sim, steps * composition.integrator.cfl * H).particles("particle")["x"]
    return float(max(0.0, (end - 1.0).max())) if np.isfinite(end).all() else np.inf


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Exactly on both faces, one rounding error inside and outside; and pressed into the corner."""
    places = [float(np.nextafter(face, towards)) for face in FACES for towards in (face, -1.0, 2.0)]
    errors = np.array([sliding(composition, x) for x in places]).max(axis=0)
    return [
        Figure("distance from the face", float(errors[0]), rounding(composition, 1e-12)),
        Figure("error of the way along it", float(errors[1]), rounding(composition, 1e-12)),
        Figure("stress / modulus", float(errors[2]), rounding(composition, 1e-12)),
        Figure("distance outside when pressed into the corner", pressed(composition, 500 if quick else 10000), 0.0),
    ]


CASE = Case(
    name="on-a-face",
    title="Particles exactly on a face of the domain, one rounding error inside it, and one outside",
    failure="The cell of a particle on the upper face is one that does not exist; a particle that a wall holds on its face is outside "
    "after "
    "one more rounding, and stops a run of hours, or is lost.",
    criterion="On either face, and by one rounding error beside it: a particle slides along for 4 cells, its distance, way and stress "
    "exact to "
    "1e-12. Four that start up to 34 rounding errors from the upper "
    "corner, and fly at it and are pressed into it for 10^4 steps, are never outside.",
    source="Newton's first law; thread 80 of geomechanics/mpm, where particles left by rounding",
    dim=2,
    measure=measure,
)
