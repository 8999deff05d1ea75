"""Nothing is left to compile once a run has begun, not even what the first contact needs."""

from __future__ import annotations

import pytest
from small_scenes import RUBBER, box, grid, simulation

import mpmkit as mpm
from mpmkit._core.composing import machine_code
from mpmkit.contacts import FrictionalContact


def looked_for(code, *_):
    raise AssertionError(f"{code._name} is compiled, or read from the cache, in the middle of a run")


@pytest.mark.physics
def test_bodies_that_meet_later_compile_nothing(monkeypatch):
    bodies = [mpm.Body(box("plane strain", a, a + 0.5), RUBBER, (v, 0.0), name=str(a)) for a, v in ((0.25, 2.0), (1.25, -2.0))]
    sim = simulation(grid("plane strain"), *bodies, FrictionalContact())
    run = sim.compose()
    run.warm_up()
    contact = run.engine.contact
    assert not any(pair.count for pair in contact.pairs)
    monkeypatch.setattr(machine_code.MachineCode, "load_overload", looked_for)
    sim.run(until=0.15, quiet=True)
    assert any(pair.count for pair in contact.pairs), "they have met"
