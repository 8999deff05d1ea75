"""The operators N_ip and G_ip in the text of a particle loop: rebuilt from a grid, or read from neighbour lists.

A loop runs over blocks of particles, in a block over tiles of 16. An operator supplies what happens before and after a
block, the sums over the nodes of a tile's particles (into rows of lanes), and the terms added to the nodes (from rows of
lanes); everything between is the same computation for both.
"""

from __future__ import annotations

from itertools import groupby
from math import ceil

from mpmkit._core.composing import rows, weights
from mpmkit._core.composing.arena import Arena
from mpmkit._core.composing.layout import LANES, NodeLayout, Slots, lane
from mpmkit._core.composing.source import ParticleLoop


class GridOperator:
    """MPM: products over the directions of a shape function's weights at the particle's position, through arenas of blocks."""

    arguments = "first, last, P, starts, corner, home, edge, G, par, acc"
    scratch = "sc, tr, ib, near, far"

    def __init__(self, dim: int, nodes: int, offset: float, itemsize: int) -> None:
        self.dim, self.nodes, self.offset, self.itemsize = dim, nodes, offset, itemsize
        self.ghosts = ceil(offset)  # nodes kept outside the lower faces, whose weights are folded to zero
        self.slots = Slots(dim, nodes)
        self.arena = Arena(dim, nodes)
        self.functions: dict[str, str] = {}

    def helper(self, name: str, text: str) -> str:
        self.functions.setdefault(name, text)
        return name

    def _window(self, what: str, layout: NodeLayout, channels: list[str]) -> tuple[str, int, int]:
        """A `fetch` or `flush` for a window of the record, and the window."""
        first, width = layout.window(channels)
        name = f"{what}_{first}_{width}"
        make = self.arena.fetch if what == "fetch" else self.arena.flush
        return self.helper(name, make(name, layout.size, first, width)), first, width

    def prepare(self, loop: ParticleLoop, moved: bool = False) -> list[str]:
        """Lines of a tile that compute the weights; of particles that have moved since the block's arena was chosen, if `moved`."""
        kept = "_first" if loop.composition.keeps_size and loop.first else ""
        group, shape = loop.group, loop.composition.shape
        assert shape is not None
        slopes = loop.asks_slopes or any(f == "g" for _, f in loop.sums) or any(f[0] == "g" for t in loop.terms.values() for f, _ in t)
        name = f"weights_{group.name}{kept}{'' if slopes else '_only'}{'_moved' if moved else ''}"
        if name not in self.functions:
            one = ParticleLoop(loop.composition, loop.parameters, loop.names, group, loop.nodes)
            one.first = loop.first
            self.helper(name, weights.weights_function(one, name, self.ghosts, self.arena.side, slopes, moved))
        lines = [f"{name}(P, tile, l0, l1, corner, block, par, sc, ib)"]
        if self.nodes > 2:
            self.helper("fold", weights.fold_rule(self.nodes))
            two = ParticleLoop(loop.composition, loop.parameters, loop.names, group, loop.nodes)
            two.first = loop.first
            fold = f"fold_{group.name}{kept}"
            self.helper(fold, weights.fold_function(two, fold))
            lines += ["if edge[U(block)]:", f"    {fold}(P, tile, l0, l1, par, sc)"]
        return lines

    def gather(self, loop: ParticleLoop, layout: NodeLayout, slot: int) -> tuple[list[str], list[str], dict[str, str], int]:
        """Lines before the tiles, lines of a tile, text of each sum by name, and slots taken."""
        channels = list(dict.fromkeys(channel for channel, _ in loop.sums))
        fetch, first, width = self._window("fetch", layout, channels)
        asked = [""] * width
        for channel, factor in loop.sums:
            for c in range(layout.start[channel] - first, layout.start[channel] - first + layout.width(channel)):
                asked[c] += factor
        name = f"gather_{_pattern(asked)}"
        self.helper(name, rows.gather_function(name, self.slots, self.arena.side, width, asked, self.itemsize))
        order = rows.results(self.dim, rows.kinds_of(asked))
        S = rows.stride(len(order), width)
        where, wanted = {}, set()
        for channel, factor in loop.sums:
            for k, local in enumerate(loop.summed(channel, factor)):
                a, b = (k, 0) if factor == "w" else divmod(k, self.dim)
                result = order.index("w" if factor == "w" else f"{factor}{b}")
                number = result * width + layout.start[channel] - first + a
                wanted.add(number)
                text = lane(slot + number)
                where[local] = f"{text} * {loop.along('inv_h', b)}" if factor == "g" else text
        before = [f"{fetch}(near, G, home, block)"]
        return before, [f"{name}(near, l0, l1, sc, ib, tr)", *rows.transposed(True, slot, S, wanted)], where, S

    def scatter(self, loop: ParticleLoop, layout: NodeLayout, slot: int) -> tuple[list[str], list[str], list[str], list[str], int]:
        """Lines before the tiles, lines of the computation, lines of a tile, lines after the tiles, and slots taken."""
        flush, first, width = self._window("flush", layout, list(loop.terms))
        kinds = [""] * width
        stores: dict[tuple[int, int], list[str]] = {}
        for channel, parts in loop.terms.items():
            for (factor, a), texts in parts.items():
                c = layout.start[channel] - first + a
                text = " + ".join(texts)
                if factor == "w":
                    stores.setdefault((0, c), []).append(text)
                    continue
                b, kind = int(factor[1]), "k" if factor[0] == "r" else "g"
                if text == "zero":
                    continue
                assert kinds[c] in ("", kind), f"channel {channel} has terms with slopes and with distances in one loop"
                kinds[c] = kind
                if kind == "k":
                    # N_i (x_i - x_p)_b = h_b (N_i k_b - f_b N_i)
                    h = loop.along("h", b)
                    stores.setdefault((1 + b, c), []).append(f"({text}) * {h}")
                    stores.setdefault((0, c), []).append(f"-({text}) * {h} * {loop.place(b)}")
                else:
                    stores.setdefault((1 + b, c), []).append(f"({text}) * {loop.along('inv_h', b)}")
        name = f"scatter_{_pattern(kinds)}"
        self.helper(name, rows.scatter_function(name, self.slots, self.arena.side, width, kinds, self.itemsize))
        S = rows.stride(self.dim + 1 if any(kinds) else 1, width)
        compute = [
            f"{lane(slot + row * width + c)} = {' + '.join(stores.get((row, c), ['zero']))}"
            for row in range(self.dim + 1 if any(kinds) else 1)
            for c in range(width)
        ]
        self.helper("clear", CLEAR)
        before = [f"clear(far, {self.arena.size * width})"]
        tile = [*rows.transposed(False, slot, S, set(range(S))), f"{name}(far, l0, l1, sc, ib, tr)"]
        return before, compute, tile, [f"{flush}(far, G, home, block)"], S

    def nodes_loop(self, layout: NodeLayout, look_up: str = "") -> tuple[list[str], str]:
        """A loop over the nodes of one particle (lane l of a tile), for the few particles that meet special nodes: i, w, g and r.

        With ``look_up``, the name of an array over the arena, ``i`` is what that array holds, and negative ones are passed over.
        """
        lines, pad, A, dim = [], "", self.arena.side, self.dim
        for a in range(dim):
            lines.append(f"{pad}for j{a} in range({self.nodes}):")
            pad += "    "
        index = "int(ib[U(l)]) + " + " + ".join(f"j{a} * {A ** (dim - 1 - a)}" for a in range(dim))
        if look_up:
            lines += [f"{pad}i = {look_up}[U({index})]", f"{pad}if i < 0:", f"{pad}    continue"]
        else:
            self.helper("node_of", self.arena.node_of())
            lines.append(f"{pad}i = node_of(home, block, {index})")

        def of(slot: int, a: int) -> str:
            return f"sc[U({LANES * slot} + {LANES} * j{a} + l)]"

        w = [of(self.slots.w(a, 0), a) for a in range(dim)]
        lines.append(f"{pad}w = {' * '.join(w)}")
        for b in range(dim):
            factors = [of(self.slots.d(a, 0), a) if a == b else w[a] for a in range(dim)]
            lines.append(f"{pad}g{b} = {' * '.join(factors)} * inv_h{b}")
            lines.append(f"{pad}r{b} = (T(j{b}) - {lane(self.slots.f(b))}) * h{b}")
        return lines, pad


