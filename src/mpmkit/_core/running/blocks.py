"""The blocks a body's particles are in, in the order in which they are worked on."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from mpmkit._core.running.lattice import Lattice

_PARTS = 4  # pieces of work for each thread and colour: enough for one that is late
_ENTRY = 16  # what entering and leaving a block costs, in particles


class BodyBlocks:
    """Blocks of one body, sorted by colour, then by x, y, z.

    The colour of a block is made of the parities of its first min(dim, 2) coordinates. A unit is the run of blocks of one colour with
    the same first min(dim, 2) coordinates. The arenas of two units of one colour share no node, so units may be worked on at the same
    time, by any thread: the sums at the nodes, to the last bit, do not depend on who did what.

    Attributes
    ----------
    count : int
        Number of blocks.
    numbers : int64[count]
        Their numbers in the lattice.
    coords : int64[count, 3]
        Their coordinates; the first node of block b along axis a is coords[b, a] B, counted from the first ghost node.
    starts : int64[count + 1]
        The particles of block b are starts[b] to starts[b + 1] - 1.
    colours : int64[2^min(dim, 2) + 1]
        The blocks of colour c are colours[c] to colours[c + 1] - 1.
    units : int64[number of units + 1]
        The blocks of unit u are units[u] to units[u + 1] - 1.
    home : int32[count 3^dim]
        Where the field of this body stores the blocks around each block: those before, at and after it along each axis, last axis
        fastest. Written by `SparseNodes.update`.
    edge : uint8[count]
        1 if a particle of the block may have nodes outside the domain, also after it has moved by a cell.
    version : int
        Counts the changes of the set of blocks (not of `starts`).
    """

    def __init__(self, lattice: Lattice) -> None:
        self.lattice = lattice
        self.version = 0
        self.home: Any = np.zeros(0, dtype=np.int32)
        self.numbers: Any = np.zeros(0, dtype=np.int64)
        self.set(np.zeros(0, dtype=np.int64), np.zeros(1, dtype=np.int64))

    @classmethod
    def from_saved(cls, lattice: Lattice, coords: Any, starts: Any) -> BodyBlocks:
        """The structure as it was when `coords` and `starts` were saved; everything else follows from them."""
        blocks = cls(lattice)
        blocks.set(lattice.numbers(np.asarray(coords, dtype=np.int64).reshape(-1, 3)), np.array(starts, dtype=np.int64))
        return blocks

    def order(self, numbers: Any) -> Any:
        """Numbers by which to sort blocks: colour first, then x, y, z."""
        lattice = self.lattice
        if lattice.dim == 1:
            return (numbers - 1 & 1) * lattice.size + numbers
        x, rest = np.divmod(numbers, lattice.strides[0])
        y = rest // lattice.strides[1]
        return ((x - 1 & 1) * 2 + (y - 1 & 1)) * lattice.size + numbers

    def set(self, numbers: Any, starts: Any) -> None:
        """Take over blocks that are in order; what depends on them alone is made again only if they have changed."""
        self.starts = starts
        self._cuts: dict[tuple[int, bool], list[list[tuple[int, int]]]] = {}
        if self.version and np.array_equal(numbers, self.numbers):
            return
        lattice, pencil = self.lattice, min(self.lattice.dim, 2)
        self.version += 1
        self.numbers, self.count = numbers, len(numbers)
        self.coords = lattice.coords(numbers)
        parity = self.coords[:, :pencil] & 1
        colour = parity[:, 0] if pencil == 1 else 2 * parity[:, 0] + parity[:, 1]
        self.colours = np.searchsorted(colour, np.arange(2**pencil + 1))
        line = numbers // lattice.strides[pencil - 1]  # the same for all blocks of a unit, different for two that follow each other
        new = np.flatnonzero(line[1:] != line[:-1]) + 1
        self.units = np.concatenate(([0], new, [self.count])) if self.count else np.zeros(1, dtype=np.int64)
        first = self.coords[:, : lattice.dim] * lattice.B - lattice.ghosts  # of the grid's nodes
        last = first + lattice.B - 1
        self.edge = ((first - 1 < 0) | (last + 1 > lattice.cells - (lattice.n - 1))).any(axis=1).astype(np.uint8)

    def chunks(self, threads: int) -> list[list[tuple[int, int]]]:
        """For each colour, ranges of blocks (first, last + 1) made of whole units and of similar work, about four for each thread."""
        return self._cut(threads, whole_units=True)

    def ranges(self, threads: int) -> list[tuple[int, int]]:
        """Ranges of blocks of similar work, for loops that write to no node: cut between any two blocks, colours have no meaning."""
        return self._cut(threads, whole_units=False)[0]

    def _cut(self, threads: int, whole_units: bool) -> list[list[tuple[int, int]]]:
        key = (threads, whole_units)
        if key not in self._cuts:
            edges = self.colours.tolist() if whole_units else [0, self.count]
            parts = 1 if threads == 1 else _PARTS * threads
            self._cuts[key] = [self._split(a, b, parts, whole_units) for a, b in pairwise(edges)]
        return self._cuts[key]

    def _split(self, first: int, last: int, parts: int, whole_units: bool) -> list[tuple[int, int]]:
        if first == last:
            return []
        if parts == 1:
            return [(first, last)]
        if whole_units:
            low, high = np.searchsorted(self.units, (first, last))
            at = self.units[low : high + 1]
        else:
            at = np.arange(first, last + 1)
        work = self.starts[at] + _ENTRY * at
        goals = work[0] + (work[-1] - work[0]) * np.arange(1, parts) // parts
        cuts = np.unique(np.concatenate(([0], np.searchsorted(work, goals), [len(at) - 1])))
        bounds = at[cuts].tolist()
        return list(pairwise(bounds))
