"""The thread that writes: order, bounds, errors; and what a run makes of them."""

import threading

import numpy as np
import pytest
from small_scenes import bar

import mpmkit as mpm
from mpmkit._core.running import checkpoint, recorder, snapshot
from mpmkit._core.running.vtkhdf import ParticleFile
from mpmkit._core.running.writing import Writer
from mpmkit.boundaries import TwoPointTraction, Wall
from mpmkit.errors import ResultsError
from mpmkit.integrators import MUSL

pytestmark = pytest.mark.usefixtures("plain_python")


def test_jobs_are_done_in_order_beside_the_caller():
    writer, done, gate = Writer(), [], threading.Event()
    writer.submit("frame", lambda: (gate.wait(), done.append(1)))
    writer.submit("checkpoint", lambda: done.append(2))
    assert done == []
    threading.Timer(0.05, gate.set).start()
    writer.submit("frame", lambda: done.append(3))  # waits for the first
    assert done[:1] == [1]
    writer.finish()
    assert done == [1, 2, 3]


def test_after_a_failure_nothing_more_is_begun():
    writer, done, gate = Writer(), [], threading.Event()

    def fail():
        gate.wait()
        raise ResultsError("full")

    writer.submit("frame", fail)
    writer.submit("checkpoint", lambda: done.append(1))
    writer.check()
    gate.set()
    assert str(writer.settle()) == "full"
    for call in (writer.check, writer.finish, lambda: writer.wait("frame"), lambda: writer.submit("frame", lambda: done.append(2))):
        with pytest.raises(ResultsError, match="full"):
            call()
    assert done == []


def recorded(path, **more):
    record = mpm.Record(path, every=0.05, history=3, **more)
    return bar(TwoPointTraction("bar", (0.05,), "xmax"), Wall("xmin", condition="no slip"), record, n=4)


@pytest.fixture
def full_disk(monkeypatch):
    """The fourth frame cannot be written."""
    write = ParticleFile._write

    def counted(self, *arguments):
        if self.n_frames == 3:
            raise OSError(28, "No space left on device")
        write(self, *arguments)

    monkeypatch.setattr(ParticleFile, "_write", counted)
    monkeypatch.setattr(recorder, "CHECKPOINT_SECONDS", 0.0)
    return lambda: monkeypatch.setattr(ParticleFile, "_write", write)


def test_full_disk_in_mid_run(tmp_path, full_disk):
    """The run stops soon; frames and checkpoint are whole and belong together; with room again it goes on as if nothing had been."""
    sim = recorded(tmp_path / "run.vtkhdf")
    with pytest.raises(mpm.ResultsError, match=r"cannot write frame 3 at t = 0\.15 s .*\n.*step \d+, t = 0\.1 s, .*run\.ckpt\.h5"):
        sim.run(until=1.0, quiet=True)
    assert sim.t < 0.25
    assert mpm.Results(tmp_path / "run.vtkhdf").times.tolist() == [0.0, 0.05, 0.1]
    assert not list(tmp_path.glob(".*.tmp"))
    full_disk()
    mpm.Simulation.from_checkpoint(tmp_path / "run.ckpt.h5").run(until=0.5, quiet=True)
    recorded(tmp_path / "whole.vtkhdf").run(until=0.5, quiet=True)
    a, b = (mpm.Results(tmp_path / name) for name in ("run.vtkhdf", "whole.vtkhdf"))
    assert a.times.tolist() == b.times.tolist()
    for f, g in zip(a.frames, b.frames, strict=True):
        assert np.array_equal(f["x"], g["x"]) and np.array_equal(f["stress"], g["stress"])


def test_full_disk_without_checkpoints(tmp_path, full_disk):
    sim = recorded(tmp_path / "run.vtkhdf", checkpoint=False)
    with pytest.raises(mpm.ResultsError, match="kept in this simulation$"):
        sim.run(until=1.0, quiet=True)
    assert np.isfinite(sim.particles()["x"]).all()


