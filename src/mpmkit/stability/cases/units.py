"""The same problem in other units."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import rounding, run

SI, MILLI = (1.0, 1.0, 1.0), (1e3, 1e3, 1e3)
"""Units of length, time and mass in one metre, second and kilogram: metre, second, kilogram; millimetre, millisecond, gram."""
L, E, RHO, SPEED = 0.4, 1e6, 1000.0, 1.0


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """A block with a velocity that differs from place to place hits a wall; compared at the same physical time."""
    one, other = fly(composition, SI, quick), fly(composition, MILLI, quick)
    return [
        Figure(
            f"difference of {name}", float(np.abs(one[name] - other[name]).max() / np.abs(one[name]).max()), rounding(composition, 1e-10)
        )
        for name in one
    ]


def fly(composition: Composition, units: tuple[float, float, float], quick: bool) -> dict[str, np.ndarray]:
    """Positions, velocities and stresses at the end, in SI."""
    from mpmkit.boundaries import Wall
    from mpmkit.materials import NeoHookean

    m, s, kg = units
    pascal = kg / (m * s * s)
    grid = mpm.Grid((0.0, 0.0), (1.0 * m, 1.0 * m), 0.1 * m)
    sim = simulation(composition, grid)
    block = mpm.Body(mpm.Box((0.13 * m, 0.05 * m), (0.53 * m, 0.45 * m)), NeoHookean(E=E * pascal, nu=0.3, rho=RHO * kg / m**3))
    points = block.sample(grid)
    x, y = np.asarray(points.x).T / m
    v = SPEED * np.column_stack([np.sin(7.0 * y), -1.0 + 0.5 * np.cos(9.0 * x)]) * m / s
    sim += mpm.Body.from_arrays(points.x, points.V0, block.material, v=v, name="block")
    sim += Wall("ymin", "slip")
    run(sim, (0.02 if quick else 0.1) * s)
    end = sim.particles("block")
    return {"position": np.array(end["x"]) / m, "velocity": np.array(end["v"]) * s / m, "stress": np.array(end["stress"]) / pascal}


CASE = Case(
    name="units",
    title="A block hits a wall, in metres, seconds and kilograms and in millimetres, milliseconds and grams",
    failure="Absolute thresholds (a smallest mass, a smallest speed, a tolerance in metres) that mean something else in other units.",
    criterion="Positions, velocities and stresses agree to 1e-10 of the largest.",
    source="Dimensional analysis; tolerance of rounding in some hundred steps.",
    dim=2,
    measure=measure,
)
