"""Rubber crushed to a twentieth of its volume, or flat in one direction, and let go."""

from __future__ import annotations

from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import at_most, momentum_error, rounding, run
from mpmkit.stability.cases._tubes import WAVE, rubber

SMALL, ANGLE = 0.05, 30.0  # least stretch; degrees
SIDE = 0.5  # of a particle at rest, in cells
COURANT = 0.1  # at most: the error of the energy is proportional to the time step
DRIFT = 0.022
"""Largest loss of energy. Stresses and velocities are known half a step apart, and the energy is set free while a wave runs from the
edge to the middle: half a step of this Courant number is 0.022 of that time for 40 particles at J = 0.05 (4.5 cells)."""
FASTEST = 3.0
"""Of the free edge, over the wave speed: a rarefaction into nothing gives it 2.28, sqrt((1 + J^-2) / 2) integrated from J = 0.05 to 1."""


def block(composition: Composition, F: Any, per_side: tuple[int, int]) -> mpm.Simulation:
    """A rectangle of so many particles, deformed by F, with room for the edges to fly as far as they can until it ends."""
    n = np.array(per_side)
    index = np.stack(np.meshgrid(*[np.arange(k) - 0.5 * (k - 1) for k in n], indexing="ij"), -1).reshape(-1, 2)
    x = SIDE * index @ F.T
    lower = -float(np.ceil(np.abs(x).max() + FASTEST * duration(per_side) * WAVE) + 6.0)
    sim = simulation(at_most(composition, COURANT), mpm.Grid((lower, lower), (-lower, -lower), 1.0))
    full = np.eye(3)
    full[:2, :2] = F
    sim += mpm.Body.from_arrays(x, SIDE * SIDE, rubber(), F=full, size=(0.5 * SIDE, 0.5 * SIDE), name="block")
    return sim


def duration(per_side: tuple[int, int]) -> float:
    """Time until the run ends [s]: a transit of small waves through half the shorter side at rest."""
    return 0.5 * min(per_side) * SIDE / WAVE


def released(composition: Composition, F: Any, per_side: tuple[int, int]) -> list[Figure]:
    """Let go at rest; figures until the end."""
    sim = block(composition, F, per_side)
    least = np.inf
    for t in np.linspace(0.0, duration(per_side), 11)[1:]:
        least = min(least, float(run(sim, float(t)).particles("block")["J"].min()))
    history, p = sim.history, sim.particles("block")
    energy = history["energy"]
    finite = all(np.isfinite(p[f]).all() for f in ("x", "v", "F", "stress"))
    return [
        Figure("energy gained", max(0.0, float(energy.max() / energy[0] - 1.0)), 0.01),
        Figure("energy lost", max(0.0, float(1.0 - energy.min() / energy[0])), DRIFT),
        Figure("particles inverted or not finite (1: yes)", float(not (least > 0.0 and finite)), 0.0),
        Figure("change of the momentum", momentum_error(sim, WAVE), rounding(composition, 1e-10)),
    ]


def volume(composition: Composition, quick: bool) -> list[Figure]:
    """J = 0.05, as much in both directions."""
    n = 40 if quick else 80
    return released(composition, np.sqrt(SMALL) * np.eye(2), (n, n))


def rank_one(composition: Composition, quick: bool) -> list[Figure]:
    """Flat in a direction oblique to the grid: one singular value of F is 0.05, the other 1."""
    n = 24 if quick else 48
    c, s = np.cos(np.radians(ANGLE)), np.sin(np.radians(ANGLE))
    R = np.array([[c, -s], [s, c]])
    return released(composition, R @ np.diag([1.0, SMALL]) @ R.T, (n, 4 * n))


CRITERION = (
    "With a Courant number of at most 0.1: J > 0 and finite always; at most 1 % of the first energy gained, and 2.2 % lost, which is half "
    "a step over the time in which it is set free (the error is proportional to the step: 1 % here, and 4 to 6 % at 0.4); "
    "momentum to rounding."
)
CASES = (
    Case(
        name="crushed",
        title="Rubber crushed to J = 0.05, and let go",
        failure="ln J and 1 / J grow without bound: one step too long and J is negative or not a number, which spreads to all.",
        criterion=CRITERION,
        source="Thread 8260 of taichi (singular values of F that vanish); conservation of energy",
        dim=2,
        measure=volume,
    ),
    Case(
        name="rank-one-collapse",
        title="Rubber pressed flat to a twentieth, oblique to the grid, and let go",
        failure="One singular value of F nearly vanishes, the other is one: a time step from the volume alone is too long, and shear "
        "terms of rounding size become large against the small stretch.",
        criterion=CRITERION,
        source="Thread 8260 of taichi (singular values of F that vanish); conservation of energy",
        dim=2,
        measure=rank_one,
    ),
)