def test_costly_checkpoints_are_rare(tmp_path, monkeypatch):
    """A tenth of a second of work each, at most 2 % of the time: every 5 s, while there is a frame each second."""
    sealed, now = [], [1000.0]

    class Clock:
        @staticmethod
        def perf_counter():
            return now[0]

    def seal(path, temporary):
        sealed.append(now[0])
        now[0] += 0.1
        temporary.replace(path)

    sim = recorded(tmp_path / "run.vtkhdf")
    frame = recorder.Recorder._frame

    def a_second(self, row):
        frame(self, row)
        self.run.writer.finish()
        now[0] += 1.0

    monkeypatch.setattr(recorder.Recorder, "_frame", a_second)
    monkeypatch.setattr(recorder, "time", Clock)
    monkeypatch.setattr(recorder.checkpoint, "seal", seal)
    sim.run(until=2.0, quiet=True)
    gaps = np.diff(sealed)[:-1]  # the last checkpoint is that of the end, whenever that is
    assert len(gaps) >= 5 and 5.0 <= gaps.min() and gaps.max() < 7.0


def failing(**more):
    """Pulled until the bar leaves the domain."""
    return bar(*more.pop("parts", ()), v="5*x", integrator=MUSL(cfl=0.5), **more)


@pytest.fixture
def large(monkeypatch):
    monkeypatch.setattr(snapshot, "IN_MEMORY", 100)


@pytest.mark.filterwarnings("ignore:energy is being created")
def test_large_state_without_a_record_is_not_kept(large):
    sim = failing()
    with pytest.raises(mpm.StabilityError, match=r"last good state: not kept: .*add a Record\(path, checkpoint=True\)"):
        sim.run(until=10.0, quiet=True)


@pytest.mark.filterwarnings("ignore:energy is being created")
def test_large_state_is_that_of_the_last_checkpoint(large, tmp_path, monkeypatch):
    """Also between two frames, once a minute."""
    monkeypatch.setattr(recorder, "STATE_SECONDS", 0.0)
    monkeypatch.setattr(recorder, "CHECKPOINT_SECONDS", 0.0)
    sim = failing(parts=(mpm.Record(tmp_path / "run.vtkhdf"),))
    with pytest.raises(mpm.StabilityError, match=r"last good state: step (\d+), .*run\.ckpt\.h5 \(the last checkpoint\)") as caught:
        sim.run(until=10.0, quiet=True)
    arrays, attributes = checkpoint.load(tmp_path / "run.ckpt.h5")
    assert 0 < attributes["step"] < sim.step_number and f"last good state: step {attributes['step']}, " in str(caught.value)
    assert all(np.isfinite(a).all() for a in arrays.values() if a.dtype.kind == "f")


@pytest.mark.parametrize("limit", [0, 1 << 40])
def test_a_trial_step_leaves_no_trace(limit, monkeypatch):
    monkeypatch.setattr(snapshot, "IN_MEMORY", limit)
    monkeypatch.setattr(snapshot, "SPILLED", 0)
    sim = bar(v="0.01*x")
    sim.run(until=0.3, quiet=True)
    engine = sim.compose().engine
    before = {name: array.tobytes() for name, array in engine.state().items()}
    with snapshot.unchanged(engine):
        engine.step(1e-3)
        assert any(array.tobytes() != before[name] for name, array in engine.state().items())
    assert {name: array.tobytes() for name, array in engine.state().items()} == before


def test_a_trial_step_needs_no_room_on_the_disk(monkeypatch):
    monkeypatch.setattr(snapshot, "IN_MEMORY", 0)
    monkeypatch.setattr(snapshot, "SPILLED", 0)

    def full(**_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(snapshot.tempfile, "TemporaryFile", full)
    sim = bar(v="0.01*x")
    engine = sim.compose().engine
    before = {name: array.tobytes() for name, array in engine.state().items()}
    with snapshot.unchanged(engine):
        engine.step(1e-3)
    assert {name: array.tobytes() for name, array in engine.state().items()} == before
