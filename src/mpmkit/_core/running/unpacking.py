"""Fields of all bodies as a result file keeps them, taken from the packed buffers without copies in between."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from mpmkit._core.composing.layout import LANES
from mpmkit._core.running.store import AT_ONCE, BodyStore, components_of

LARGE_FRAME = 32 << 20
"""Bytes of a frame from which on no copy of all of it is made."""
_ROWS = 1 << 15
"""Rows of a piece."""


def unpack(stores: Sequence[BodyStore], name: str, dtype: Any) -> Any:
    """One field of all bodies, body after body, each in the order of its points.

    Parameters
    ----------
    stores : sequence of BodyStore
        The bodies.
    name : str
        A field that all of them have, or that can be derived.
    dtype : type
        Of the result.

    Returns
    -------
    array (n,) or (n, components)
        Vectors have three components in every dimension.
    """
    width = components_of(name, stores[0])
    out = np.zeros((sum(s.n for s in stores), width), dtype=dtype)
    first = 0
    for s in stores:
        rows = out[first : first + s.n]
        if s.has(name):
            _stored(s, name, rows)
        else:
            value = s.get(name).reshape(s.n, -1)
            rows[:, : value.shape[1]] = value
        first += s.n
    return out if width > 1 else out[:, 0]


def unpack_pieces(stores: Sequence[BodyStore], name: str, dtype: Any) -> Iterator[Any]:
    """The rows of `unpack`, some at a time: memory for a piece, for a little more time, since the particles of a piece lie scattered."""
    for s in stores:
        place = np.empty(s.n, s.ids.dtype)
        place[s.ids] = np.arange(s.n, dtype=s.ids.dtype)
        for first in range(0, s.n, _ROWS):
            tile, lane = np.divmod(place[first : first + _ROWS], LANES)
            there = np.zeros(s.tiles, bool)
            there[tile] = True
            number = np.cumsum(there) - 1
            yield unpack([s.some(np.flatnonzero(there))], name, dtype)[number[tile] * LANES + lane]


def _stored(store: BodyStore, name: str, out: Any) -> None:
    layout = store.layout
    field, stored = layout.fields.get(name) or layout.derived[name], layout.stored(name)
    width = out.shape[1]
    one = np.zeros(width, dtype=out.dtype)
    if field.initial and field.shape == "tensor":
        one[[0, 4, 8]] = field.initial
    # a row is moved as one thing of that many bytes: twice as fast as number by number
    row = np.dtype((np.void, width * out.itemsize))
    places = out.view(row).reshape(-1)
    for tile in range(0, store.tiles, AT_ONCE):
        ids = store.ids[tile * LANES : (tile + AT_ONCE) * LANES]
        found = store.tiles_of(name, tile, tile + AT_ONCE).astype(out.dtype).transpose(0, 2, 1).reshape(-1, len(stored))
        if len(stored) < width:
            rows = np.tile(one, (len(found), 1))
            rows[:, list(stored)] = found
            found = rows
        # a single tile is turned without a copy, and then its rows are no rows in memory
        places[ids] = np.ascontiguousarray(found[: len(ids)]).view(row).reshape(-1)
