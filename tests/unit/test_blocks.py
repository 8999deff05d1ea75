"""Blocks of a body and the sparse storage of nodes: checked by brute force on small domains, for memory on large ones."""

import itertools
import resource
import sys
from pathlib import Path

import numpy as np
import pytest

import mpmkit as mpm
from mpmkit._core.running.blocks import BodyBlocks
from mpmkit._core.running.lattice import Lattice
from mpmkit._core.running.nodes import SparseNodes
from mpmkit.errors import CompositionError

EDGE = {1: 32, 2: 8, 3: 4}
CASES = [(dim, n) for dim in (1, 2, 3) for n in (2, 3, 4)]
EPS = np.finfo(float).eps


def lattice_for(dim, n=3, cells=None, spacing=0.5):
    cells = cells or {1: 300, 2: 60, 3: 24}[dim]
    return Lattice(mpm.Grid((-1.0,) * dim, (-1.0 + spacing * cells,) * dim, spacing), max(EDGE[dim], n + 1), n, n / 2 - 1, np.float64)


def body(lattice, coords, each=5):
    """Blocks at these coordinates, with `each` particles in each."""
    coords = np.array(coords, dtype=np.int64).reshape(len(coords), -1)
    full = np.zeros((len(coords), 3), dtype=np.int64)
    full[:, : coords.shape[1]] = coords
    blocks = BodyBlocks(lattice)
    numbers = lattice.numbers(full)
    blocks.set(numbers[np.argsort(blocks.order(numbers))], each * np.arange(len(coords) + 1))
    return blocks


def all_blocks(lattice, stride=1):
    return list(itertools.product(*(range(0, s - 2, stride) for s in lattice.shape)))


def some_blocks(lattice, share=0.6, seed=0):
    every = all_blocks(lattice)
    keep = np.random.default_rng(seed).random(len(every)) < share
    return [c for c, k in zip(every, keep, strict=True) if k]


def arena(lattice, c):
    return set(itertools.product(*(range(c[a] * lattice.B - 1, c[a] * lattice.B + lattice.B + lattice.n) for a in range(lattice.dim))))


def colour_of(lattice, c):
    return tuple(int(v) % 2 for v in c[: min(lattice.dim, 2)])


@pytest.mark.parametrize(("dim", "n"), CASES)
def test_numbers_and_coordinates(dim, n):
    lattice = lattice_for(dim, n)
    assert lattice.nodes_per_block == lattice.B**dim
    numbers = np.arange(lattice.size)
    coords = lattice.coords(numbers)
    np.testing.assert_array_equal(lattice.numbers(coords), numbers)
    assert coords[:, :dim].min() == -1 and not coords[:, dim:].any()
    # the base nodes of particles on the lower and on the upper face, and all nodes of their arenas, have blocks
    last = (lattice.cells - 1 + lattice.ghosts) // lattice.B
    np.testing.assert_array_equal(coords[:, :dim].max(axis=0), last + 1)
    assert lattice.B + n < 2 * lattice.B


