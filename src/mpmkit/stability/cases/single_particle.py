"""A particle alone in a cell, in free flight."""

from __future__ import annotations

from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import fixed, rounding, run, with_material

CELLS, SHORT = 200, 20
VELOCITY = np.array([0.37, -0.21, 0.11])
ON_NODES = np.array([1.0, -0.5, 0.25])
STEPS_PER_CELL = 64  # a power of two: positions and times are exact, and every 64th step ends exactly on nodes


def fly(composition: Composition, start: Any, velocity: Any, cells: int) -> list[float]:
    """Relative errors of position and velocity, |F - 1|, and stress over modulus, after crossing so many cells along x."""
    from mpmkit.materials import NeoHookean

    way = cells * velocity / velocity[0]
    lower, upper = np.floor(np.minimum(0.0, way)) - 4.0, np.ceil(np.maximum(0.0, way)) + 5.0
    sim = simulation(composition, mpm.Grid(tuple(lower), tuple(upper), 1.0))
    material = with_material(composition, NeoHookean(E=40.0, nu=0.3, rho=1.0))
    sim += mpm.Body.from_arrays(np.array([start]), 0.125, material, v=tuple(velocity), name="particle")
    until = cells / velocity[0]
    modulus = material.rho * float(sim.compose().engine.outs[0, 0] - np.linalg.norm(velocity)) ** 2
    end = run(sim, until).particles("particle")
    path = float(np.linalg.norm(way))
    return [
        float(np.abs(end["x"][0] - start - way).max() / path),
        float(np.abs(end["v"][0] - velocity).max() / np.linalg.norm(velocity)),
        float(np.abs(end["F"][0] - np.eye(3).ravel()).max()),
        float(np.abs(end["stress"][0]).max() / modulus),
    ]


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """One flight from anywhere with the composition's own time step, one that starts on a node and meets more of them exactly."""
    cells = SHORT if quick else CELLS
    anywhere = fly(composition, np.array([0.31, 0.77, 0.52]), VELOCITY, cells)
    nodes = fly(fixed(composition, 1.0 / STEPS_PER_CELL), np.zeros(3), ON_NODES, cells)
    names = ("position error / path", "velocity error", "|F - 1|", "stress / modulus")
    limit = rounding(composition, 1e-12)
    return [Figure(name, max(a, b), limit) for name, a, b in zip(names, anywhere, nodes, strict=True)]


CASE = Case(
    name="single-particle",
    title="A particle alone in its cell flies through 200 cells",
    failure="The nodes around a lone particle have next to no mass when it passes close to one of them or comes to lie exactly on one; "
    "a momentum divided by such a mass, or a sum of gradients that does not cancel, changes its velocity and deforms it.",
    criterion="After some 10^4 steps and 200 cells, v = (0.37, -0.21, 0.11), and likewise starting on a node and meeting nodes exactly: "
    "x = x0 + v t, v constant, F = 1 and no stress, each to 1e-12.",
    source="Free flight of a mass point: Newton's first law. Small nodal masses: Sulsky, Zhou and Schreyer (1995), "
    "doi:10.1016/0010-4655(94)00170-7",
    dim=3,
    measure=measure,
    material=True,
)
