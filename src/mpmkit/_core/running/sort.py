"""Sorts the particles of a body by block and cell, with the functions of the generated module."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from mpmkit._core.running.blocks import BodyBlocks
from mpmkit._core.running.lattice import Lattice
from mpmkit.errors import StabilityError

KEPT = 1 << 20  # bytes of an array that is kept from sort to sort; the memory of larger ones may serve others in between
_BUDGET = 2  # numbers for each particle that may wait aside at a time; components that do not fit go in a further sweep

Task = Callable[[], object]


class Particles(Protocol):
    """What of a body's store is needed here."""

    P: Any
    n: int
    layout: Any


class Scratch:
    """Arrays that a sort works in; bodies that are sorted one after the other share them."""

    def __init__(self) -> None:
        self._arrays: dict[str, Any] = {}

    def take(self, name: str, size: int, dtype: Any) -> Any:
        """An array of at least this size, with any content."""
        array = self._arrays.get(name)
        if array is None or array.size < size or array.dtype != dtype:
            array = self._arrays[name] = np.empty(size, dtype=dtype)
        return array

    def shrink(self) -> None:
        """Let go of large arrays: sorts are many steps apart, and getting such memory anew takes a hundredth of a sort."""
        self._arrays = {name: array for name, array in self._arrays.items() if array.nbytes <= KEPT}


def sort_body(
    module: Any,
    store: Particles,
    lattice: Lattice,
    blocks: BodyBlocks,
    scratch: Scratch,
    ids: Any = None,
    threads: int = 1,
    run: Callable[[Sequence[Task]], object] | None = None,
) -> bool:
    """Sort a body's particles and find its blocks.

    Parameters
    ----------
    module : module
        With the functions of `mpmkit._core.composing.sorting` for this lattice.
    store : Particles
        Buffer, number of particles and layout of the body; the buffer is reordered in place.
    lattice : Lattice
        The blocks of the domain.
    blocks : BodyBlocks
        Set to the new structure; its `home` is up to date after the next `SparseNodes.update`.
    scratch : Scratch
        Arrays to work in.
    ids : int array of n, optional
        Numbers of the particles, reordered in the same way.
    threads : int
        How many tasks may run at a time.
    run : callable, optional
        Runs independent tasks, at the same time or one after the other, and returns when all are done. Needed for more than one thread.

    Returns
    -------
    bool
        Whether any particle has changed its place.

    Raises
    ------
    StabilityError
        If a particle is below a lower face of the domain, or its position is not a number.
    """
    n = store.n
    whole = np.int32 if n * lattice.nodes_per_block < 2**31 else np.int64
    key = scratch.take("key", n, whole)
    numbers = _find(module, store, lattice, blocks, scratch, key)
    by = np.argsort(blocks.order(numbers))
    source, place = scratch.take("source", n, whole), scratch.take("place", n, whole)
    first = scratch.take("first", len(numbers) * lattice.nodes_per_block, whole)
    starts, changed = np.empty(len(numbers) + 1, dtype=np.int64), np.empty(2, dtype=np.int64)
    module.order_particles(n, by, key, first, starts, source, place, changed)
    blocks.set(numbers[by], starts)
    low, high = changed.tolist()
    if low >= high:
        return False
    slots = module.assign_slots(source, place, key, low, high)
    _move(module, store, source, place, slots, (low, high), threads, run)
    if ids is not None:
        ids[low:high] = ids[source[low:high]]
    return True


def _find(module: Any, store: Particles, lattice: Lattice, blocks: BodyBlocks, scratch: Scratch, key: Any) -> Any:
    """Numbers of the blocks, in the order the particles meet them."""
    size = max(64, blocks.count + blocks.count // 2)
    first_x, offset = store.layout.start["x"], lattice.dtype(lattice.offset)
    geometry = (lattice.lower, lattice.inv_h, offset, lattice.cells, lattice.ghosts, lattice.shape, lattice.table)
    while True:
        found = scratch.take("found", size, np.int64)
        count = module.find_blocks(store.P, store.n, store.layout.size, first_x, *geometry, key, found)
        if count >= 0:
            return found[:count].copy()
        if count < -1:
            raise StabilityError(_outside(store, lattice, -2 - count))
        size = 2 * found.size


def _outside(store: Particles, lattice: Lattice, p: int) -> str:
    tiled = store.P.reshape(-1, store.layout.size, 16)
    start = store.layout.start["x"]
    x = ", ".join(f"{v:.6g}" for v in tiled[p // 16, start : start + lattice.dim, p % 16])
    return (
        f"particle {p} (in sorted order): x = ({x}) m is below the domain, which starts at {lattice.grid.lower} m, or is not a number. "
        "To fix: enlarge the grid, put a Wall or Symmetry on that face, or lower cfl"
    )


def _move(
    module: Any,
    store: Particles,
    source: Any,
    slot: Any,
    slots: int,
    span: tuple[int, int],
    threads: int,
    run: Callable[[Sequence[Task]], object] | None,
) -> None:
    """All components to their new places; each task moves some of them, with memory of its own."""
    R = store.layout.size
    at_once = min(R, max(threads, _BUDGET * store.n // max(1, slots)))  # components that are under way at a time
    sweeps = -(-R // at_once)
    tasks = threads if run is not None and threads > 1 else 1
    width = -(-R // (sweeps * tasks))
    spare = np.empty((tasks, slots * width), dtype=store.P.dtype)  # not kept: the first sort needs much more than the others
    pieces = [(k, min(R, k + width)) for k in range(0, R, width)]

    def task(part: Any, k0: int, k1: int) -> Task:
        return lambda: module.move_particles(store.P, R, source, slot, part, k0, k1, *span)

    for j in range(0, len(pieces), tasks):
        together = [task(part, *piece) for part, piece in zip(spare, pieces[j : j + tasks], strict=False)]
        if run is not None and len(together) > 1:
            run(together)
        else:
            for one in together:
                one()
