"""Sorting the particles of a body: nothing is lost or mixed up, blocks and cells are in order, and memory stays small."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest

import mpmkit as mpm
from mpmkit._core.composing import jit, simd
from mpmkit._core.composing.sorting import sort_functions
from mpmkit._core.running.blocks import BodyBlocks
from mpmkit._core.running.lattice import Lattice
from mpmkit._core.running.sort import Scratch, sort_body
from mpmkit.errors import StabilityError

EDGE = {1: 32, 2: 8, 3: 4}


def module_for(dim, B, compiled=lambda f: f, prefetch=lambda a, i: None):
    """The functions, as plain Python whatever the environment says."""
    scope = {"compiled": compiled, "prefetch": prefetch}
    exec("from math import floor\n" + sort_functions(dim, B), scope)
    return SimpleNamespace(**scope)


def particles(x, R=None, dtype=np.float64, first_x=1):
    """A body whose component k of particle p is 1000 p + k, beside the positions."""
    n, dim = x.shape
    R = R or dim + 3
    full = 1000.0 * np.arange(n)[:, None] + np.arange(R)
    full[:, first_x : first_x + dim] = x
    tiled = np.zeros((-(-n // 16) * 16, R), dtype=dtype)
    tiled[:n] = full
    P = np.ascontiguousarray(tiled.reshape(-1, 16, R).transpose(0, 2, 1)).ravel()
    return SimpleNamespace(P=P, n=n, layout=SimpleNamespace(size=R, start={"x": first_x}))


def records(store):
    return store.P.reshape(-1, store.layout.size, 16).transpose(0, 2, 1).reshape(-1, store.layout.size)


def lattice_for(dim, n=3, offset=0.5, cells=40, dtype=np.float64, B=None):
    return Lattice(mpm.Grid((-1.0,) * dim, (-1.0 + 0.5 * cells,) * dim, 0.5), B or max(EDGE[dim], n + 1), n, offset, dtype)


def positions(lattice, count, seed=0):
    lower, upper = np.array(lattice.grid.lower), np.array(lattice.grid.upper)
    return lower + np.random.default_rng(seed).random((count, lattice.dim)) * (upper - lower)


def base_nodes(lattice, x):
    """First node of each particle, counted from the first ghost node."""
    xi = ((x - lattice.lower) * lattice.inv_h - lattice.dtype(lattice.offset)).astype(lattice.dtype)
    return np.minimum(np.floor(xi).astype(int), lattice.cells - 1) + lattice.ghosts


def check_sorted(lattice, blocks, x):
    """Every particle lies in the block that claims it, blocks come by colour, then by x, y, z, cells in order inside a block."""
    base = base_nodes(lattice, x)
    block = np.repeat(np.arange(blocks.count), np.diff(blocks.starts))
    assert len(block) == len(x) and (np.diff(blocks.starts) > 0).all()
    np.testing.assert_array_equal(base // lattice.B, blocks.coords[block, : lattice.dim])
    digits = (base % lattice.B).T
    cell = np.ravel_multi_index(tuple(digits), (lattice.B,) * lattice.dim)
    assert all((np.diff(cell[block == b]) >= 0).all() for b in range(blocks.count))
    key = [(*(c[: min(lattice.dim, 2)] % 2), *c) for c in blocks.coords.tolist() for c in [np.array(c)]]
    assert key == sorted(key) and len(set(key)) == len(key)
    return block, cell


CASES = [(1, 2, 0.0), (1, 3, 0.5), (1, 4, 1.0), (2, 2, 0.0), (2, 3, 0.5), (2, 4, 1.0), (3, 2, 0.0), (3, 3, 0.5), (3, 4, 1.0)]


@pytest.mark.parametrize(("dim", "n", "offset"), CASES)
def test_sorted_particles_are_the_same_particles(dim, n, offset):
    lattice = lattice_for(dim, n, offset, cells=12)
    module, store = module_for(dim, lattice.B), particles(positions(lattice, 250))
    before, ids = records(store).copy(), np.arange(250, dtype=np.int32)
    blocks = BodyBlocks(lattice)
    assert sort_body(module, store, lattice, blocks, Scratch(), ids)
    after = records(store)
    np.testing.assert_array_equal(np.sort(ids), np.arange(250))
    np.testing.assert_array_equal(after[:250], before[ids])
    assert not after[250:].any()  # the padding of the last tile
    x = after[:250, 1 : 1 + dim]
    block, cell = check_sorted(lattice, blocks, x)
    same = (np.diff(block) == 0) & (np.diff(cell) == 0)
    assert same.any() or dim == 3  # some particles share a cell,
    assert (np.diff(ids)[same] > 0).all()  # and have kept their order: the sort is stable
    assert not lattice.table.any()


@pytest.mark.parametrize("dim", [1, 2, 3])
def test_sorted_again_after_a_drift(dim):
    lattice = lattice_for(dim, cells=12)
    module, store = module_for(dim, lattice.B), particles(positions(lattice, 300))
    blocks, scratch, ids = BodyBlocks(lattice), Scratch(), np.arange(300, dtype=np.int32)
    sort_body(module, store, lattice, blocks, scratch, ids)
    assert not sort_body(module, store, lattice, blocks, scratch, ids)  # nothing has moved
    rng = np.random.default_rng(1)
    for _ in range(3):
        tiled = store.P.reshape(-1, store.layout.size, 16)
        x = records(store)[:300, 1 : 1 + dim] + rng.normal(0.0, 0.2 * 0.5, (300, dim))
        x = np.clip(x, np.array(lattice.grid.lower), np.array(lattice.grid.upper))
        padded = np.zeros((len(tiled) * 16, dim))
        padded[:300] = x
        tiled[:, 1 : 1 + dim, :] = padded.reshape(-1, 16, dim).transpose(0, 2, 1)
        before, old = records(store).copy(), ids.copy()
        assert sort_body(module, store, lattice, blocks, scratch, ids)
        place = np.argsort(old)[ids]
        np.testing.assert_array_equal(records(store)[:300], before[place])
        check_sorted(lattice, blocks, records(store)[:300, 1 : 1 + dim])


def test_only_places_that_change_are_moved():
    lattice = lattice_for(1)
    x = -1.0 + 0.5 * np.array([[3.2], [3.3], [7.6], [6.1], [9.0], [9.5]])
    source, place, key = np.zeros(6, dtype=np.int32), np.zeros(6, dtype=np.int32), np.zeros(6, dtype=np.int32)
    module, store, found = module_for(1, 32), particles(x), np.zeros(4, dtype=np.int64)
    geometry = (lattice.lower, lattice.inv_h, 0.5, lattice.cells, lattice.ghosts, lattice.shape, lattice.table)
    assert module.find_blocks(store.P, 6, store.layout.size, 1, *geometry, key, found) == 1
    np.testing.assert_array_equal(key, [3, 3, 8, 6, 9, 10])
    starts, changed = np.zeros(2, dtype=np.int64), np.zeros(2, dtype=np.int64)
    module.order_particles(6, np.zeros(1, dtype=np.int64), key, np.zeros(32, dtype=np.int32), starts, source, place, changed)
    np.testing.assert_array_equal(source, [0, 1, 3, 2, 4, 5])
    np.testing.assert_array_equal(changed, [2, 4])
    np.testing.assert_array_equal(starts, [0, 6])
    assert module.assign_slots(source, place, key, 2, 4) == 1


def test_room_for_blocks_grows():
    lattice = lattice_for(2, cells=200)
    blocks, module = BodyBlocks(lattice), module_for(2, lattice.B)
    store = particles(positions(lattice, 400))
    found, key = np.zeros(5, dtype=np.int64), np.zeros(400, dtype=np.int32)
    geometry = (lattice.lower, lattice.inv_h, 0.5, lattice.cells, lattice.ghosts, lattice.shape, lattice.table)
    assert module.find_blocks(store.P, 400, store.layout.size, 1, *geometry, key, found) == -1
    assert not lattice.table.any()
    sort_body(module, store, lattice, blocks, Scratch())
    assert blocks.count > 64
    check_sorted(lattice, blocks, records(store)[:400, 1:3])


def test_a_reversed_body_moves_in_sweeps_of_little_memory(monkeypatch):
    lattice = lattice_for(1, cells=300)
    store = particles(np.linspace(148.0, -0.9, 500)[:, None], R=29)
    before, ids, sizes = records(store).copy(), np.arange(500), []
    empty = np.empty
    monkeypatch.setattr(np, "empty", lambda shape, dtype=float: sizes.append(np.prod(shape)) or empty(shape, dtype=dtype))
    sort_body(module_for(1, 32), store, lattice, BodyBlocks(lattice), Scratch(), ids)
    np.testing.assert_array_equal(records(store)[:500], before[ids])
    assert max(sizes) <= 4 * 500  # numbers aside; all components at once would be 29 for each of nearly half of the particles


def test_threads_move_different_components():
    lattice = lattice_for(2, cells=12)
    x = positions(lattice, 200)
    one, two = particles(x, R=11), particles(x, R=11)
    counts = []

    def run(tasks):
        counts.append(len(tasks))
        team = [threading.Thread(target=t) for t in tasks]
        for t in team:
            t.start()
        for t in team:
            t.join()

    module = module_for(2, 8)
    sort_body(module, one, lattice, BodyBlocks(lattice), Scratch())
    sort_body(module, two, lattice, BodyBlocks(lattice), Scratch(), threads=3, run=run)
    np.testing.assert_array_equal(one.P, two.P)
    assert max(counts) > 1


def test_particles_on_faces_and_in_float32():
    lattice = lattice_for(2, cells=12, dtype=np.float32)
    x = np.concatenate([positions(lattice, 100), [[-1.0, -1.0], [5.0, 5.0], [-1.0, 5.0], [5.0, 0.0]]])
    store = particles(x, dtype=np.float32)
    blocks = BodyBlocks(lattice)
    sort_body(module_for(2, 8), store, lattice, blocks, Scratch())
    check_sorted(lattice, blocks, records(store)[:104, 1:3])


def test_a_particle_below_the_domain_is_named():
    lattice = lattice_for(2, cells=12)
    x = positions(lattice, 50)
    x[17] = [-9.25, 0.0]
    with pytest.raises(StabilityError, match=r"particle 17 .*x = \(-9.25, 0\) m is below the domain"):
        sort_body(module_for(2, 8), particles(x), lattice, BodyBlocks(lattice), Scratch())
    assert not lattice.table.any()


def test_cells_beyond_the_upper_face_do_not_exist():
    """As in the particle loops: a particle on the upper face belongs to the last cell."""
    lattice = lattice_for(1, 2, 0.0, cells=32)
    blocks = BodyBlocks(lattice)
    sort_body(module_for(1, 32), particles(np.array([[15.0], [0.0]])), lattice, blocks, Scratch())
    np.testing.assert_array_equal(blocks.coords, [[0, 0, 0]])


@pytest.mark.skipif(not jit.enabled(), reason="needs the compiler")
def test_compiled_and_plain_python_agree():
    import numba

    lattice = lattice_for(3, cells=20)
    module = module_for(3, 4, compiled=lambda f: numba.njit(**jit.FLAGS)(f), prefetch=simd.functions()["prefetch"])
    x = positions(lattice, 3000)
    plain, fast = particles(x), particles(x)
    a, b, ids, fast_ids = BodyBlocks(lattice), BodyBlocks(lattice), np.arange(3000), np.arange(3000)
    sort_body(module_for(3, 4), plain, lattice, a, Scratch(), ids)
    sort_body(module, fast, lattice, b, Scratch(), fast_ids)
    np.testing.assert_array_equal(fast.P, plain.P)
    np.testing.assert_array_equal(fast_ids, ids)
    np.testing.assert_array_equal(a.starts, b.starts)
    np.testing.assert_array_equal(a.numbers, b.numbers)
    assert not sort_body(module, fast, lattice, b, Scratch(), fast_ids)
