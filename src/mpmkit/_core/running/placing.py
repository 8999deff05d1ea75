"""Where particles and nodes are: bodies sorted into blocks of a sparse grid, or points and nodes in lists."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit._core.composing.plan import Plan
from mpmkit._core.composing.sweep import CHUNK
from mpmkit._core.composing.writer import ACCOUNTS
from mpmkit._core.running.blocks import BodyBlocks
from mpmkit._core.running.lattice import Lattice
from mpmkit._core.running.sort import Scratch, sort_body
from mpmkit._core.running.store import BodyStore
from mpmkit._core.running.workers import Team

FARTHEST = 1.0 - 1e-3  # cells that a particle may move before its body is sorted again: the margin of the arenas, less rounding


class SortedBodies:
    """Particles of all bodies sorted by block and cell, again whenever one may have moved by a cell.

    Attributes
    ----------
    blocks : list of BodyBlocks
        Of each body; each also has ``corner``, int64[3 count], the first node of the arenas counted from the first ghost node.
    acc : list of float64[count * columns]
        Accounts of the blocks of each body.
    drift : float64[bodies]
        Bound of how far any particle has moved since its body was sorted [cells].
    """

    def __init__(self, plan: Plan, stores: list[BodyStore], team: Team) -> None:
        operator = plan.operator
        self.lattice = Lattice(plan.composition.grid, operator.arena.block, operator.nodes, operator.offset, plan.dtype)
        self.stores, self.team = stores, team
        self.blocks: list[Any] = [BodyBlocks(self.lattice) for _ in stores]
        self.acc: list[Any] = [np.zeros(0) for _ in stores]
        self.drift = np.full(len(stores), np.inf)
        self.pace = np.zeros(len(stores))
        self._scratch = Scratch()
        self._ledger: Any = np.zeros(0)

    def update(self, module: Any) -> bool:
        """Sort the bodies that need it; whether there were any."""
        late = np.flatnonzero(~(self.drift <= FARTHEST))
        for k in late.tolist():
            s, b = self.stores[k], self.blocks[k]
            sort_body(module, s, self.lattice, b, self._scratch, s.ids, self.team.size, self._run)
            self._sized(k)
            self.drift[k] = 0.0
        self._scratch.shrink()
        return late.size > 0

    def moved(self, k: int, cells: float) -> None:
        """A particle of body k may have moved by so many cells in the step that is being closed."""
        self.drift[k] += cells
        self.pace[k] = cells

    def in_place(self) -> bool:
        """Whether all particles are still within the arenas of their blocks."""
        return bool((self.drift <= FARTHEST).all())

    def stays(self) -> bool:
        """Whether they are likely to be after one more step."""
        return bool((self.drift + 1.1 * self.pace <= FARTHEST).all())

    def changed(self, k: int) -> None:
        """Particles of body k have been taken out: it is sorted before anything else is done with it."""
        self.drift[k] = np.inf

    def _run(self, tasks: Any) -> None:
        self.team.run(lambda thread, task: task(), list(tasks))

    def _sized(self, k: int) -> None:
        b = self.blocks[k]
        b.corner = (b.coords * self.lattice.B - 1).reshape(-1)
        self.acc[k] = np.zeros(max(1, b.count) * len(ACCOUNTS))  # of a body without particles there is still a sum

    def ledger_acc(self, k: int, width: int) -> Any:
        """Accounts of the blocks of a body for the ledger, all zero."""
        size = max(1, self.blocks[k].count) * width
        if self._ledger.size < size:
            self._ledger = np.zeros(size)
        self._ledger[:size] = 0.0
        return self._ledger

    def state(self) -> dict[str, Any]:
        """What a run that goes on from a checkpoint must know to form every sum in the same order."""
        arrays: dict[str, Any] = {"drift": self.drift}
        for s, b in zip(self.stores, self.blocks, strict=True):
            arrays |= {f"ids/{s.name}": s.ids, f"blocks/{s.name}": b.coords, f"starts/{s.name}": b.starts}
            if s.kept is not None:
                arrays[f"kept/{s.name}"] = s.kept
        return arrays

    def restore(self, arrays: dict[str, Any]) -> None:
        self.drift[:] = arrays["drift"]
        for k, s in enumerate(self.stores):
            self.blocks[k] = BodyBlocks.from_saved(self.lattice, arrays[f"blocks/{s.name}"], arrays[f"starts/{s.name}"])
            self._sized(k)


class ListedNodes:
    """Nodes of a mesh: of all bodies, one after the other."""

    def __init__(self, stores: list[BodyStore], channels: int, dtype: type) -> None:
        self.where: Any = np.concatenate([s.points.nodes for s in stores])
        first = 0
        for s in stores:
            s.operator = (s.points.connectivity + first, s.points.N.astype(dtype), s.points.dN.astype(dtype))
            first += len(s.points.nodes)
        self.n_nodes = first
        self.active = -(-first // CHUNK)
        self.G: Any = np.zeros(first * channels, dtype=dtype)

    def positions(self) -> Any:
        return self.where

    def update(self, bodies: Any) -> bool:
        return False


class ListedPoints:
    """Integration points in runs of whole tiles; they never change places."""

    def __init__(self, stores: list[BodyStore]) -> None:
        self.blocks = [_Runs(s.n) for s in stores]
        self.acc = [np.zeros(b.count * len(ACCOUNTS)) for b in self.blocks]
        self._fresh = True

    def update(self, module: Any) -> bool:
        fresh, self._fresh = self._fresh, False
        return fresh

    def moved(self, k: int, cells: float) -> None:
        """Points stay in their lists."""

    def ledger_acc(self, k: int, width: int) -> Any:
        return np.zeros(self.blocks[k].count * width)


class _Runs:
    """Ranges of 1024 points; what adds to nodes is done by one thread, in their order."""

    def __init__(self, n: int) -> None:
        self.starts = np.append(np.arange(0, n, 1024), n).astype(np.int64)
        self.count = len(self.starts) - 1

    def chunks(self, threads: int) -> list[list[tuple[int, int]]]:
        return [[(0, self.count)]]

    def ranges(self, threads: int) -> list[tuple[int, int]]:
        step = max(1, self.count // (4 * threads))
        return [(a, min(a + step, self.count)) for a in range(0, self.count, step)]
