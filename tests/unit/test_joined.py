"""One pass for the end of a step and the beginning of the next: the same to the bit as two, also when particles stray or dt changes."""

from __future__ import annotations

import numpy as np
import pytest
from small_scenes import RUBBER, box, grid, simulation

import mpmkit as mpm
from mpmkit._core.running import engine as engine_module
from mpmkit._core.running.engine import Engine
from mpmkit._core.running.loop import Run
from mpmkit._core.running.timestep import next_step
from mpmkit.boundaries import Wall
from mpmkit.effects import ArtificialViscosity, Gravity
from mpmkit.integrators import MLS, MUSL, PIC, USF, USL
from mpmkit.shapes import ContiguousGIMP, QuadraticBSpline

pytestmark = pytest.mark.usefixtures("plain_python")


def two(v, *parts, **more):
    """Two blocks that approach each other."""
    bodies = [mpm.Body(box("plane strain", a, a + 0.5), RUBBER, (u, 0.3), name=n) for n, a, u in (("a", 0.3, v), ("b", 1.0, -v))]
    return simulation(grid("plane strain"), *bodies, Wall("all", condition="slip"), *parts, **more)


MERGED = {"limit": 0.0, "dt": 2e-3}
SCENES = {
    "gravity": lambda: two(0.5, Gravity((0.0, -9.81)), integrator=USL(MLS(), **MERGED)),
    "fast": lambda: two(6.0, integrator=USL(MLS(), limit=0.0, dt=1e-2)),  # a quarter of a cell in each step
    "viscosity": lambda: two(1.0, ArtificialViscosity(), integrator=USL(MLS(), **MERGED)),
    "sizes": lambda: two(0.5, shape=ContiguousGIMP(), integrator=USL(PIC(), **MERGED)),
    "single precision": lambda: two(0.5, integrator=USL(MLS(), **MERGED), precision="float32"),
}


def stepped(make, joins, steps, change=()):
    run = Run(make())
    e = Engine(run.plan, run._stores, 1)
    e.start()
    assert e.joins == joins
    used = 0
    for k in range(steps):
        e.step(next_step(e).dt * (0.5 if k in change else 1.0))
        used += e.ready is not None
        if k % 5 == 0:
            e.ledger()
    return {n: a.copy() for n, a in e.state().items()}, used


@pytest.mark.parametrize("name", SCENES)
def test_joined_steps_are_the_same_to_the_bit(name, monkeypatch):
    apart, _ = stepped(SCENES[name], False, 12, change=(5,))
    monkeypatch.setattr(engine_module, "JOIN_BYTES", 0)
    joined, used = stepped(SCENES[name], True, 12, change=(5,))
    assert used >= 4, "the scene joins steps"
    if name == "fast":
        assert used < 12, "and sometimes cannot"
    assert joined.keys() == apart.keys()
    for array in apart:
        assert np.array_equal(apart[array], joined[array]), array


def test_steps_are_joined_only_where_it_is_sound(monkeypatch):
    """Not if there is a third loop, if nodes hold more than one sum, or if the first loop needs the length of a step that is not known yet."""
    monkeypatch.setattr(engine_module, "JOIN_BYTES", 0)
    merged = USL(MLS(), limit=0.0, dt=1e-3)
    for integrator, joins in ((MUSL(), False), (USF(), False), (USL(), False), (USL(MLS(), limit=0.0), False), (merged, True)):
        run = Run(two(0.5, integrator=integrator, shape=QuadraticBSpline()))
        assert Engine(run.plan, run._stores, 1).joins == joins, integrator


def test_small_bodies_are_stepped_apart():
    run = Run(SCENES["gravity"]())
    assert run.plan.schedule.cycle is not None and not Engine(run.plan, run._stores, 1).joins
