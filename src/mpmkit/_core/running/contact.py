"""Contact between bodies: pairs whose nodes meet, normals, gaps and impulses in that order."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit.errors import StabilityError

if TYPE_CHECKING:
    from mpmkit._core.running.engine import Engine


class Pair:
    """Two bodies and the nodes they share in this step."""

    def __init__(self, a: int, b: int) -> None:
        self.a, self.b, self.count = a, b, 0
        self.resize(256, np.float64)

    def resize(self, size: int, dtype: type) -> None:
        self.found = np.zeros(size, dtype=np.int64)
        self.normals: Any = np.zeros((size, 3, 3), dtype=dtype)  # three candidates, the chosen one first
        self.reach_a: Any = np.zeros((size, 3), dtype=dtype)
        self.press: Any = np.zeros(size, dtype=dtype)
        self.reach_b: Any = np.zeros((size, 3), dtype=dtype)


class ContactPairs:
    """All pairs of bodies; a pair costs something only in steps in which its bodies share nodes."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.slot = np.full(engine.n_nodes, -1, dtype=np.int64)
        self.pairs = [Pair(a, b) for a, b in combinations(range(len(engine.stores)), 2)]
        for pair in self.pairs:
            pair.resize(256, engine.dtype)

    def operation(self, channel: str, find: bool) -> Callable[[Any, Any], None]:
        e = self.engine
        function = getattr(e.module, f"contact_{channel}")

        def apply(t: Any, dt: Any) -> None:
            for pair in self.pairs:
                if find:
                    self._find(pair, t, dt)
                if pair.count:
                    A, B = e.fields[pair.a].G, e.fields[pair.b].G
                    shared = (pair.found, pair.count, pair.normals, pair.reach_a, pair.reach_b, pair.press)
                    function(A, B, *shared, e.node_par, e.lat, e.work, t, dt)

        return apply

    def _find(self, pair: Pair, t: Any, dt: Any) -> None:
        e, m = self.engine, self.engine.module
        fa, fb = e.fields[pair.a], e.fields[pair.b]
        pair.count = m.find_shared(fa.G, fb.G, fa.span, fb.span, pair.found, self.slot, e.node_par)
        while pair.count < 0:  # the list was too short
            self.slot[pair.found] = -1
            pair.resize(4 * pair.found.size, e.dtype)
            pair.count = m.find_shared(fa.G, fb.G, fa.span, fb.span, pair.found, self.slot, e.node_par)
        if not pair.count:
            return
        m.contact_normals(fa.G, fb.G, pair.found, pair.count, pair.normals, pair.reach_a, pair.reach_b)
        for body, reach, side in ((pair.a, pair.reach_a, 1.0), (pair.b, pair.reach_b, -1.0)):
            function = getattr(m, f"reach_{e.stores[body].group.name}")
            function(*e._particle_arguments(body), self.slot, pair.normals, reach, e.dtype(side), t, dt)
        m.choose_normals(pair.count, pair.normals, pair.reach_a, pair.reach_b, e.dtype(1e-3 * e.c.grid.h))
        m.clear_shared(pair.found, pair.count, self.slot)
        if not np.isfinite(pair.normals[: pair.count]).all():
            raise StabilityError(f"contact between bodies {pair.a} and {pair.b}: a normal is not a number at step {e.step_number}")
