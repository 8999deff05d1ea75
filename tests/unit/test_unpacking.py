"""Fields for result files against the store's own reading, with particles in an order of their own."""

import numpy as np
import pytest
from small_scenes import RUBBER, box, grid, simulation

import mpmkit as mpm
from mpmkit._core.running import store, unpacking
from mpmkit._core.running.frames import Packed
from mpmkit._core.running.unpacking import unpack, unpack_pieces
from mpmkit.integrators import APIC, MUSL

pytestmark = pytest.mark.usefixtures("plain_python")


@pytest.mark.parametrize("space", ["1D", "plane strain", "axisymmetric", "3D"])
@pytest.mark.parametrize("ends", [((0.25, 0.75), (1.0, 1.75)), ((0.25, 0.5), (1.0, 1.25))], ids=["many", "one tile"])
def test_every_field_in_every_space(space, ends, monkeypatch):
    for module, name, rows in ((unpacking, "AT_ONCE", 2), (store, "AT_ONCE", 2), (unpacking, "_ROWS", 7)):
        monkeypatch.setattr(module, name, rows)  # several pieces, the last one not full
    bodies = [mpm.Body(box(space, *both), RUBBER, name=str(k)) for k, both in enumerate(ends)]
    stores = simulation(grid(space), *bodies, integrator=MUSL(APIC())).compose().engine.stores
    rng = np.random.default_rng(2)
    for s in stores:
        s.P[:] = 1.0 + rng.random(s.P.shape)
        s.ids[:] = rng.permutation(s.n)
    packed = Packed(stores)
    for name in stores[0].available():
        assert np.array_equal(packed[name], np.concatenate([s.get(name) for s in stores])), name
        pieces = list(unpack_pieces(stores, name, np.float32))
        assert max(map(len, pieces)) <= 7 and np.array_equal(np.concatenate(pieces), unpack(stores, name, np.float32)), name
        found = unpack(stores, name, np.float32)
        wanted = np.concatenate([s.get(name).reshape(s.n, -1) for s in stores]).astype(np.float32)
        columns = found.reshape(len(found), -1)
        assert np.array_equal(columns[:, : wanted.shape[1]], wanted), name
        assert not columns[:, wanted.shape[1] :].any(), name
        assert found.dtype == np.float32 and found.flags.c_contiguous | (found.ndim == 1)
