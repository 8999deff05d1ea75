"""Constant stress from wall to wall: the nodes at a wall have support on one side only."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import rounding, run

CELLS, PRESSURE, STEPS = 6, 0.1, 100  # pressure over the modulus
SIDES = (1, 2, 3, 4)
"""Particles in a cell along each axis."""


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Nothing may move, whatever the number of particles in the cells at the walls."""
    from mpmkit.boundaries import Symmetry
    from mpmkit.materials import HypoelasticJaumann

    material = HypoelasticJaumann(E=1.0, nu=0.0, rho=1.0)  # in rate form: a stress without a strain
    speed = stress = 0.0
    for side in SIDES:
        sim = simulation(composition, mpm.Grid((0.0, 0.0), (CELLS, CELLS), 1.0))
        state = (-PRESSURE, -PRESSURE, -PRESSURE, 0.0, 0.0, 0.0)
        box = mpm.Box((0.0, 0.0), (CELLS, CELLS))
        sim += mpm.Body(box, material, particles_per_cell=side**2, stress=state, name="block")
        sim += Symmetry("all")
        end = run(sim, STEPS * composition.integrator.cfl).particles("block")
        speed = max(speed, float(np.abs(end["v"]).max()))
        stress = max(stress, float(np.abs(end["stress"] - np.array(state)).max()))
    return [
        Figure("largest velocity / wave speed", speed, rounding(composition, 1e-12)),
        Figure("change of the stress / modulus", stress, rounding(composition, 1e-12)),
    ]


CASE = Case(
    name="support-at-wall",
    title="A block under uniform pressure fills the domain from wall to wall",
    failure="Shape functions wider than a cell reach behind the wall. If what lies there is cut off, or their sums are scaled, the "
    "gradients "
    "of the nodes next to the wall do not add up to zero, and a uniform pressure pushes the particles off the wall.",
    criterion="With 1, 4, 9 and 16 particles in a cell, after 100 steps: no velocity above 1e-12 of the wave speed, stress unchanged to "
    "1e-12.",
    source="Equilibrium; thread 738 of cb-geo/mpm, in which GIMP fails at a boundary",
    dim=2,
    measure=measure,
)