def _pattern(asked: list[str]) -> str:
    """A short name for what the channels of a window ask for: runs of equal ones, with their lengths."""
    return "_".join(f"{len(list(run))}{one}" for one, run in groupby(asked))


class StoredOperator:
    """Neighbour lists made once: node numbers, weights and gradients of each point."""

    arguments = "first, last, P, starts, nodes, N, dN, G, par, acc"
    scratch = "sc"

    def __init__(self, dim: int, per_point: int) -> None:
        self.dim, self.per_point = dim, per_point
        self.slots = Slots(dim, 0)
        self.functions: dict[str, str] = {}

    def prepare(self, loop: ParticleLoop) -> list[str]:
        return []

    def points(self, factors: set[str], layout: NodeLayout) -> list[str]:
        """A loop over the nodes of one point."""
        lines = ["p = 16 * tile + l", f"for a in range({self.per_point}):", f"    k = nodes[p, a] * {layout.size}"]
        if "w" in factors:
            lines.append("    w = N[p, a]")
        return lines + [f"    g{b} = dN[p, a, {b}]" for b in range(self.dim) if "g" in factors]

    def gather(self, loop: ParticleLoop, layout: NodeLayout, slot: int) -> tuple[list[str], list[str], dict[str, str], int]:
        where: dict[str, str] = {}
        zero, lines = [], self.points({f for _, f in loop.sums}, layout)
        for channel, factor in loop.sums:
            for k, local in enumerate(loop.summed(channel, factor)):
                where[local] = lane(slot + len(where))
                a, weight = (k, "w") if factor == "w" else (k // self.dim, f"g{k % self.dim}")
                zero.append(f"{local} = zero")
                lines.append(f"    {local} += G[k + {layout.start[channel] + a}] * {weight}")
        text = [*zero, *lines, *(f"{text} = {local}" for local, text in where.items())]
        return [], ["for l in range(l0, l1):", *(f"    {line}" for line in text)], where, len(where)

    def scatter(self, loop: ParticleLoop, layout: NodeLayout, slot: int) -> tuple[list[str], list[str], list[str], list[str], int]:
        compute, values, add, taken = [], [], [], 0
        factors: set[str] = set()
        for channel, parts in loop.terms.items():
            for (factor, a), texts in parts.items():
                compute.append(f"{lane(slot + taken)} = {' + '.join(texts)}")
                values.append(f"c{taken} = {lane(slot + taken)}")
                add.append(f"    G[k + {layout.start[channel] + a}] += c{taken} * {factor}")
                factors.add(factor[0])
                taken += 1
        points = self.points(factors, layout)
        text = [points[0], *values, *points[1:], *add]
        return [], compute, ["for l in range(l0, l1):", *(f"    {line}" for line in text)], [], taken


CLEAR = """@compiled
def clear(arena, size):
    for i in range(size):
        arena[U(i)] = zero
"""
