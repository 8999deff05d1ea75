"""Sparse storage of a velocity field: only the blocks of nodes that particles can reach."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mpmkit._core.running.blocks import BodyBlocks
from mpmkit._core.running.lattice import Lattice

_GROWTH = 1.5


class SparseNodes:
    """Nodes of one velocity field, of one body or of several.

    Node j of stored block s is number s B^dim + j, j counting the nodes of the block with the last axis fastest; its record starts at
    ``G[(s B^dim + j) channels]``.

    Attributes
    ----------
    active : int
        Number of stored blocks.
    numbers : int64[active]
        Their numbers in the lattice, ascending.
    blocks : int64[active, 3]
        Their coordinates (-1: before the first ghost node).
    G : array
        Records of the nodes, zero after an update that changed the blocks; longer than needed, and replaced by a longer one if it must be.
    """

    def __init__(self, lattice: Lattice, channels: int, dtype: type) -> None:
        self.lattice, self.channels = lattice, channels
        self.active = 0
        self.numbers: Any = np.zeros(0, dtype=np.int64)
        self.blocks: Any = np.zeros((0, 3), dtype=np.int64)
        self.G: Any = np.zeros(0, dtype=dtype)
        self._other: Any = np.zeros(0, dtype=dtype)
        self._seen: list[tuple[BodyBlocks, int]] = []

    @property
    def n_nodes(self) -> int:
        """Number of stored nodes."""
        return int(self.active * self.lattice.nodes_per_block)

    def update(self, bodies: Sequence[BodyBlocks]) -> bool:
        """Store the blocks of these bodies and all blocks around them, and tell each body where its own are (`BodyBlocks.home`).

        Returns
        -------
        bool
            Whether the stored blocks, their order, or a body's `home` have changed; if not, nothing was done.
        """
        if len(self._seen) == len(bodies) and all(b is s and b.version == v for b, (s, v) in zip(bodies, self._seen, strict=True)):
            return False
        lattice, table = self.lattice, self.lattice.table
        near = np.concatenate([(b.numbers[:, None] + lattice.offsets).ravel() for b in bodies])
        # The table keeps the place of one of several equal numbers: those at a place that was kept are all different.
        places = np.arange(len(near), dtype=np.int32)
        table[near] = places
        self.numbers = np.sort(near[table[near] == places])
        self.active = len(self.numbers)
        self.blocks = lattice.coords(self.numbers)
        table[self.numbers] = np.arange(self.active, dtype=np.int32)
        home, first = table[near], 0
        table[self.numbers] = 0
        for b in bodies:
            b.home = home[first : first + b.count * len(lattice.offsets)]
            first += len(b.home)
        self._seen = [(b, b.version) for b in bodies]
        needed = self.n_nodes * self.channels
        if needed > self.G.size:
            self.G = np.zeros(max(needed, int(_GROWTH * self.G.size)), dtype=self.G.dtype)
        else:
            self.G[:] = 0.0
        return True

    @property
    def H(self) -> Any:
        """Records for the next step while `G` holds those of this one; made at first use, all zero then."""
        if self._other.size != self.G.size:
            self._other = np.zeros(self.G.size, dtype=self.G.dtype)
        return self._other

    def turn(self) -> None:
        """Exchange `G` and `H`."""
        self.G, self._other = self.H, self.G

    def node_numbers(self) -> Any:
        """Which node of the grid each stored node is: int64[n_nodes, dim], along each axis 0 on the lower face, negative before it."""
        return self._node_numbers(np.arange(self.active))

    def _node_numbers(self, stored: Any) -> Any:
        lattice = self.lattice
        inside = np.indices((lattice.B,) * lattice.dim).reshape(lattice.dim, -1).T
        first = self.blocks[stored, : lattice.dim] * lattice.B - lattice.ghosts
        return (first[:, None, :] + inside).reshape(-1, lattice.dim)

    def identities(self, nodes: Any) -> Any:
        """Numbers that stay with these stored nodes when others are stored, int64[:]."""
        per_block = self.lattice.nodes_per_block
        return self.numbers[nodes // per_block] * per_block + nodes % per_block

    def positions(self) -> Any:
        """Positions of the stored nodes [m], float64[n_nodes, dim]."""
        grid = self.lattice.grid
        return np.array(grid.lower) + self.node_numbers() * np.array(grid.spacing)

    def face_nodes(self, axis: int, upper: bool) -> Any:
        """Numbers of the stored nodes on a face of the domain, int64[:]; along the other axes only nodes inside the domain."""
        lattice = self.lattice
        plane = int(lattice.cells[axis]) if upper else 0
        stored = np.flatnonzero(self.blocks[:, axis] == (plane + lattice.ghosts) // lattice.B)
        nodes = self._node_numbers(stored)
        on = np.flatnonzero((nodes[:, axis] == plane) & ((nodes >= 0) & (nodes <= lattice.cells)).all(axis=1))
        return stored[on // lattice.nodes_per_block] * lattice.nodes_per_block + on % lattice.nodes_per_block

    def shared_blocks(self, other: SparseNodes) -> tuple[Any, Any]:
        """Stored blocks that both fields have: where this one and where the other stores them, int64[:] each, in ascending order."""
        if not self.active or not other.active:
            return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
        place = np.minimum(np.searchsorted(other.numbers, self.numbers), other.active - 1)
        mine = np.flatnonzero(other.numbers[place] == self.numbers)
        return mine, place[mine]
