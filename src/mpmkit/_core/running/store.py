"""The particles of one body in memory: one packed buffer, seen from outside as plain arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from mpmkit._core.composing.composition import Group
from mpmkit._core.composing.layout import LANES
from mpmkit.fields import PARTICLE_FIELDS


def aligned(n: int, dtype: type) -> Any:
    """Zeros whose first element begins a cache line of 64 bytes, so that no tile of 16 lanes shares one with another."""
    itemsize = np.dtype(dtype).itemsize
    whole: Any = np.zeros(n + 64 // itemsize, dtype=dtype)
    first = (-whole.ctypes.data % 64) // itemsize
    return whole[first : first + n]


FULL = {"scalar": 1, "vector": 3, "symmetric": 6, "tensor": 9}


class BodyStore:
    """Buffer and layout of one body.

    Parameters
    ----------
    group : Group
        Bodies of the same law, with their layout.
    name : str
        Of the body.
    points : object
        Its sampled particles: x, v, V0, size, and F and stress if given.
    rho : float
        Reference density [kg/m^3].
    dtype : type
        Precision of the buffer.

    Attributes
    ----------
    P : array
        The packed buffer, tiles of 16 particles (see `mpmkit._core.composing.layout`).
    operator : tuple of array
        Node numbers, weights and gradients of each point, where these are stored; else empty.
    derive : callable
        Computes one of the layout's derived fields in a range of tiles of 16 particles; given by the engine.
    ids : int32[n] or int64[n]
        Which particle, in the order of the body's points, lies at each place of the buffer; the buffer is sorted by place in space.
    """

    def __init__(self, group: Group, name: str, points: Any, rho: float, dtype: type) -> None:
        self.group, self.name, self.n = group, name, len(points.x)
        self.layout = group.layout
        self.tiles = (self.n + LANES - 1) // LANES
        self.P: Any = aligned(self.tiles * LANES * self.layout.size, dtype)
        self.ids: Any = np.arange(self.n, dtype=np.int32 if self.n < 2**31 else np.int64)
        self.points = points
        self.operator: tuple[Any, ...] = ()
        self.derive: Callable[[str, int, int], Any] = _not_running
        dim = self.layout.dim
        initial: dict[str, Any] = {"x": points.x, "X": points.x, "v": points.v, "V0": points.V0, "m": rho * points.V0}
        initial |= {"size": points.size, "size_now": points.size}
        if getattr(points, "F", None) is not None:
            F = np.asarray(points.F).reshape(self.n, 9)
            initial |= {"F": F, "J": np.linalg.det(F.reshape(-1, 3, 3)), "size_now": points.size * F[:, [0, 4, 8][:dim]]}
        if getattr(points, "stress", None) is not None:
            initial["stress"] = points.stress
        for name_, field in self.layout.fields.items():
            if name_ in initial:
                self.set(name_, initial[name_])
            elif field.initial:
                one = np.zeros(FULL[field.shape])
                diagonal = {"tensor": (0, 4, 8), "symmetric": (0, 1, 2)}.get(field.shape, range(FULL[field.shape]))
                one[list(diagonal)] = field.initial
                one = one[:dim] if field.shape == "vector" else one
                self.set(name_, np.broadcast_to(one, (self.n, one.size)))

    def release(self) -> None:
        """Let go of the initial positions, which only loads of particle layers ask for again: they are a tenth of a large body's memory."""
        self.points = attrs.evolve(self.points, x=np.zeros((0, self.layout.dim)))

    def _tiled(self) -> Any:
        return self.P.reshape(self.tiles, self.layout.size, LANES)

    def tiles_of(self, name: str, first: int = 0, last: int | None = None) -> Any:
        """The components of a field in tiles first to last as they lie in memory, (tiles, components, 16), or computed in that form."""
        last = self.tiles if last is None else min(last, self.tiles)
        if name in self.layout.derived:
            return self.derive(name, first, last).reshape(last - first, -1, LANES)
        start = self.layout.start[name]
        return self._tiled()[first:last, start : start + len(self.layout.stored(name)), :]

    def has(self, name: str) -> bool:
        """Whether `tiles_of` answers to it."""
        return name in self.layout.fields or name in self.layout.derived

    def set(self, name: str, value: Any) -> None:
        """Write a field from its full form: (n,), (n, dim), (n, 6) or (n, 9), in the order of the body's points."""
        value = np.asarray(value).reshape(self.n, -1)
        start, tiled = self.layout.start[name], self._tiled()
        padded = np.zeros(self.tiles * LANES, dtype=self.P.dtype)  # one component at a time: bodies may be large
        for k, full in enumerate(self.layout.stored(name)):
            padded[: self.n] = value[self.ids, full]
            tiled[:, start + k, :] = padded.reshape(self.tiles, LANES)

    def get(self, name: str) -> Any:
        """A field in full form, in the order of the body's points; V, J and rho are derived.

        Scalars are (n,), vectors (n, dim), symmetric tensors (n, 6), tensors (n, 9).
        """
        if not self.has(name):
            if name == "J":
                return np.linalg.det(self.get("F").reshape(-1, 3, 3))
            if name == "V":
                return self.get("J") * self.get("V0")
            if name == "rho":
                return self.get("m") / self.get("V")
            raise KeyError(name)
        field = self.layout.fields.get(name) or self.layout.derived[name]
        stored = self.layout.stored(name)
        columns = self.tiles_of(name).transpose(0, 2, 1).reshape(-1, len(stored))[: self.n]
        if field.shape == "scalar":
            one = np.empty(self.n, dtype=self.P.dtype)
            one[self.ids] = columns[:, 0]
            return one
        width = self.layout.dim if field.shape == "vector" else FULL[field.shape]
        full = np.zeros((self.n, width), dtype=self.P.dtype)
        if field.initial and field.shape == "tensor":
            full[:, [0, 4, 8]] = field.initial
        for k, column in enumerate(stored):
            full[self.ids, column] = columns[:, k]
        return full

    def available(self) -> list[str]:
        """Names `get` answers to."""
        return [*self.layout.fields, *self.layout.derived, *(n for n in ("J", "V", "rho") if n not in self.layout.fields)]


def _not_running(name: str, first: int, last: int) -> Any:
    raise RuntimeError(f"{name} is computed by the generated module, which has not been loaded yet")


def components_of(name: str, store: BodyStore) -> int:
    """Number of components of a field in its full form (vectors count 3: files keep three)."""
    field = store.layout.fields.get(name) or PARTICLE_FIELDS[name]
    return FULL[field.shape]
