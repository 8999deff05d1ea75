"""What measures of error see of a run: particles at some instants, fields by name with their components."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np

from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.fields import PARTICLE_FIELDS

UNITS = {"u": "m"} | {name: f.unit for name, f in PARTICLE_FIELDS.items()}
ALIASES = {"displacement": "u", "velocity": "v", "position": "x"}
SHAPES = {"u": "vector"} | {name: f.shape for name, f in PARTICLE_FIELDS.items()}
COMPONENTS = {
    "scalar": (),
    "vector": ("x", "y", "z", "r"),
    "symmetric": ("xx", "yy", "zz", "xy", "yz", "xz", "rr", "tt"),
    "tensor": ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"),
}
RADIAL = ("r", "rr", "tt")
"""Components along the radius from a centre, and around it ("tt")."""
POINT = ("x", "V0", "m")
"""Fields that are always read: places, and weights."""


@attrs.frozen
class Sample:
    """Particles at one instant.

    Attributes
    ----------
    t, dt : float
        Simulated time [s], and the length of the steps that led there [s], not shortened to land on t.
    space : str
        As in `Grid.space`.
    start : dict
        Positions at the start of each body, float64[n, dim] [m].
    bodies : dict
        Fields of each body: name -> array, as `Simulation.particles` gives them.
    """

    t: float
    dt: float
    space: str
    start: Mapping[str, Any]
    bodies: Mapping[str, Mapping[str, Any]]


def parse(field: str) -> tuple[str, str]:
    """A field as in "stress.xx" -> ("stress", "xx"); without a component ("stress", "").

    Raises
    ------
    ParameterError
        If there is no such field or component.
    """
    base, _, component = field.partition(".")
    base = ALIASES.get(base, base)
    if base not in SHAPES:
        raise ParameterError(f"no field is named {base!r}{did_you_mean(base, [*SHAPES, *ALIASES])} (known: {', '.join(SHAPES)})")
    known = COMPONENTS[SHAPES[base]]
    if component and component not in known:
        told = ", ".join(known) or "no components"
        raise ParameterError(f"{base} has no component {component!r}{did_you_mean(component, known)} (it has {told})")
    return base, component


def stored(base: str) -> str:
    """The field that a simulation keeps for one that measures ask for: displacements come from positions."""
    return {"u": "x", "X": "x"}.get(base, base)


def field_of(sample: Sample, body: str, base: str) -> Any:
    """A field in full: (n,), (n, dim), (n, 6) or (n, 9), float64."""
    if base == "X":
        return np.asarray(sample.start[body], float)
    values = np.asarray(sample.bodies[body][stored(base)], float)
    return values - sample.start[body] if base == "u" else values


def component_of(values: Any, base: str, component: str, X: Any, centre: tuple[float, ...], space: str) -> Any:
    """One component, (n,).

    Raises
    ------
    ParameterError
        If the space has no such component.
    """
    shape = SHAPES[base]
    if component not in RADIAL:
        k = COMPONENTS[shape].index(component)
        if k >= values.shape[1]:
            raise ParameterError(f"{base} has no component {component!r} in a {space} scene")
        return values[:, k]
    if space == "axisymmetric":
        return values[:, {"r": 0, "rr": 0, "tt": 2}[component]]
    offset = X - np.resize(np.asarray(centre, float), X.shape[1])
    n = offset[:, :2] / np.maximum(np.linalg.norm(offset[:, :2], axis=1, keepdims=True), 1e-300)
    if component == "r":
        return (values[:, :2] * n).sum(axis=1)
    nx, ny = (n[:, 0], n[:, 1]) if component == "rr" else (-n[:, 1], n[:, 0])
    return values[:, 0] * nx**2 + values[:, 1] * ny**2 + 2.0 * values[:, 3] * nx * ny


def size_of(values: Any, base: str) -> Any:
    """Magnitude of each particle's scalar, vector or tensor; the shears of a symmetric tensor count twice."""
    if values.ndim == 1:
        return np.abs(values)
    weights = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0]) if SHAPES[base] == "symmetric" else 1.0
    return np.sqrt((weights * values**2).sum(axis=1))


def weights_of(sample: Sample, body: str) -> Any:
    """Share of each particle in a mean: its volume at the start, or mass where volumes are not kept."""
    fields = sample.bodies[body]
    return np.asarray(fields["V0"] if "V0" in fields else fields.get("m", np.ones(len(fields["x"]))), float)
