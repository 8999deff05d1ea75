"""Contact between bodies: pairs whose nodes meet, normals, gaps and impulses in that order."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.running.bindings import Step, over_particles, where
from mpmkit.errors import StabilityError

if TYPE_CHECKING:
    from mpmkit._core.running.engine import Engine


class Pair:
    """Two bodies and the nodes they share in this step."""

    def __init__(self, a: int, b: int) -> None:
        self.a, self.b, self.count = a, b, 0
        self.both: Any = np.zeros((0, 2), dtype=np.int64)  # places of the blocks of nodes that both bodies have
        self.resize(256, np.float64)

    def resize(self, size: int, dtype: type) -> None:
        """Room for this many shared nodes; what was there is lost."""
        self.found = np.zeros((size, 2), dtype=np.int64)
        self.normals: Any = np.zeros((size, 3, 3), dtype=dtype)  # three candidates, the chosen one first
        self.reach_a: Any = np.zeros((size, 3), dtype=dtype)
        self.press: Any = np.zeros(size, dtype=dtype)
        self.reach_b: Any = np.zeros((size, 3), dtype=dtype)


class ContactPairs:
    """All pairs of bodies; a pair costs something only while both have nodes in one block."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.pairs = [Pair(a, b) for a, b in combinations(range(len(engine.stores)), 2)]
        for pair in self.pairs:
            pair.resize(256, engine.dtype)
        self.place = np.zeros(engine.plan.operator.arena.size, dtype=np.int64)

    def update(self) -> None:
        """After the bodies were sorted: which blocks of nodes both have, and fresh marks on nodes and blocks."""
        e = self.engine
        self.slot = [np.full(f.n_nodes, -1, dtype=np.int64) for f in e.fields]
        self.touched = [np.zeros(f.active, dtype=np.uint8) for f in e.fields]
        self.near, self.near_any = ([np.zeros(b.count, dtype=np.uint8) for b in e.places.blocks] for _ in range(2))
        for pair in self.pairs:
            pair.both = np.stack(e.fields[pair.a].shared_blocks(e.fields[pair.b]), axis=1)
            pair.count = 0

    def operation(self, channel: str, find: bool) -> Callable[[Any, Any], None]:
        """The contact phase on one channel; with `find` it first looks for the shared nodes of this step."""
        e = self.engine
        function = getattr(e.module, f"contact_{channel}")
        outward = [
            over_particles(e, k, "outward", e.places.acc[k], self.near_any[k]) for k in range(len(e.stores) if find else 0)
        ]  # gradients of the volume, near other bodies

        def apply(t: Any, dt: Any) -> None:
            if find:
                self._find(outward, t, dt)
            for pair in self.pairs:
                if pair.count:
                    A, B = e.fields[pair.a], e.fields[pair.b]
                    shared = (pair.found, pair.count, pair.normals, pair.reach_a, pair.reach_b, pair.press)
                    function(A.G, B.G, *shared, where(e, A), e.node_par, e.work, t, dt)

        return apply

    def warm_up(self) -> None:
        """Call every function of contact with no nodes and no blocks: nothing is left to compile when bodies first meet."""
        e, m, zero = self.engine, self.engine.module, self.engine.dtype(0.0)
        materials = {(e.stores[pair.a].group.name, e.stores[pair.b].group.name): pair for pair in self.pairs}
        for pair in materials.values():
            A, B, margin = e.fields[pair.a], e.fields[pair.b], e.dtype(1e-3 * e.c.grid.h)
            shared = (pair.normals, pair.reach_a, pair.reach_b)
            m.find_shared(A.G, B.G, pair.both[:0], pair.found, e.node_par)
            m.mark_shared(pair.found, 0, *self._marks(pair))
            m.contact_normals(A.G, B.G, pair.found, 0, *shared)
            for body, reach in ((pair.a, pair.reach_a), (pair.b, pair.reach_b)):
                m.near_shared(e.places.blocks[body].home, 0, 3**e.c.dim, self.touched[body], self.near[body])
                self.near_any[body][:] = 0
                over_particles(e, body, "outward", e.places.acc[body], self.near_any[body])(zero, zero)
                self._reach(body, 0, pair, reach, 1.0, zero, zero)
            m.choose_normals(0, *shared, margin)
            m.clear_shared(pair.found, 0, *self._marks(pair))
            for channel in (p.channel for p in e.plan.schedule.phases if p.kind == "contact"):
                getattr(m, f"contact_{channel}")(A.G, B.G, pair.found, 0, *shared, pair.press, where(e, A), e.node_par, e.work, zero, zero)

    def _find(self, outward: list[Step], t: Any, dt: Any) -> None:
        """Shared nodes of all pairs; then, near them only, the gradients of the bodies' volumes, normals and gaps."""
        e, m = self.engine, self.engine.module
        for near in self.near_any:
            near[:] = 0
        touching = set()
        for pair in self.pairs:
            if not len(pair.both):
                continue
            fields = e.fields[pair.a].G, e.fields[pair.b].G
            while (count := m.find_shared(*fields, pair.both, pair.found, e.node_par)) < 0:  # the list was too short
                pair.resize(4 * len(pair.found), e.dtype)
            pair.count = count
            if count:
                touching |= {pair.a, pair.b}
                m.mark_shared(pair.found, count, *self._marks(pair))
                for body in (pair.a, pair.b):
                    self._mark_near(body, self.near_any[body])
                m.clear_shared(pair.found, count, *self._marks(pair))
        for body in sorted(touching):
            outward[body](t, dt)
        for pair in self.pairs:
            if pair.count:
                self._normals(pair, t, dt)

    def _marks(self, pair: Pair) -> tuple[Any, ...]:
        return (self.slot[pair.a], self.slot[pair.b], self.touched[pair.a], self.touched[pair.b])

    def _mark_near(self, body: int, near: Any) -> None:
        blocks = self.engine.places.blocks[body]
        self.engine.module.near_shared(blocks.home, blocks.count, 3**self.engine.c.dim, self.touched[body], near)

    def _reach(self, body: int, blocks: int, pair: Pair, reach: Any, side: float, t: Any, dt: Any) -> None:
        e = self.engine
        lists = (self.near[body], self.slot[body], pair.normals, reach, e.dtype(side), self.place)
        function, arguments = getattr(e.module, f"reach_{e.stores[body].group.name}"), e.particle_arguments(body, e.places.acc[body])
        function(0, blocks, *arguments, *lists, e.scratch[0][0], e.scratch[0][2], t, dt)

    def _normals(self, pair: Pair, t: Any, dt: Any) -> None:
        e, m, a, b, count = self.engine, self.engine.module, pair.a, pair.b, pair.count
        m.contact_normals(e.fields[a].G, e.fields[b].G, pair.found, count, pair.normals, pair.reach_a, pair.reach_b)
        m.mark_shared(pair.found, count, *self._marks(pair))
        for body, reach, side in ((a, pair.reach_a, 1.0), (b, pair.reach_b, -1.0)):
            blocks, near = e.places.blocks[body], self.near[body]
            near[:] = 0
            self._mark_near(body, near)
            self._reach(body, blocks.count, pair, reach, side, t, dt)
        m.choose_normals(count, pair.normals, pair.reach_a, pair.reach_b, e.dtype(1e-3 * e.c.grid.h))
        m.clear_shared(pair.found, count, *self._marks(pair))
        if not np.isfinite(pair.normals[:count]).all():
            names = f"{e.stores[a].name!r} and {e.stores[b].name!r}"
            raise StabilityError(
                f"contact between bodies {names}: a normal is not a number, at step {e.step_number}, t = {e.t:.6g} s. To fix: lower cfl, "
                "or look at the positions and sizes of their particles",
                shorter=True,
            )
