"""The particles of one body in memory: one packed buffer, seen from outside as plain arrays."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from typing import Any

import attrs
import numpy as np

from mpmkit._core.composing.composition import Group
from mpmkit._core.composing.layout import LANES
from mpmkit._core.composing.sizes import half_sizes
from mpmkit.fields import PARTICLE_FIELDS


def aligned(n: int, dtype: type) -> Any:
    """Zeros whose first element begins a cache line of 64 bytes, so that no tile of 16 lanes shares one with another."""
    itemsize = np.dtype(dtype).itemsize
    whole: Any = np.zeros(n + 64 // itemsize, dtype=dtype)
    first = (-whole.ctypes.data % 64) // itemsize
    return whole[first : first + n]


AT_ONCE = 2048
"""Tiles that are copied at a time: what passes through stays in the processor's cache, and bodies may be large."""
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
        Computes one of the layout's derived fields of a store in a range of tiles of 16 particles; given by the engine.
    ids : int32[n] or int64[n]
        Which particle, in the order of the body's points, lies at each place of the buffer; the buffer is sorted by place in space.
    begun : int
        Number of particles at the start; `n` becomes less when some are taken out.
    kept : int array of n, or None
        Which of the body's points the particles are, once some have been taken out; numbers of particles count only those that are there.
    """

    def __init__(self, group: Group, name: str, points: Any, rho: float, dtype: type) -> None:
        self.group, self.name, self.begun = group, name, len(points.x)
        self.layout = group.layout
        self._whole: Any = aligned(-(-self.begun // LANES) * LANES * self.layout.size, dtype)
        self._whole_ids: Any = np.arange(self.begun, dtype=np.int32 if self.begun < 2**31 else np.int64)
        self.kept: Any = None
        self._resize(self.begun)
        self.points = points
        self.operator: tuple[Any, ...] = ()
        self.derive: Callable[[BodyStore, str, int, int], Any] = _not_running
        with np.errstate(over="ignore"):  # masses that are infinite are refused with the numbers that they come from
            m = (rho * points.V0).astype(dtype)
        initial: dict[str, Any] = {"x": points.x, "X": points.x, "v": points.v, "V0": points.V0, "m": m}
        initial |= {"size": points.size, "size_now": points.size}
        if getattr(points, "F", None) is not None:
            F = np.asarray(points.F).reshape(self.n, 9)
            initial |= {"F": F, "J": np.linalg.det(F.reshape(-1, 3, 3)), "size_now": half_sizes(points.size, F)}
        if getattr(points, "stress", None) is not None:
            initial["stress"] = points.stress
        for name_, field in self.layout.fields.items():
            if name_ in initial:
                self.set(name_, initial[name_])
            elif field.initial:
                one = np.zeros(FULL[field.shape])
                diagonal = {"tensor": (0, 4, 8), "symmetric": (0, 1, 2)}.get(field.shape, range(FULL[field.shape]))
                one[list(diagonal)] = field.initial
                one = one[: self.layout.dim] if field.shape == "vector" else one
                self.set(name_, np.broadcast_to(one, (self.n, one.size)))

    def release(self) -> None:
        """Let go of the sampled state but for the sizes, which result files ask for: it may be half as large as the buffer."""
        none = np.zeros((0, self.layout.dim))
        self.points = attrs.evolve(self.points, x=none, v=none, V0=none[:, 0], F=None, stress=None)

    # --- particles that are taken out ---------------------------------------------------------------------------
    def _resize(self, n: int) -> None:
        """Use the first part of the memory that there was for all."""
        self.n, self.tiles = n, -(-n // LANES)
        self.P, self.ids = self._whole[: self.tiles * LANES * self.layout.size], self._whole_ids[:n]

    def points_now(self) -> Any:
        """Which of the body's points each particle is: int[n]."""
        return np.arange(self.n) if self.kept is None else self.kept

    def places(self) -> Any:
        """Where each of the body's points lies in the buffer, -1 if it has been taken out: int64[begun]."""
        place = np.full(self.begun, -1, dtype=np.int64)
        place[self.points_now()[self.ids]] = np.arange(self.n)
        return place

    def columns(self, name: str, places: Any) -> Any:
        """Stored components of a field at some places of the buffer: [places, components]."""
        first, count = self.layout.start[name], len(self.layout.stored(name))
        rows = first + np.arange(count)
        return self._tiled()[(places // LANES)[:, None], rows[None, :], (places % LANES)[:, None]]

    def set_columns(self, name: str, places: Any, values: Any) -> None:
        """Write what `columns` reads."""
        first, count = self.layout.start[name], len(self.layout.stored(name))
        rows = first + np.arange(count)
        self._tiled()[(places // LANES)[:, None], rows[None, :], (places % LANES)[:, None]] = values

    def packed(self, places: Any) -> Any:
        """Some particles in a buffer of their own, in the order of `places`."""
        tiles = -(-len(places) // LANES)
        buffer = aligned(tiles * LANES * self.layout.size, self.P.dtype.type)
        there = np.arange(len(places))
        buffer.reshape(tiles, self.layout.size, LANES)[there // LANES, :, there % LANES] = self._tiled()[places // LANES, :, places % LANES]
        return buffer

    def some(self, tiles: Any) -> BodyStore:
        """The particles of some tiles (their numbers, ascending) in a store of its own, to read their fields in the order of the places."""
        other, n = copy.copy(self), len(tiles) * LANES - (self.tiles * LANES - self.n) * int(tiles[-1] == self.tiles - 1)
        other._whole, other._whole_ids = (
            aligned(len(tiles) * LANES * self.layout.size, self.P.dtype.type),
            np.arange(n, dtype=self.ids.dtype),
        )
        other._resize(n)
        self._tiled().take(tiles, axis=0, out=other._tiled(), mode="clip")
        return other

    def remove(self, places: Any) -> None:
        """Take out the particles at some places; the last ones of the buffer fill the gaps, so it must be sorted again."""
        places = np.sort(places)
        left = self.n - len(places)
        numbers, points = np.sort(self.ids[places]), self.points_now()
        gaps = places[places < left]
        last = np.setdiff1d(np.arange(left, self.n), places, assume_unique=True)
        tiled = self._tiled()
        tiled[gaps // LANES, :, gaps % LANES] = tiled[last // LANES, :, last % LANES]
        self.ids[gaps] = self.ids[last]
        self._resize(left)
        self.ids -= np.searchsorted(numbers, self.ids).astype(self.ids.dtype)
        self.kept = np.delete(points, numbers)

    def keep(self, points: Any) -> None:
        """Have the particles of these points of the body, in their order; their fields are set afterwards."""
        if np.array_equal(points, self.points_now()):
            return
        self._resize(len(points))
        self.ids[:] = np.arange(self.n)
        self.kept = np.array(points) if self.n < self.begun else None

    def take(self, P: Any, ids: Any = None, kept: Any = None) -> None:
        """Become what was saved of `P`, `ids` and `kept`."""
        if ids is not None:
            self._resize(len(ids))
            self.ids[:] = ids
        self.kept = None if kept is None else np.array(kept)
        self.P[:] = P

    def _tiled(self) -> Any:
        return self.P.reshape(self.tiles, self.layout.size, LANES)

    def tiles_of(self, name: str, first: int = 0, last: int | None = None) -> Any:
        """The components of a field in tiles first to last as they lie in memory, (tiles, components, 16), or computed in that form."""
        last = self.tiles if last is None else min(last, self.tiles)
        if name in self.layout.derived:
            return self.derive(self, name, first, last).reshape(last - first, len(self.layout.stored(name)), LANES)
        start = self.layout.start[name]
        return self._tiled()[first:last, start : start + len(self.layout.stored(name)), :]

    def has(self, name: str) -> bool:
        """Whether `tiles_of` answers to it."""
        return name in self.layout.fields or name in self.layout.derived

    def set(self, name: str, value: Any) -> None:
        """Write a field from its full form: (n,), (n, dim), (n, 6) or (n, 9), in the order of the body's points."""
        value = np.asarray(value).reshape(self.n, -1)
        start, tiled = self.layout.start[name], self._tiled()
        for first in range(0, self.tiles, AT_ONCE):
            ids, last = self.ids[first * LANES : (first + AT_ONCE) * LANES], min(first + AT_ONCE, self.tiles)
            padded = np.zeros((last - first) * LANES, dtype=self.P.dtype)
            for k, full in enumerate(self.layout.stored(name)):
                padded[: len(ids)] = value[ids, full]
                tiled[first:last, start + k, :] = padded.reshape(-1, LANES)

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
        width = self.layout.dim if field.shape == "vector" else FULL[field.shape]
        full = np.zeros((self.n, width), dtype=self.P.dtype)
        if field.initial and field.shape == "tensor":
            full[:, [0, 4, 8]] = field.initial
        for first in range(0, self.tiles, AT_ONCE):
            ids, found = self.ids[first * LANES : (first + AT_ONCE) * LANES], self.tiles_of(name, first, first + AT_ONCE)
            for k, column in enumerate(stored):
                full[ids, column] = found[:, k, :].reshape(-1)[: len(ids)]
        return full[:, 0] if field.shape == "scalar" else full

    def pieces(self, *names: str) -> Iterator[list[Any]]:
        """Fields in the order of the buffer, some particles at a time, float64[some, components] each: for sums without copies of all."""
        for first in range(0, self.tiles, AT_ONCE):
            tiles = [self.tiles_of(name, first, first + AT_ONCE).transpose(0, 2, 1) for name in names]
            yield [one.reshape(-1, one.shape[2])[: self.n - first * LANES].astype(float) for one in tiles]

    def available(self) -> list[str]:
        """Names `get` answers to."""
        return [*self.layout.fields, *self.layout.derived, *(n for n in ("J", "V", "rho") if n not in self.layout.fields)]


def _not_running(store: BodyStore, name: str, first: int, last: int) -> Any:
    raise RuntimeError(f"{name} is computed by the generated module, which has not been loaded yet")


def components_of(name: str, store: BodyStore) -> int:
    """Number of components of a field in its full form (vectors count 3: files keep three)."""
    field = store.layout.fields.get(name) or PARTICLE_FIELDS[name]
    return FULL[field.shape]
