"""Frames of a run without a record: all fields of all bodies, at once of a small state, when they are asked for of a large one."""

from __future__ import annotations

import copy
import tempfile
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from mpmkit._core.running.snapshot import IN_MEMORY
from mpmkit._core.running.store import BodyStore


def frame(stores: list[BodyStore]) -> Mapping[str, Any]:
    """The fields that all bodies have, with body and id, in the present state of the particles.

    Parameters
    ----------
    stores : list of BodyStore
        The bodies.

    Returns
    -------
    mapping of str to array
        In the order of the bodies' points. Of more than `IN_MEMORY` bytes the packed state is kept, in temporary files, and a field
        is unpacked each time it is asked for: all fields unpacked are some three times as much.
    """
    if sum(s.P.nbytes for s in stores) > IN_MEMORY:
        return Packed(stores)
    return {name: unpacked(stores, name) for name in names(stores)}


def names(stores: list[BodyStore]) -> tuple[str, ...]:
    """Fields that all bodies have, and what a frame says beside them."""
    return (*(f for f in stores[0].available() if all(f in s.available() for s in stores)), "body", "id")


def unpacked(stores: list[BodyStore], name: str) -> Any:
    """A field of all bodies."""
    numbers = numbered(stores)
    return numbers[name] if name in numbers else np.concatenate([s.get(name) for s in stores])


def numbered(stores: list[BodyStore]) -> dict[str, Any]:
    """Body and number of each particle, int32[n] each."""
    body, ids, begun = [], [], 0
    for k, s in enumerate(stores):
        body.append(np.broadcast_to(np.int32(k), s.n))
        ids.append(np.arange(begun, begun + s.n, dtype=np.int32) if s.kept is None else (begun + s.kept).astype(np.int32))
        begun += s.begun
    return {"body": joined(body), "id": joined(ids)}


def joined(parts: list[Any]) -> Any:
    """Rows of all bodies; of a single one without a copy, since equal values may take no memory."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


class Packed(Mapping[str, Any]):
    """Fields of a state that is kept as it lay in memory."""

    def __init__(self, stores: list[BodyStore]) -> None:
        self._stores = [_kept(s) for s in stores]
        self._names = names(stores)

    def __getitem__(self, name: str) -> Any:
        if name not in self._names:
            raise KeyError(name)
        return unpacked(self._stores, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def _kept(store: BodyStore) -> BodyStore:
    """A store of the same body that stays as it is while the run goes on."""
    other = copy.copy(store)
    other.P, other.ids = _on_disk(store.P), _on_disk(store.ids)
    other.kept = None if store.kept is None else store.kept.copy()
    return other


def _on_disk(array: Any) -> Any:
    """A copy that the system reads from a temporary file when it is used; in memory if there is no room on the disk."""
    try:
        with tempfile.TemporaryFile() as file:
            array.tofile(file)
            file.flush()
            return np.memmap(file, array.dtype, "c", shape=array.shape)
    except OSError:
        return array.copy()
