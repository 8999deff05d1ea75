"""A block that falls, with drops of one particle each around it."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import rounding, run

H, SPEED, G = 1.0, 1.0, 0.02
DROPS = np.array([[5.0, 30.0], [12.3, 37.999], [20.5, 12.0], [33.0, 33.0], [37.25, 21.5]])
FLIGHT = np.array([[0.3, -0.1], [-0.2, 0.1], [0.1, -0.3], [0.0, 0.0], [-0.25, -0.05]])


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Seen from the block everything flies straight on."""
    from mpmkit.boundaries import Wall
    from mpmkit.effects import Gravity
    from mpmkit.materials import NeoHookean

    material = NeoHookean(E=1.0, nu=0.0, rho=1.0)
    sim = simulation(composition, mpm.Grid((0.0, 0.0), (45.0, 45.0), H))
    sim += mpm.Body(mpm.Box((20.0, 28.0), (24.0, 32.0)), material, name="block")
    sim += mpm.Body.from_arrays(DROPS, 0.25, material, v=FLIGHT, size=(0.25, 0.25), name="drops")
    sim += Wall("all", condition="slip"), Gravity((0.0, -G))
    until = 8.0 if quick else 16.0
    block, drops = sim.particles("block"), sim.particles("drops")
    away = drops["x"] - block["x"].mean(axis=0)
    run(sim, until)
    block, drops = sim.particles("block"), sim.particles("drops")
    way = drops["x"] - block["x"].mean(axis=0) - away - FLIGHT * until
    fall = block["v"] - np.array([0.0, -G * until])
    stress = max(float(np.abs(p["stress"]).max()) for p in (block, drops))
    return [
        Figure("drops, error of the way / cell", float(np.abs(way).max() / H), rounding(composition, 1e-11)),
        Figure(
            "drops, error of the velocity / wave speed",
            float(np.abs(drops["v"] - FLIGHT - [0.0, -G * until]).max()),
            rounding(composition, 1e-11),
        ),
        Figure("block, error of the velocity / wave speed", float(np.abs(fall).max()), rounding(composition, 1e-11)),
        Figure("stress / modulus", stress, rounding(composition, 1e-11)),
    ]


CASE = Case(
    name="lone-particles",
    title="A block falls among drops of one particle each, in cells of their own",
    failure="The nodes around a lone particle have nothing but its mass, and next to none where it comes near a node: f / m of a rounding "
    "error is a velocity gradient.",
    criterion="Seen from the block, every drop flies straight on; ways, velocities and stress exact to 1e-11.",
    source="Equivalence of uniform gravity and acceleration",
    dim=2,
    measure=measure,
)