@pytest.mark.parametrize(("dim", "n"), CASES)
def test_units_of_one_colour_share_no_node(dim, n):
    lattice = lattice_for(dim, n, cells={1: 300, 2: 50, 3: 18}[dim])
    blocks = body(lattice, some_blocks(lattice))
    assert blocks.colours[0] == blocks.units[0] == 0 and blocks.colours[-1] == blocks.units[-1] == blocks.count
    assert len(blocks.colours) == 2 ** min(dim, 2) + 1
    assert set(blocks.colours.tolist()) <= set(blocks.units.tolist())
    colours = list(itertools.product((0, 1), repeat=min(dim, 2)))
    for c, (first, last) in enumerate(itertools.pairwise(blocks.colours)):
        assert all(colour_of(lattice, v) == colours[c] for v in blocks.coords[first:last])
        units = [(a, b) for a, b in itertools.pairwise(blocks.units) if first <= a < last]
        assert len(units) > 1
        arenas = [set().union(*(arena(lattice, blocks.coords[b]) for b in range(*u))) for u in units]
        assert sum(len(a) for a in arenas) == len(set().union(*arenas))
    for first, last in itertools.pairwise(blocks.units):
        assert len({tuple(c[: min(dim, 2)]) for c in blocks.coords[first:last].tolist()}) == 1


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_chunks_are_units_of_similar_work(dim):
    lattice = lattice_for(dim, cells={1: 9000, 2: 300, 3: 60}[dim])
    blocks = body(lattice, some_blocks(lattice), each=100)
    for threads in (1, 2, 5):
        chunks = blocks.chunks(threads)
        assert [b for colour in chunks for chunk in colour for b in range(*chunk)] == list(range(blocks.count))
        for (first, last), colour in zip(itertools.pairwise(blocks.colours), chunks, strict=True):
            assert (colour[0][0], colour[-1][1]) == (first, last)
            assert {v for chunk in colour for v in chunk} <= set(blocks.units.tolist())
            assert len(colour) <= 4 * threads
            largest = max(b - a for a, b in itertools.pairwise(blocks.units))
            assert max(b - a for a, b in colour) <= (last - first if threads == 1 else (last - first) / (4 * threads) + 2 * largest)
        ranges = blocks.ranges(threads)
        assert [b for r in ranges for b in range(*r)] == list(range(blocks.count))
        assert len(ranges) == (1 if threads == 1 else 4 * threads)
    assert BodyBlocks(lattice).chunks(2) == [[]] * 2 ** min(dim, 2)


@pytest.mark.parametrize(("dim", "n"), CASES)
def test_edge_blocks(dim, n):
    """A particle whose first node is at i has nodes outside if i < 0 or i + n - 1 > cells; blocks with none within a cell are inner ones."""
    lattice = lattice_for(dim, n)
    blocks = body(lattice, all_blocks(lattice))
    for c, edge in zip(blocks.coords.tolist(), blocks.edge, strict=True):
        first = [c[a] * lattice.B - lattice.ghosts for a in range(dim)]
        reach = [range(f - 1, f + lattice.B + 1) for f in first]
        folded = any(i < 0 or i > lattice.cells[a] - (n - 1) for a in range(dim) for i in reach[a])
        assert edge == folded
    assert 0 < blocks.edge.sum() < blocks.count


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_home_of_every_neighbour(dim):
    lattice = lattice_for(dim)
    bodies = [body(lattice, some_blocks(lattice, 0.1, seed=1)), body(lattice, some_blocks(lattice, 0.2, seed=2))]
    field = SparseNodes(lattice, 4, np.float64)
    assert field.update(bodies)
    stored = {tuple(c): k for k, c in enumerate(field.blocks[:, :dim].tolist())}
    needed = set()
    for b in bodies:
        home = b.home.reshape(b.count, 3**dim)
        assert home.dtype == np.int32
        for c, row in zip(b.coords.tolist(), home, strict=True):
            around = [tuple(c[a] + s[a] for a in range(dim)) for s in itertools.product((-1, 0, 1), repeat=dim)]
            assert [stored[v] for v in around] == row.tolist()
            needed |= set(around)
    assert needed == set(stored)
    assert (np.diff(field.numbers) > 0).all() and field.active == len(stored)
    assert not lattice.table.any()
    assert field.G.size >= field.n_nodes * 4 and not field.G.any()


def test_storage_follows_the_bodies_and_is_kept():
    lattice = lattice_for(2)
    small, large = body(lattice, [(2, 2)]), body(lattice, [(1, 1), (4, 4), (6, 6)])
    field = SparseNodes(lattice, 2, np.float32)
    assert field.update([small]) and field.active == 9 and field.G.dtype == np.float32
    assert not field.update([small])  # nothing has changed
    first = field.G
    small.set(small.numbers, np.array([0, 7]))
    assert not field.update([small])  # other particles in the same blocks
    field.G[:] = 1.0
    assert field.update([small, large]) and field.active == 30 and field.G is not first
    field.G[:] = 1.0
    kept = field.G
    assert field.update([small]) and field.G is kept and not kept.any() and field.active == 9


