"""Functions that studies in tests name: a scene, a solution, a quantity."""

from __future__ import annotations

from typing import Any

import numpy as np
from small_scenes import bar

import mpmkit as mpm
from mpmkit.exact import VibratingBar


def swinging(N: int = 8, shape: Any = None, shift: bool = False) -> mpm.Simulation:
    """A bar that starts with the velocity of its first mode."""
    exact = solution()
    sim = bar(mpm.boundaries.Wall("xmin", "no slip"), n=N, v=lambda X: exact.velocity(X, 0.0) + 0.05 * shift, shape=shape)
    sim.until = 0.5
    return sim


def solution() -> VibratingBar:
    """The exact swing."""
    return VibratingBar(L=1.0, E=1.0, rho=1.0, v0=1e-3)


def broken(N: int = 8) -> mpm.Simulation:
    """No scene for odd N."""
    if N % 2:
        raise RuntimeError("odd")
    return swinging(N)


def tip(facts: Any) -> float:
    """Displacement of the last particle."""
    return float(np.max(facts.samples[-1].bodies["bar"]["x"]) - np.max(facts.samples[0].bodies["bar"]["x"]))
