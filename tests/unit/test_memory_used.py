"""Memory that a run has used, by Python's own count of what is allocated."""

from __future__ import annotations

import tracemalloc

import pytest
from small_scenes import RUBBER

import mpmkit as mpm
from mpmkit.integrators import MUSL
from mpmkit.shapes import QuadraticBSpline


@pytest.mark.physics
def test_a_million_particles_take_little_beside_their_fields(tmp_path):
    """At the peak, with sampling, sorting and frames, under 1.3 times the declared fields of particles and nodes."""

    def block(side):
        sim = mpm.Simulation(mpm.Grid((0.0,) * 3, (1.0,) * 3, 0.01), QuadraticBSpline(), MUSL(dt=1e-4), until=2e-4)
        sim += mpm.Body(mpm.Box((0.25,) * 3, (0.25 + side / 100,) * 3), RUBBER, (1.0, 0.5, 0.0))
        sim += mpm.Record(tmp_path / f"{side}.vtkhdf", fields=("v", "stress"), every=1e-4)
        return sim

    block(3).run(quiet=True)  # compiled, and everything imported
    sim = block(50)
    tracemalloc.start()
    sim.run(quiet=True)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    engine = sim.compose().engine
    declared = sum(s.P.nbytes for s in engine.stores) + sum(8 * f.channels * f.n_nodes for f in engine.fields)
    assert sim.compose().n_particles == 1_000_000 and peak < 1.3 * declared, f"{peak / declared:.3f} times the fields"
