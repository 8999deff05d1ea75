"""Threads: how many, which errors, and that state and history are the same to the bit for any number of them."""

from __future__ import annotations

import gc
import inspect
import json
import os
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import mpmkit as mpm
from mpmkit._core.composing import jit
from mpmkit._core.running import workers
from mpmkit._core.running.timestep import next_step
from mpmkit.boundaries import Symmetry, TractionLayer, Wall
from mpmkit.contacts import FrictionalContact
from mpmkit.discretizations import FEM
from mpmkit.effects import ArtificialViscosity, BodyForce, Damping, Gravity
from mpmkit.errors import CompositionError
from mpmkit.integrators import APIC, MUSL, USL, XPIC
from mpmkit.materials import NeoHookean, VonMises
from mpmkit.shapes import CubicBSpline, Linear, QuadraticBSpline

RUBBER = NeoHookean(E=1000.0, nu=0.3, rho=1.0)


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    """The machine has two cores, or the tests pretend it has: two threads on one core are slower, and must not be wrong."""
    monkeypatch.delenv("MPMKIT_THREADS", raising=False)
    monkeypatch.setattr(workers, "available", lambda: 2)


# --- how many -----------------------------------------------------------------------------------------------------
def tiny():
    sim = mpm.Simulation(mpm.Grid(0.0, 1.0, 0.1), shape=Linear(), integrator=MUSL(dt=1e-3), until=0.01)
    sim += mpm.Body(mpm.Box(0.2, 0.5), RUBBER, v=0.1)
    return sim


@pytest.mark.parametrize("threads", [0, -1, 3])
def test_numbers_that_are_not_allowed(threads, plain_python):
    sim = tiny()
    with pytest.raises(CompositionError, match=rf"threads = {threads} is not allowed: 1 to 2, as this process may use 2 cores"):
        sim.run(quiet=True, threads=threads)
    assert sim.compose()._engine is None, "refused before anything is compiled"
    sim.run(quiet=True, threads=2)
    with pytest.raises(CompositionError, match=r"1 to 2"):
        sim.run(until=0.02, quiet=True, threads=threads)
    assert sim.t == 0.01


@pytest.mark.parametrize("threads", ["2", 1.5, True])
def test_what_is_no_number(threads, plain_python):
    with pytest.raises(CompositionError, match=rf"threads = {threads!r} is not a whole number; allowed: 1 to 2"):
        tiny().run(quiet=True, threads=threads)


@pytest.mark.parametrize(
    ("text", "message"), [("abc", "= 'abc' is not a whole number"), ("0", "= 0 is not allowed"), ("9", "= 9 is not allowed")]
)
def test_environment_variable(text, message, monkeypatch, plain_python):
    monkeypatch.setenv("MPMKIT_THREADS", text)
    with pytest.raises(CompositionError, match=rf"MPMKIT_THREADS {message}.*1 to 2"):
        tiny().run(quiet=True)
    tiny().run(quiet=True, threads=1)  # what is asked for in the call counts


def test_how_many_are_chosen(monkeypatch):
    assert [workers.chosen(None, n) for n in (1, 39_999, 40_000, 10**7)] == [1, 1, 2, 2]
    assert workers.chosen(2, 1) == 2
    monkeypatch.setenv("MPMKIT_THREADS", "2")
    assert workers.chosen(None, 1) == 2 and workers.chosen(1, 1) == 1


def test_more_threads_than_cores_say_why():
    with pytest.raises(CompositionError, match="more threads than cores would only wait for each other"):
        workers.chosen(3, 1)
    with pytest.raises(CompositionError, match="cores$"):
        workers.chosen(0, 1)


def test_scenes_and_checkpoints_know_no_threads(tmp_path, plain_python):
    from mpmkit._core.running import checkpoint

    sim = tiny()
    sim += mpm.Record(str(tmp_path / "run.vtkhdf"))
    sim.run(quiet=True, threads=2)
    arrays, attributes = checkpoint.load(tmp_path / "run.ckpt.h5")
    assert "threads" not in sim.scene_text()[0] and "threads" not in json.dumps([*arrays, attributes])
    other = mpm.Simulation.from_checkpoint(tmp_path / "run.ckpt.h5")
    other.run(until=0.02, quiet=True, threads=1)
    assert other.step_number > sim.step_number


def test_the_command_line_takes_them(tmp_path):
    scene = tmp_path / "bar.toml"
    scene.write_text(tiny().scene_text()[0])

    def call(*arguments):
        command = [sys.executable, "-m", "mpmkit", *arguments]
        return subprocess.run(
            command, cwd=tmp_path, capture_output=True, text=True, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, check=False
        )

    done = call("run", "bar.toml", "--quiet", "--threads", "1", "--output", "bar.vtkhdf")
    assert done.returncode == 0, done.stderr
    assert call("resume", "bar.ckpt.h5", "--until", "0.02", "--quiet", "--threads", "1").returncode == 0
    refused = call("resume", "bar.ckpt.h5", "--until", "0.03", "--threads", "-1")
    assert refused.returncode == 1 and "threads = -1 is not allowed" in refused.stderr


# --- the team -----------------------------------------------------------------------------------------------------
def helpers():
    """Threads of all teams there are, also of those that are about to end."""
    return {t for t in threading.enumerate() if t.name.startswith("mpmkit-") and "writer" not in t.name}


def test_teams_end_with_their_engines():
    before = helpers()
    team = workers.Team(3)
    mine = helpers() - before
    assert len(mine) == 2
    done = []
    team.run(lambda thread, item: done.append((thread, item)), range(20))
    assert sorted(item for _, item in done) == list(range(20)) and {thread for thread, _ in done} <= {0, 1, 2}
    del team
    gc.collect()
    end = time.monotonic() + 5.0
    while helpers() & mine and time.monotonic() < end:
        time.sleep(0.01)
    assert not helpers() & mine


