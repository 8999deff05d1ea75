"""The generated sums over nodes and terms for nodes against plain products of weights, for every dimension and kind of sum.

Rounding: 1e-13 of the largest value, some hundred epsilons for sums of up to 64 products of five factors.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from mpmkit._core.composing import rows, simd_numpy
from mpmkit._core.composing.arena import Arena
from mpmkit._core.composing.layout import LANES, Slots

TOLERANCE = 1e-13
FIRST, LAST = 3, 11  # lanes of the tile that are worked on


def compiled_in_python(text: str, name: str):
    scope = {n: getattr(simd_numpy, n) for n in ("load", "store", "splat", "tiled", "spread", "mixed", "summed")}
    scope |= {"compiled": lambda f: f, "T": np.float64, "U": int, "zero": 0.0}
    exec(text, scope)
    return scope[name]


class Tile:
    """Random weights of 16 particles, and their products at each node."""

    def __init__(self, dim: int, n: int) -> None:
        rng = np.random.default_rng(dim * 10 + n)
        self.slots, self.arena = Slots(dim, n), Arena(dim, n)
        self.sc = rng.normal(size=LANES * (self.slots.count + 1))
        room = self.arena.side - n
        self.place = rng.integers(0, room + 1, size=(LANES, dim))
        strides = [self.arena.side ** (dim - 1 - a) for a in range(dim)]
        self.ib = (self.place @ strides).astype(np.int32)
        self.dim, self.n, self.rng, self.strides = dim, n, rng, strides

    def row(self, slot: int) -> np.ndarray:
        return self.sc[LANES * slot : LANES * slot + LANES]

    def nodes(self, p: int):
        """Number in the arena, weight, slopes and index moments of each node of a particle."""
        s = self.slots
        for k in product(range(self.n), repeat=self.dim):
            w = [self.row(s.w(a, k[a]))[p] for a in range(self.dim)]
            d = [self.row(s.d(a, k[a]))[p] for a in range(self.dim)]
            along = [np.prod([d[a] if a == b else w[a] for a in range(self.dim)]) for b in range(self.dim)]
            yield int(self.ib[p] + np.dot(k, self.strides)), np.prod(w), along, [np.prod(w) * k[b] for b in range(self.dim)]


# windows narrower than 32 bytes are powers of two (`NodeLayout.window`)
CASES = [
    (dim, n, width, itemsize)
    for dim in (1, 2, 3)
    for n in (2, 3, 4)
    for width in (2, 4, 6, 8, 12, 16, 20, 28)
    for itemsize in (4, 8)
    if (dim < 3 or n < 4 or width in (2, 8, 12)) and width * itemsize != 24
]


@pytest.mark.parametrize("pattern", ["w", "wk", "wg", "wkg", "wg wg wk w", "w - wg -"])
@pytest.mark.parametrize(("dim", "n", "width", "itemsize"), CASES)
def test_sums_over_nodes(dim, n, width, pattern, itemsize):
    asked = [one.replace("-", "") for one in (pattern.split() * width)[:width]]
    kinds = rows.kinds_of(asked)
    tile = Tile(dim, n)
    u = tile.rng.normal(size=tile.arena.size * width + 64)
    wanted_at = rows.results(dim, kinds)
    S = rows.stride(len(wanted_at), width)
    gather = compiled_in_python(rows.gather_function("gather", tile.slots, tile.arena.side, width, asked, itemsize), "gather")
    tr = np.full(LANES * S, np.nan)
    gather(u, FIRST, LAST, tile.sc, tile.ib, tr)
    for p in range(FIRST, LAST):
        sums = np.zeros((len(wanted_at), width))
        for node, w, slopes, moments in tile.nodes(p):
            factors = {"w": w} | {f"g{b}": slopes[b] for b in range(dim)} | {f"k{b}": moments[b] for b in range(dim)}
            for place, result in enumerate(wanted_at):
                sums[place] += factors[result] * u[width * node : width * node + width]
        found = tr[S * p : S * p + sums.size].reshape(sums.shape)
        wanted = np.array([[result[0] in one for one in asked] for result in wanted_at])
        assert np.abs(found - sums)[wanted].max() < TOLERANCE * np.abs(sums).max() + TOLERANCE
    assert np.isnan(tr[: S * FIRST]).all() and np.isnan(tr[S * LAST :]).all(), "only the particles of the block"


@pytest.mark.parametrize("pattern", ["", "k", "g", "gk", "g_k"], ids=lambda p: p or "weights")
@pytest.mark.parametrize(("dim", "n", "width", "itemsize"), CASES)
def test_terms_for_nodes(dim, n, width, pattern, itemsize):
    tile = Tile(dim, n)
    kinds = [(pattern * width)[c].replace("_", "") if pattern else "" for c in range(width)]
    S = rows.stride(dim + 1 if any(kinds) else 1, width)
    scatter = compiled_in_python(rows.scatter_function("scatter", tile.slots, tile.arena.side, width, kinds, itemsize), "scatter")
    terms = tile.rng.normal(size=(LANES, S))
    for c, kind in enumerate(kinds):
        if not kind:
            terms[:, [(1 + a) * width + c for a in range(dim) if any(kinds)]] = 0.0  # as the computation leaves them
    arena = tile.rng.normal(size=tile.arena.size * width + 64)
    wanted = arena.copy()
    scatter(arena, FIRST, LAST, tile.sc, tile.ib, terms.reshape(-1))
    for p in range(FIRST, LAST):
        for node, w, slopes, moments in tile.nodes(p):
            for c, kind in enumerate(kinds):
                wanted[width * node + c] += terms[p, c] * w
                if kind:
                    along = slopes if kind == "g" else moments
                    wanted[width * node + c] += sum(terms[p, (1 + b) * width + c] * along[b] for b in range(dim))
    assert np.abs(arena - wanted).max() < TOLERANCE * np.abs(wanted).max() * n**dim


@pytest.mark.parametrize(("dim", "n"), [(dim, n) for dim in (1, 2, 3) for n in (2, 3, 4, 5)])
def test_arenas_see_the_blocks_around(dim, n):
    """What is fetched lies where `node_of` says; flushing adds to the same places, and to no other."""
    arena, width, record, first = Arena(dim, n), 2, 4, 1
    B, rng = arena.block, np.random.default_rng(n)
    home = rng.permutation(3**dim + 5)[: 3**dim].astype(np.int32)  # the blocks around lie anywhere
    G = rng.normal(size=(len(home) + 5) * B**dim * record)
    fetch = compiled_in_python(arena.fetch("fetch", record, first, width), "fetch")
    flush = compiled_in_python(arena.flush("flush", record, first, width), "flush")
    node_of = compiled_in_python(arena.node_of(), "node_of")
    near = np.zeros(arena.size * width)
    fetch(near, G, home, 0)
    places = np.array([node_of(home, 0, e) for e in range(arena.size)])
    assert len(set(places.tolist())) == arena.size
    assert np.array_equal(near.reshape(-1, width), G.reshape(-1, record)[places, first : first + width])
    for e in rng.integers(0, arena.size, 20):
        k = np.array(np.unravel_index(e, (arena.side,) * dim)) - 1  # counted from the first node of the block
        block = home[np.ravel_multi_index(k // B + 1, (3,) * dim)]
        assert places[e] == block * B**dim + np.ravel_multi_index(k % B, (B,) * dim)
    before = G.copy()
    flush(near, G, home, 0)
    before.reshape(-1, record)[places, first : first + width] += near.reshape(-1, width)
    assert np.array_equal(G, before)
