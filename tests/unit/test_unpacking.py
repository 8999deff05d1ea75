"""Fields for result files against the store's own reading, with particles in an order of their own."""

import numpy as np
import pytest
from small_scenes import RUBBER, box, grid, simulation

import mpmkit as mpm
from mpmkit._core.running.unpacking import unpack
from mpmkit.integrators import APIC, MUSL

pytestmark = pytest.mark.usefixtures("plain_python")


@pytest.mark.parametrize("space", ["1D", "plane strain", "axisymmetric", "3D"])
@pytest.mark.parametrize("ends", [((0.25, 0.75), (1.0, 1.75)), ((0.25, 0.5), (1.0, 1.25))], ids=["many", "one tile"])
def test_every_field_in_every_space(space, ends, monkeypatch):
    from mpmkit._core.running import unpacking

    monkeypatch.setattr(unpacking, "_TILES", 2)  # several pieces, the last one not full
    bodies = [mpm.Body(box(space, *both), RUBBER, name=str(k)) for k, both in enumerate(ends)]
    stores = simulation(grid(space), *bodies, integrator=MUSL(APIC())).compose().engine.stores
    rng = np.random.default_rng(2)
    for s in stores:
        s.P[:] = 1.0 + rng.random(s.P.shape)
        s.ids[:] = rng.permutation(s.n)
    for name in stores[0].available():
        found = unpack(stores, name, np.float32)
        wanted = np.concatenate([s.get(name).reshape(s.n, -1) for s in stores]).astype(np.float32)
        columns = found.reshape(len(found), -1)
        assert np.array_equal(columns[:, : wanted.shape[1]], wanted), name
        assert not columns[:, wanted.shape[1] :].any(), name
        assert found.dtype == np.float32 and found.flags.c_contiguous | (found.ndim == 1)