def test_errors_of_any_thread_are_raised_and_the_team_goes_on():
    team = workers.Team(2)

    def work(thread, item):
        if item == 7:
            raise ValueError("seven")

    with pytest.raises(ValueError, match="seven"):
        team.run(work, range(20))
    done = []
    team.run(lambda thread, item: done.append(item), range(4))
    assert sorted(done) == [0, 1, 2, 3]
    team.close()


# --- the same to the bit ------------------------------------------------------------------------------------------
def boxes(dim, *parts, cells, shape=None, integrator=None, material=RUBBER, **more):
    """Two boxes that meet under way, in a domain of 1 m."""
    g = mpm.Grid((0.0,) * dim, (1.0,) * dim, 1.0 / cells, coordinates=more.pop("coordinates", "cartesian"))
    sim = mpm.Simulation(g, shape=shape, integrator=integrator, **more)
    side = [(0.25, 0.75)] * (dim - 1)
    for name, low, high, v in (("left", 0.2, 0.5, 1.0), ("right", 0.5, 0.8, -1.0)):
        lower, upper = zip((low, high), *side, strict=True)
        sim += mpm.Body(mpm.Box(lower, upper), material, v=(v, *(0.3,) * (dim - 1)), name=name)
    sim += parts
    return sim


ROUGH = FrictionalContact(friction=0.3)


def plane_contact():
    """2D, quadratic, MUSL with APIC, contact, viscosity."""
    return boxes(
        2,
        ROUGH,
        Wall("all"),
        ArtificialViscosity(),
        Gravity((0.0, -9.81)),
        cells=32,
        shape=QuadraticBSpline(),
        integrator=MUSL(APIC(), dt=5e-4),
    )


def plane_xpic():
    """2D, linear, XPIC(3), loads of a layer, float32."""
    parts = (TractionLayer("left", (5.0, 0.0), "xmin"), BodyForce(("y", "-x")), Damping(rate=1.0))
    return boxes(2, *parts, cells=48, shape=Linear(), integrator=MUSL(XPIC(3), dt=5e-4), precision="float32")


def space_xpic():
    """3D, linear, USL with XPIC(2)."""
    return boxes(3, Wall("all"), cells=20, shape=Linear(), integrator=USL(XPIC(2), dt=1e-3))


def space_apic():
    """3D, quadratic, USL with APIC."""
    return boxes(3, Wall("all"), cells=12, shape=QuadraticBSpline(), integrator=USL(APIC(), dt=1e-3))


def mesh():
    """2D, finite elements."""
    return boxes(2, Wall("xmin", "no slip"), Gravity((0.0, -9.81)), cells=64, discretization=FEM())


def space_contact():
    """3D, cubic, MUSL with APIC, contact, plasticity."""
    law = VonMises(E=1000.0, nu=0.3, rho=1.0, yield_stress=20.0)
    return boxes(
        3, ROUGH, Wall("all"), Gravity((0.0, 0.0, -9.81)), cells=16, shape=CubicBSpline(), integrator=MUSL(APIC(), dt=5e-4), material=law
    )


def rings():
    """Axisymmetric, cubic, MUSL with FLIP, contact."""
    return boxes(2, ROUGH, Symmetry("xmin"), cells=48, shape=CubicBSpline(), integrator=MUSL(dt=2e-4), coordinates="axisymmetric")


def equal_to_the_bit(make, steps=20):
    found = []
    for threads in (1, 2):
        sim = make()
        run = sim.compose()
        run.use(threads)
        run.warm_up()
        engine = run.engine
        assert engine.team.size == threads
        if not engine.c.stored_operator:
            most = max(len(turn) for b in engine.places.blocks for turn in b.chunks(2))
            assert most > 1, "the scene gives two threads something to do at the same time"
        sim.run(until=steps * next_step(engine).dt, quiet=True, threads=threads)
        assert sim.step_number >= steps // 2
        found.append((sim.particles(), sim.history, {n: a.copy() for n, a in engine.state().items()}))
    for one, two in zip(*found, strict=True):
        assert one.keys() == two.keys()
        for name in one:
            assert np.array_equal(one[name], two[name]), name
    return found[0]


@pytest.mark.physics
@pytest.mark.parametrize("make", [plane_contact, space_xpic, mesh], ids=inspect.getdoc)
@pytest.mark.filterwarnings("ignore:energy is being created")
def test_results_do_not_depend_on_threads(make):
    assert jit.enabled()
    particles, history, _ = equal_to_the_bit(make)
    assert np.isfinite(particles["x"]).all() and len(history["t"]) > 1
    assert 1000 < len(particles["x"]) < 10_000


@pytest.mark.physics
@pytest.mark.parametrize("make", [space_contact, space_apic, plane_xpic, rings], ids=inspect.getdoc)
@pytest.mark.filterwarnings("ignore:energy is being created")
def test_results_of_long_compilations_do_not_depend_on_threads(make):
    equal_to_the_bit(make, steps=60)


@pytest.mark.filterwarnings("ignore:energy is being created")
def test_threads_may_change_under_way(plain_python):
    def ran(*threads):
        sim = boxes(2, ROUGH, cells=20, shape=QuadraticBSpline(), integrator=MUSL(dt=1e-3))
        for k, number in enumerate(threads, 1):
            sim.run(until=2e-3 * k, quiet=True, threads=number)
        return sim.particles(), sim.history

    for one, other in zip(ran(1, 1, 1), ran(2, 1, 2), strict=True):
        assert all(np.array_equal(one[name], other[name]) for name in one)