@pytest.mark.parametrize(("dim", "n"), CASES)
def test_nodes_of_faces(dim, n):
    lattice = lattice_for(dim, n, cells={1: 70, 2: 20, 3: 10}[dim])
    field = SparseNodes(lattice, 1, np.float64)
    field.update([body(lattice, some_blocks(lattice, 0.7))])
    numbers, x = field.node_numbers(), field.positions()
    # rounding: positions are of the order of the domain's size
    np.testing.assert_allclose(x, np.array(lattice.grid.lower) + 0.5 * numbers, rtol=0, atol=4 * EPS * 40)
    assert numbers.min() < 0
    for axis, upper in itertools.product(range(dim), (False, True)):
        plane = lattice.cells[axis] if upper else 0
        inside = ((numbers >= 0) & (numbers <= lattice.cells)).all(axis=1)
        np.testing.assert_array_equal(field.face_nodes(axis, upper), np.flatnonzero(inside & (numbers[:, axis] == plane)))
        assert field.face_nodes(axis, upper).size or dim == 1


def test_a_body_away_from_a_face_has_no_nodes_there():
    lattice = lattice_for(2)
    field = SparseNodes(lattice, 1, np.float64)
    field.update([body(lattice, [(3, 3)])])
    assert field.face_nodes(0, False).size == 0 and field.face_nodes(1, True).size == 0


def test_blocks_that_two_fields_share():
    lattice = lattice_for(3)
    one, two = SparseNodes(lattice, 1, np.float64), SparseNodes(lattice, 1, np.float64)
    for part in one.shared_blocks(two):
        assert part.size == 0
    one.update([body(lattice, [(1, 1, 1), (4, 4, 4)])])
    two.update([body(lattice, [(2, 2, 3)])])
    mine, theirs = one.shared_blocks(two)
    np.testing.assert_array_equal(one.blocks[mine], two.blocks[theirs])
    both = {tuple(c) for c in one.blocks.tolist()} & {tuple(c) for c in two.blocks.tolist()}
    assert {tuple(c) for c in one.blocks[mine].tolist()} == both and len(both) == 2 * 2 * 1 + 1 * 1 * 2


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_restored_structure_is_the_same(dim):
    lattice = lattice_for(dim)
    blocks = body(lattice, some_blocks(lattice, 0.3))
    again = BodyBlocks.from_saved(lattice, blocks.coords.copy(), blocks.starts.copy())
    one, two = SparseNodes(lattice, 1, np.float64), SparseNodes(lattice, 1, np.float64)
    one.update([blocks])
    two.update([again])
    for name in ("count", "numbers", "coords", "starts", "colours", "units", "edge", "home"):
        np.testing.assert_array_equal(getattr(again, name), getattr(blocks, name), err_msg=name)
    np.testing.assert_array_equal(one.numbers, two.numbers)
    assert blocks.chunks(2) == again.chunks(2)


def test_bodies_far_apart_take_no_more_than_near_ones():
    lattice = lattice_for(3, cells=400)
    near, far = SparseNodes(lattice, 8, np.float64), SparseNodes(lattice, 8, np.float64)
    near.update([body(lattice, [(10, 10, 10), (20, 20, 20)])])
    far.update([body(lattice, [(0, 0, 0), (99, 99, 99)])])
    assert near.active == far.active == 54
    assert near.G.size == far.G.size


def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="counts resident memory as Linux tells it")
@pytest.mark.parametrize("cells", [1000, 8000])
def test_a_huge_domain_takes_memory_only_where_particles_are(cells):
    """1000^3 cells are 1e9 nodes (8 GB for one number each), 8000^3 are 5e11."""
    lattice = lattice_for(3, cells=cells)
    before = resident()
    field = SparseNodes(lattice, 4, np.float64)
    at = cells // 4 - 30
    field.update([body(lattice, list(itertools.product(range(5, 15), repeat=3))), body(lattice, [(at, at, at)])])
    assert field.active == 12**3 + 27
    assert resident() - before < 50e6
    assert field.blocks.max() == at + 1


def test_a_domain_too_large_is_refused():
    with pytest.raises(CompositionError, match=r"100000 x 100000 x 100000 cells .* at most 17179869184 .*coarser grid"):
        lattice_for(3, cells=100_000)


def test_a_block_must_hold_a_particle():
    with pytest.raises(ValueError, match="at least 5 nodes"):
        Lattice(mpm.Grid((0.0,), (1.0,), 0.1), 4, 4, 1.0, np.float64)
