"""Random admissible arguments for the kernels of each kind of component."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from mpmkit.interfaces import Component
from mpmkit.testing.element import advance, exponential, start

RATE = 1.0
"""Size of the velocity gradients that are tried [1/s]; with time steps of about 1e-3 s strains stay small in a step."""


def sample(component: Component, rng: Any) -> dict[str, Any]:
    """Everything that a kernel of this component may ask for beside its parameters, at one random point."""
    maker = MAKERS.get(component.kind)
    given = maker(component, rng) if maker else {}
    # how a transfer weighs velocities is known when a scene is composed: it sees nothing that changes from step to step or place to place
    return given if component.kind == "transfer" else standard(rng) | given


def vector(rng: Any, size: float = 1.0) -> tuple[float, ...]:
    """Three random numbers."""
    return tuple((size * rng.uniform(-1.0, 1.0, 3)).tolist())


def unit(rng: Any) -> tuple[float, ...]:
    """A random direction."""
    n = rng.normal(size=3)
    return tuple((n / np.linalg.norm(n)).tolist())


def standard(rng: Any) -> dict[str, Any]:
    """The standard particle fields, of a small particle near the origin, and the arguments every kernel may ask for."""
    F = exponential(0.1 * rng.uniform(-1.0, 1.0, (3, 3)))
    J = float(np.linalg.det(F))
    return {
        "x": vector(rng),
        "X": vector(rng),
        "v": vector(rng),
        "m": 2.0,
        "V0": 1e-3,
        "V": 1e-3 * J,
        "rho": 2.0 / (1e-3 * J),
        "F": tuple(F.ravel().tolist()),
        "J": J,
        "L": tuple((RATE * rng.uniform(-1.0, 1.0, 9)).tolist()),
        "C": tuple((RATE * rng.uniform(-1.0, 1.0, 9)).tolist()),
        "stress": tuple((1e3 * rng.uniform(-1.0, 1.0, 6)).tolist()),
        "q": float(rng.uniform(0.0, 1e3)),
        "size": (0.05, 0.05, 0.05),
        "c": float(rng.uniform(10.0, 1000.0)),
        "t": float(rng.uniform(0.0, 1.0)),
        "dt": 1e-3,
        "h": 0.1,
        "dim": 3.0,
    }


def _material(component: Any, rng: Any) -> dict[str, Any]:
    """A point of the material after a first step, so that stress and state belong together."""
    F = exponential(0.05 * rng.uniform(-1.0, 1.0, (3, 3)))
    point = start(component, F, 1e-3)
    point["L"] = tuple((50.0 * rng.uniform(-1.0, 1.0, 9)).tolist())
    advance(component, component.stress, point)
    return point


def _shape(component: Any, rng: Any) -> dict[str, Any]:
    return {"f": float(component.offset + rng.uniform()), "half": float(component.max_half * rng.uniform(0.05, 1.0))}


def _contact(component: Any, rng: Any) -> dict[str, Any]:
    masses = {"m_a": float(rng.uniform(0.1, 2.0)), "m_b": float(rng.uniform(0.1, 2.0))}
    return masses | {"v_a": vector(rng), "v_b": vector(rng), "normal": unit(rng), "gap": float(rng.uniform(-0.01, 0.01))}


def _boundary(component: Any, rng: Any) -> dict[str, Any]:
    values = {"value": vector(rng), "traction": vector(rng, 1e3), "normal": unit(rng), "dv_n": float(rng.uniform(0.0, 1.0))}
    return values | {"area": 0.01, "arm0": vector(rng, 0.05)}


def _transfer(component: Any, rng: Any) -> dict[str, Any]:
    return {name: float(rng.uniform(-1.0, 1.0)) for name in ("v", "v_grid", "dv_grid", "v_smooth")}


def _effect(component: Any, rng: Any) -> dict[str, Any]:
    return {"value": vector(rng)}


MAKERS: dict[str, Callable[[Any, Any], dict[str, Any]]] = {
    "material": _material,
    "shape": _shape,
    "contact": _contact,
    "boundary": _boundary,
    "transfer": _transfer,
    "effect": _effect,
}
