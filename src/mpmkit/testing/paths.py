"""Paths of deformation for the checks of constitutive models, and the scales of what is found on them."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from mpmkit.interfaces import ConstitutiveModel
from mpmkit.testing.element import Array, drive

SLOW = 1e6
"""A time step [s] so long that viscous stress does not count beside elastic stress."""


def modulus(material: ConstitutiveModel) -> float:
    """The scale of all stresses: rho c^2 at the start [Pa]."""
    return material.rho * float(drive(material, np.eye(3)[None]).wave_speed[0]) ** 2


def random_stretch(rng: Any, size: float) -> Array:
    """Matrix of small random entries."""
    return np.asarray(size * rng.uniform(-1.0, 1.0, (3, 3)))


def turned(rng: Any, A: Array) -> Array:
    """Q A Q^T with a random rotation Q."""
    Q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return np.asarray(Q @ A @ Q.T)


def round_trip(rng: Any, size: float, steps: int = 200) -> Array:
    """Path that loads, unloads beyond the start and comes back."""
    A = random_stretch(rng, size)
    s = np.concatenate([np.linspace(0, 1, steps), np.linspace(1, -1, 2 * steps)[1:], np.linspace(-1, 0, steps)[1:]])
    return np.asarray(np.eye(3) + s[:, None, None] * A)


def has(*names: str) -> Any:
    """Condition: the law supplies these kernels."""
    return lambda material: all(getattr(material, name) is not None for name in names)


def energy_of_deformation(material: ConstitutiveModel) -> bool:
    """Condition: stored energy is a function of F or J alone."""
    return material.energy is not None and not {"stress", "L", *(f.name for f in material.state)} & set(material.energy.arguments)


def wander(rng: Any, size: float, legs: int = 5, steps: int = 60) -> Array:
    """Path that goes straight from one random deformation to the next, loading, unloading and turning, and ends at the start."""
    corners = [np.eye(3), *(np.eye(3) + random_stretch(rng, size) for _ in range(legs)), np.eye(3)]
    s = np.linspace(0.0, 1.0, steps + 1)[1:, None, None]
    return np.concatenate([np.eye(3)[None], *(a + s * (b - a) for a, b in pairwise(corners))])
