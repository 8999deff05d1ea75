"""The whole domain divided into blocks of nodes: numbers of all blocks there could be, and a table over them.

Nodes are counted from the first ghost node, so that they start at 0 along each axis; node i of the grid is i + ghosts here. Block c holds
the nodes c B to c B + B - 1. A block belongs to the particles whose first node it holds. Their nodes reach into the blocks around it, so
there is one more block on either side; to be numbered (row-major, last axis fastest), coordinates of blocks are shifted by one.
"""

from __future__ import annotations

import mmap
import sys
from functools import cached_property
from math import ceil, prod
from typing import Any

import numpy as np

from mpmkit.errors import CompositionError
from mpmkit.grid import Grid

MOST_BLOCKS = 2**34
"""Blocks a domain may have: their table takes 64 GiB of addresses then, though only what is touched takes memory."""

_NO_RESERVE = getattr(mmap, "MAP_NORESERVE", 0x4000)  # Linux; Python names it from 3.13 on


class Lattice:
    """Blocks of a grid for one shape function.

    Parameters
    ----------
    grid : Grid
        The domain.
    B : int
        Nodes along an edge of a block, at least n + 1.
    n : int
        Nodes of a particle along an axis.
    offset : float
        Of the shape function: the first node of a particle at xi cells is floor(xi - offset).
    dtype : type
        Precision of the particles.

    Attributes
    ----------
    lower, inv_h : array of dtype[dim]
        Corner and inverse spacing of the grid, as the particle loops use them.
    cells, shape : int64[dim]
        Cells of the grid; blocks along each axis, with one more on either side.
    size : int
        Number of all blocks, the product of `shape`.
    nodes_per_block : int
        B^dim.
    offsets : int64[3^dim]
        What to add to a block's number to get those of the blocks around it, last axis fastest; the middle one is itself.

    Raises
    ------
    CompositionError
        If there would be more than 2^34 blocks.
    """

    def __init__(self, grid: Grid, B: int, n: int, offset: float, dtype: type) -> None:
        if n + 1 > B:
            raise ValueError(f"a block needs at least {n + 1} nodes along an edge for a shape function of {n}, got {B}")
        self.grid, self.dim, self.B, self.n = grid, grid.dim, B, n
        self.offset, self.ghosts, self.dtype = offset, ceil(offset), dtype
        self.nodes_per_block = B**self.dim
        shape = [(cells - 1 + self.ghosts) // B + 3 for cells in grid.cells]
        self.size = prod(shape)
        if self.size > MOST_BLOCKS:
            raise self._too_large("more than can be numbered")
        self.cells, self.shape = np.array(grid.cells, dtype=np.int64), np.array(shape, dtype=np.int64)
        self.lower: Any = np.array(grid.lower, dtype=dtype)
        self.inv_h: Any = np.array([1.0 / h for h in grid.spacing], dtype=dtype)
        self.strides = np.array([prod(shape[a + 1 :]) for a in range(self.dim)], dtype=np.int64)
        self.offsets = (np.indices((3,) * self.dim).reshape(self.dim, -1).T - 1) @ self.strides

    def _too_large(self, why: str) -> CompositionError:
        cells = " x ".join(str(c) for c in self.grid.cells)
        return CompositionError(
            f"Grid: the domain is too large: {cells} cells ({prod(self.grid.nodes):.3g} nodes) are {self.size:.3g} blocks of "
            f"{self.B} nodes along each axis, {why}; at most {MOST_BLOCKS} (2^34) blocks are possible. "
            "To fix: a coarser grid (larger spacing), or a smaller domain (upper nearer to lower)"
        )

    @cached_property
    def table(self) -> Any:
        """One int32 for each block of the domain; whoever writes to it sets it back to zero. Pages take memory when first touched."""
        if 4 * self.size < 2**20 or not sys.platform.startswith("linux"):
            try:
                return np.zeros(self.size, dtype=np.int32)
            except MemoryError:
                raise self._too_large("too many for this machine's memory") from None
        try:
            pages = mmap.mmap(-1, 4 * self.size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | _NO_RESERVE)
        except OSError as error:
            raise self._too_large(f"too many for the addresses this process may use ({error})") from None
        if hasattr(mmap, "MADV_NOHUGEPAGE"):
            pages.madvise(mmap.MADV_NOHUGEPAGE)  # a touched entry should take 4 KiB, not 2 MiB
        return np.frombuffer(pages, dtype=np.int32)

    def numbers(self, coords: Any) -> Any:
        """Numbers of the blocks at these coordinates: int64[count] from int64[count, 3]."""
        return (coords[:, : self.dim] + 1) @ self.strides

    def coords(self, numbers: Any) -> Any:
        """Coordinates of blocks, int64[count, 3] with zeros for the axes there are not; -1 lies before the first ghost node."""
        coords = np.zeros((len(numbers), 3), dtype=np.int64)
        rest = numbers
        for a in range(self.dim - 1):
            coords[:, a], rest = np.divmod(rest, self.strides[a])
        coords[:, self.dim - 1] = rest
        coords[:, : self.dim] -= 1
        return coords
