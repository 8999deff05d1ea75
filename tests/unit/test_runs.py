"""Runs: killed and resumed, interrupted, failed, repeated; what they leave behind and what they refuse to touch."""

import os
import signal
import subprocess
import sys
import textwrap
import time
import warnings

import attrs
import numpy as np
import pytest
from small_scenes import RUBBER, bar, grid, run, simulation

import mpmkit as mpm
from mpmkit._core.running import checkpoint, loop, recorder
from mpmkit._core.running.history import read_history
from mpmkit.boundaries import PrescribedVelocity, TwoPointTraction, Wall
from mpmkit.contacts import FrictionalContact
from mpmkit.discretizations import FEM
from mpmkit.effects import ArtificialViscosity, BodyForce, Gravity
from mpmkit.integrators import APIC, FLIP, MUSL, PIC, USF, USL, XPIC
from mpmkit.materials import LinearElastic, VonMises
from mpmkit.shapes import ContiguousGIMP, Linear, QuadraticBSpline

pytestmark = pytest.mark.usefixtures("plain_python")


@pytest.fixture(autouse=True)
def checkpoint_with_every_frame(monkeypatch):
    """Not once in a second: these runs are shorter."""
    monkeypatch.setattr(recorder, "CHECKPOINT_SECONDS", 0.0)


def recorded(path, *parts, every=0.05, record=None, **more):
    """A bar that is pulled, with a record."""
    parts = parts or (TwoPointTraction("bar", (0.05,), "xmax"), Wall("xmin", condition="no slip"))
    return bar(*parts, mpm.Record(path, every=every, history=3, **(record or {})), n=4, **more)


def same_state(a, b):
    """Bitwise."""
    one, two = a.particles(), b.particles()
    assert one.keys() == two.keys()
    for name in one:
        assert np.array_equal(one[name], two[name]), name
    assert (a.t, a.step_number) == (b.t, b.step_number)


def same_files(a, b):
    """Frames and history, to the bit."""
    one, two = mpm.Results(a), mpm.Results(b)
    assert one.times.tolist() == two.times.tolist()
    for f, g in zip(one.frames, two.frames, strict=True):
        for name in ("x", "v", "stress", "body"):
            assert np.array_equal(f[name], g[name]), name
    assert a.with_suffix(".history.csv").read_text() == b.with_suffix(".history.csv").read_text()


def interrupt_at(monkeypatch, step):
    """Ctrl-C while this step is being computed."""
    before = loop.timestep.next_step

    def counted(engine):
        if engine.step_number == step:
            signal.raise_signal(signal.SIGINT)
        return before(engine)

    monkeypatch.setattr(loop.timestep, "next_step", counted)
    return lambda: monkeypatch.setattr(loop.timestep, "next_step", before)


# --- kill -9 ------------------------------------------------------------------------------------------------------
CHILD = """
    import sys
    from pathlib import Path
    sys.path.insert(0, {folder!r})
    from test_runs import *
    recorder.CHECKPOINT_SECONDS = 0.0
    if sys.argv[1] == "start":
        disks(Path(sys.argv[2])).run(until=UNTIL, quiet=True)
    else:
        sim = mpm.Simulation.from_checkpoint(sys.argv[2])
        print(sim.step_number)
        sim.run(until=UNTIL, quiet=True)
    """
UNTIL = 1.2


def disks(path):
    """Two blocks that collide, of eight particles in all."""
    a = mpm.Body(mpm.Box((0.5, 0.5), (0.75, 0.75)), RUBBER, (0.3, 0.1), name="a")
    b = mpm.Body(mpm.Box((1.0, 0.625), (1.25, 0.875)), VonMises(E=100.0, nu=0.3, rho=1.0, yield_stress=1.0), (-0.3, 0.0), name="b")
    record = mpm.Record(path, every=0.01, fields=("x", "v", "stress"), history=7)
    return simulation(
        grid("plane strain"),
        a,
        b,
        FrictionalContact(friction=0.2),
        Gravity((0.1, -0.2)),
        Wall("all"),
        record,
        shape=Linear(),
        integrator=MUSL(APIC(), dt=2e-3),
    )


def child(*arguments, **more):
    text = textwrap.dedent(CHILD.format(folder=os.path.dirname(__file__)))
    return subprocess.Popen(
        [sys.executable, "-c", text, *map(str, arguments)], env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, text=True, **more
    )


@pytest.mark.physics
@pytest.mark.filterwarnings("ignore:energy is being created")
def test_kill_in_mid_run_and_resume(tmp_path):
    """Killed while it writes, read by VTK while it ran, resumed by another process: the end is bitwise that of a whole run."""
    vtk = pytest.importorskip("vtkmodules.vtkIOHDF")
    path, whole = tmp_path / "killed.vtkhdf", tmp_path / "whole.vtkhdf"
    running = child("start", path)
    try:
        frames = 0
        while frames < 8:
            assert running.poll() is None, "the run has ended too early"
            time.sleep(0.02)
            try:
                frames = len(mpm.Results(path).times)
            except mpm.ResultsError:
                continue
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(path))
        reader.Update()
        assert running.poll() is None
        assert reader.GetNumberOfSteps() >= 8
        assert reader.GetOutputDataObject(0).GetNumberOfPoints() == 8
    finally:
        running.send_signal(signal.SIGKILL)
        running.wait()
    assert not mpm.Results(path).times[-1] >= UNTIL
    assert [f.name for f in tmp_path.iterdir() if f.name.startswith("killed")]
    again = child("resume", tmp_path / "killed.ckpt.h5", stdout=subprocess.PIPE)
    disks(whole).run(until=UNTIL, quiet=True)
    printed, _ = again.communicate()
    assert again.returncode == 0
    assert 30 <= int(printed) < 600  # a frame at step 35 was there, and so the checkpoint of the one before
    same_files(path, whole)
    ends = [checkpoint.load(p.with_suffix(".ckpt.h5")) for p in (path, whole)]
    assert ends[0][1]["t"] == UNTIL
    for name in ends[0][0]:
        assert np.array_equal(ends[0][0][name], ends[1][0][name]), name


@pytest.mark.parametrize(
    ("integrator", "shape", "parts"),
    [
        (MUSL(FLIP()), Linear(), [ArtificialViscosity()]),
        (MUSL(XPIC(3)), QuadraticBSpline(), [Gravity((-0.1,))]),
        (USF(PIC()), ContiguousGIMP(), [BodyForce("0.1*sin(20*t)")]),
        (USL(APIC()), Linear(), [Wall("xmin")]),
        (USF(), Linear(), [Wall("xmin"), Gravity((-0.5,))]),  # which nodes a wall holds is known from the step before
        (MUSL(mass="consistent"), Linear(), [TwoPointTraction("bar", (0.05,), "xmax")]),
        (None, None, [Gravity((-0.1,)), Wall("xmin", condition="no slip")]),
    ],
    ids=str,
)
def test_resume_is_bitwise(tmp_path, integrator, shape, parts):
    """From a checkpoint in the middle, with every kind of integrator, with FEM too."""

    def made(name):
        if integrator is None:
            body = mpm.Body(mpm.Box(0.0, 1.0), LinearElastic(E=1.0, nu=0.0, rho=1.0), "0.1*x", name="bar")
            return simulation(
                mpm.Grid(0.0, 1.5, 0.25, lateral="stress"),
                body,
                *parts,
                mpm.Record(tmp_path / name, every=0.25, history=3),
                discretization=FEM(),
            )
        return recorded(tmp_path / name, *parts, every=0.25, integrator=integrator, shape=shape, v="0.1*x")

    whole = made("whole.vtkhdf")
    whole.run(until=1.0, quiet=True)
    half = made("half.vtkhdf")
    half.run(until=0.5, quiet=True)
    os.replace(tmp_path / "half.ckpt.h5", tmp_path / "kept.ckpt.h5")
    half.run(until=0.75, quiet=True)  # goes on, so that the files are ahead of the checkpoint
    other = made("half.vtkhdf").resume(tmp_path / "kept.ckpt.h5")
    assert other.t == 0.5 and 0 < other.step_number < whole.step_number
    other.run(until=1.0, quiet=True)
    same_state(whole, other)
    same_files(tmp_path / "whole.vtkhdf", tmp_path / "half.vtkhdf")
    for name, column in whole.history.items():
        assert np.array_equal(column, other.history[name]), name


# --- run in parts -------------------------------------------------------------------------------------------------
def test_two_runs_are_one(tmp_path):
    """Bitwise, where the times of landing are the same; also in the files."""
    once, twice = recorded(tmp_path / "once.vtkhdf", every=0.0625), recorded(tmp_path / "twice.vtkhdf", every=0.0625)
    once.run(until=0.5, quiet=True)
    for until in (0.125, 0.3125, 0.5):
        twice.run(until=until, quiet=True)
    same_state(once, twice)
    same_files(tmp_path / "once.vtkhdf", tmp_path / "twice.vtkhdf")
    before = twice.step_number
    assert twice.run(until=0.4, quiet=True) is not None  # a time that is past: nothing happens
    assert twice.step_number == before and twice.t == 0.5


def test_two_runs_without_a_record():
    sim = bar(v=0.01)
    first, second = sim.run(until=0.5, quiet=True), sim.run(until=1.0, quiet=True)
    assert first.times.tolist() == [0.0, 0.5] and second.times.tolist() == [0.0, 0.5, 1.0]
    assert np.array_equal(second.history["step"], sim.history["step"])
    assert np.abs(second.at(1.0)["x"] - second.at(0.0)["x"] - 0.01).max() < 1e-12


# --- what is recorded ---------------------------------------------------------------------------------------------
def test_frames_lie_on_their_times(tmp_path):
    """Exactly k times the interval, whatever the time step, and the end; two records with intervals of their own."""
    sim = bar(
        mpm.Record(tmp_path / "a.vtkhdf", every=0.07),
        mpm.Record(tmp_path / "b.vtkhdf", every=0.11, fields=("x",)),
        v="0.01*x",
        integrator=MUSL(cfl=0.37),
    )
    sim.run(until=0.5, quiet=True)
    assert mpm.Results(tmp_path / "a.vtkhdf").times.tolist() == [0.0, *(k * 0.07 for k in range(1, 8)), 0.5]
    assert mpm.Results(tmp_path / "b.vtkhdf").times.tolist() == [0.0, *(k * 0.11 for k in range(1, 5)), 0.5]
    assert sim.history["dt"][1:].max() <= 0.37 * 0.125 * (1.0 + 1e-9)


def test_frames_hold_what_the_simulation_holds(tmp_path):
    """Single precision in the file: 1e-7 of each value."""
    sim = recorded(tmp_path / "run.vtkhdf", record={"fields": ("x", "v", "stress", "F", "J", "V")}, integrator=MUSL(APIC()))
    results = sim.run(until=0.5, quiet=True)
    last, p = results.frames[-1], sim.particles("bar")
    for name in ("x", "v", "stress", "J", "V"):
        wanted = p[name] if p[name].ndim == 1 or name == "stress" else p[name][:, 0]
        found = last[name] if last[name].ndim == 1 or name == "stress" else last[name][:, 0]
        assert np.abs(found - wanted).max() <= 1e-7 * np.abs(wanted).max(), name
    assert (last["body"] == 0).all()


def test_history_file_is_the_history(tmp_path):
    sim = recorded(tmp_path / "run.vtkhdf")
    results = sim.run(until=0.5, quiet=True)
    rows = read_history(tmp_path / "run.history.csv")
    assert rows.keys() == sim.history.keys() == set(results.history) | rows.keys()
    for name, column in sim.history.items():
        assert np.array_equal(rows[name], column), name  # repr of a float keeps all its bits
    assert rows["step"][0] == 0 and rows["step"][-1] == sim.step_number and rows["t"][-1] == 0.5
    assert (np.diff(rows["step"]) > 0).all()
    assert set(range(0, sim.step_number, 3)) <= set(rows["step"].tolist())


def test_record_without_frames_or_checkpoint(tmp_path):
    sim = recorded(tmp_path / "run.vtkhdf", every=None, record={"checkpoint": False})
    results = sim.run(until=0.3, quiet=True)
    assert results.times.tolist() == [0.0, 0.3]
    assert sorted(f.name for f in tmp_path.iterdir()) == ["run.history.csv", "run.vtkhdf"]


def test_a_finished_run_leaves_a_checkpoint_of_its_end(tmp_path, monkeypatch):
    monkeypatch.setattr(recorder, "CHECKPOINT_SECONDS", 1e9)
    sim = recorded(tmp_path / "run.vtkhdf", every=0.0625)
    sim.run(until=0.25, quiet=True)
    other = mpm.Simulation.from_checkpoint(tmp_path / "run.ckpt.h5")
    same_state(sim, other)
    sim.run(until=0.375, quiet=True)
    other = mpm.Simulation.from_checkpoint(tmp_path / "run.ckpt.h5")
    other.run(until=0.5, quiet=True)
    sim = recorded(tmp_path / "whole.vtkhdf", every=0.0625)
    sim.run(until=0.5, quiet=True)
    same_state(sim, other)


# --- Ctrl-C -------------------------------------------------------------------------------------------------------
def test_interrupt_leaves_a_checkpoint_and_says_where(tmp_path, monkeypatch):
    sim = recorded(tmp_path / "run.vtkhdf", every=0.2)
    undo = interrupt_at(monkeypatch, 7)
    handler = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt, match=r"last good state: step 8, t = .*run\.ckpt\.h5"):
        sim.run(until=1.0, quiet=True)
    assert signal.getsignal(signal.SIGINT) is handler
    undo()
    other = mpm.Simulation.from_checkpoint(tmp_path / "run.ckpt.h5")
    assert other.step_number == 8
    other.run(until=1.0, quiet=True)
    whole = recorded(tmp_path / "whole.vtkhdf", every=0.2)
    whole.run(until=1.0, quiet=True)
    same_state(whole, other)
    same_files(tmp_path / "whole.vtkhdf", tmp_path / "run.vtkhdf")


def test_interrupted_simulation_goes_on(monkeypatch):
    """Without a record the state stays in the simulation."""
    sim, whole = bar(v="0.01*x"), bar(v="0.01*x")
    undo = interrupt_at(monkeypatch, 5)
    with pytest.raises(KeyboardInterrupt, match=r"last good state: step 6, .*kept in this simulation"):
        sim.run(until=1.0, quiet=True)
    undo()
    assert sim.step_number == 6
    sim.run(until=1.0, quiet=True)
    whole.run(until=1.0, quiet=True)
    same_state(sim, whole)


# --- failing runs -------------------------------------------------------------------------------------------------
@mpm.kernel
def breaking_stress(F, limit):
    """Not a number beyond a stretch."""
    if F[0] > limit:
        return (float("nan"), 0.0, 0.0, 0.0, 0.0, 0.0)
    return (F[0] - 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@mpm.kernel
def breaking_speed(F, limit, faster):
    """Jumps beyond a stretch."""
    if F[0] > limit:
        return faster
    return 1.0


@mpm.define
class Breaking(mpm.ConstitutiveModel):
    """A law that breaks down beyond a stretch."""

    rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1.0)
    limit: float = mpm.parameter("stretch", default=1.02)
    faster: float = mpm.parameter("wave speed beyond it", unit="m/s", default=1.0)
    stress = breaking_stress
    wave_speed = breaking_speed
    bar_stress = breaking_stress
    bar_wave_speed = breaking_speed


def stretched(*parts, law=None, **more):
    body = mpm.Body(mpm.Box(0.5, 1.0), law or Breaking(rho=1.0), "0.4*(x - 0.75)", name="rod", particles_per_cell=2)
    return simulation(mpm.Grid(0.0, 2.0, 0.25, lateral="stress"), body, *parts, shape=Linear(), **more)


def failing(sim, *fragments, until=2.0):
    """The run fails with a message that says who, where, when, what and what to do; returns the message."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="energy is being created")
        warnings.filterwarnings("ignore", category=RuntimeWarning)  # of numpy, when plain Python meets a NaN
        with pytest.raises(mpm.StabilityError) as caught:
            sim.run(until=until, quiet=True)
    for fragment in fragments:
        assert fragment in str(caught.value), str(caught.value)
    return str(caught.value)


def test_particle_leaves_the_domain(tmp_path):
    body = mpm.Body(mpm.Box((0.5, 0.5), (0.75, 0.75)), RUBBER, (3.0, 0.0), name="bullet")
    sim = simulation(grid("plane strain"), body, mpm.Record(tmp_path / "run.vtkhdf", every=0.1))
    message = failing(
        sim,
        "particle ",
        "body 'bullet' (NeoHookean)",
        "it left the domain: x = (2.",
        "at step ",
        "t = 0.4",
        "Wall or Symmetry",
        "last good state: step ",
    )
    assert str(tmp_path / "run.ckpt.h5") in message
    good = checkpoint.load(tmp_path / "run.ckpt.h5")[1]
    assert 0 <= good["step"] < int(message.split("at step ")[1].split(",")[0])
    assert len(mpm.Results(tmp_path / "run.vtkhdf").times) == 5  # 0 to 0.4
    assert sim.step_number == good["step"] and sim.particles()["x"].max() < 2.0


def test_not_a_number(tmp_path):
    message = failing(
        stretched(mpm.Record(tmp_path / "run.vtkhdf", every=0.05), integrator=MUSL(dt=0.02)),
        "body 'rod' (Breaking)",
        "NaN",
        "at step ",
        "a smaller dt (now 0.02 s)",
        "not repeated: dt is fixed",
    )
    assert "particle " in message and "run.ckpt.h5" in message
    arrays, _ = checkpoint.load(tmp_path / "run.ckpt.h5")
    assert all(np.isfinite(a).all() for n, a in arrays.items() if n.startswith("P/"))


def test_wave_speed_that_is_not_a_number():
    failing(stretched(law=Breaking(rho=1.0, faster=1.0, limit=1.0), integrator=MUSL(dt=0.02)), "NaN")
    failing(
        stretched(law=Breaking(rho=1.0, faster=float("inf")), integrator=MUSL(dt=0.02)),
        "body 'rod' (Breaking)",
        "the wave speed, or the speed of a particle, is infinite or not a number",
    )


def test_inversion():
    """Nodes that close in by more than a cell in a step, with the first-order update: F < 0."""
    squeeze = PrescribedVelocity("-3*(x - 0.75)", region=mpm.Box((-9.0,), (9.0,)))
    sim = stretched(squeeze, law=LinearElastic(E=1e-4, nu=0.0, rho=1.0), integrator=MUSL(PIC(), dt=0.4, strain="first-order"))
    failing(sim, "particle ", "body 'rod' (LinearElastic)", "inverted, J = -0.2", "at step 1,", "t = 0.4 s", "last good state: step 0")
    assert sim.step_number == 0 and (sim.particles()["J"] == 1.0).all()


def test_time_step_collapse():
    failing(
        stretched(law=Breaking(rho=1.0, faster=1e9)), "time step collapsed to", "first one", "body 'rod'", "lower cfl, or refine the grid"
    )


@mpm.kernel
def pumping_stress(F):
    """Pulls the more the shorter it is, and pushes the longer."""
    return (-4.0 * (F[0] - 1.0), 0.0, 0.0, 0.0, 0.0, 0.0)


@mpm.kernel
def unit_speed():
    return 1.0


@mpm.kernel
def no_energy():
    return 0.0


@mpm.define
class Pump(mpm.ConstitutiveModel):
    """Creates energy."""

    rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1.0)
    stress = bar_stress = pumping_stress
    wave_speed = bar_wave_speed = unit_speed
    energy = bar_energy = no_energy


def test_created_energy_is_warned_of_and_then_stopped():
    """After the hundred steps in which a sudden load may show as much."""
    sim = stretched(law=Pump(rho=1.0), integrator=MUSL(dt=5e-4))
    with pytest.warns(UserWarning, match=r"energy is being created: balance \+\d+.*at step 100, .*a smaller dt"):
        sim.run(until=0.07, quiet=True)
    assert 0.05 < sim.history["balance"][-1] < 0.5
    failing(sim, "energy was created: 0.5", "at step ", "fastest is particle 0 of body 'rod'", "a smaller dt", "last good state: step ")


def test_failed_simulation_says_so_without_a_record():
    sim = stretched(integrator=MUSL(dt=0.02))
    failing(sim, "kept in this simulation (no Record was added)")
    assert np.isfinite(sim.particles()["x"]).all()


# --- files that must not be touched -------------------------------------------------------------------------------
@pytest.mark.parametrize("suffix", [".vtkhdf", ".history.csv", ".ckpt.h5"])
def test_existing_files_are_not_overwritten_unasked(tmp_path, suffix):
    """Refused before anything is compiled, the file as it was; replaced when that is asked for."""
    old = (tmp_path / "run.vtkhdf").with_suffix(suffix)
    old.write_text("precious")
    sim = recorded(tmp_path / "run.vtkhdf")
    with pytest.raises(mpm.ResultsError, match="exists.*never overwritten unasked.*overwrite=True"):
        sim.run(until=0.1, quiet=True)
    assert sim.compose()._engine is None
    assert old.read_text() == "precious" and [f.name for f in tmp_path.iterdir()] == [old.name]
    recorded(tmp_path / "run.vtkhdf", record={"overwrite": True}).run(until=0.1, quiet=True)
    assert len(mpm.Results(tmp_path / "run.vtkhdf").times) == 3


def test_overwriting_waits_until_there_is_something_to_write(tmp_path):
    """A scene that is refused does not cost the old results."""
    recorded(tmp_path / "run.vtkhdf").run(until=0.1, quiet=True)
    sim = recorded(tmp_path / "run.vtkhdf", record={"overwrite": True}, integrator=MUSL(dt=10.0))
    with pytest.raises(mpm.StabilityError):
        sim.run(until=0.1, quiet=True)
    assert len(mpm.Results(tmp_path / "run.vtkhdf").times) >= 1


def test_output_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    for path in (tmp_path / "file" / "run.vtkhdf", tmp_path / "file" / "deep" / "run.vtkhdf"):
        sim = recorded(path)
        with pytest.raises(mpm.ResultsError, match="cannot"):
            sim.run(until=0.1, quiet=True)
        assert sim.compose()._engine is None
    (tmp_path / "folder.vtkhdf").mkdir()
    with pytest.raises(mpm.ResultsError, match="this is a folder"):
        recorded(tmp_path / "folder.vtkhdf", record={"overwrite": True}).run(until=0.1, quiet=True)


def test_folders_are_made(tmp_path):
    recorded(tmp_path / "a" / "b" / "run.vtkhdf").run(until=0.05, quiet=True)
    assert (tmp_path / "a" / "b" / "run.vtkhdf").exists()


# --- files that are not what they should be -----------------------------------------------------------------------
@pytest.fixture
def finished(tmp_path):
    """A run that has ended at 0.2, for its files."""
    recorded(tmp_path / "run.vtkhdf").run(until=0.2, quiet=True)
    return tmp_path / "run.vtkhdf"


def test_results_that_are_none(tmp_path, finished):
    foreign = tmp_path / "foreign.vtkhdf"
    foreign.write_text("VTK")
    short = tmp_path / "short.vtkhdf"
    short.write_bytes(finished.read_bytes()[:2000])
    for path in (foreign, short, tmp_path / "nothing.vtkhdf"):
        with pytest.raises(mpm.ResultsError, match=path.name):
            mpm.Results(path).frames  # noqa: B018


def test_checkpoints_that_are_none(tmp_path, finished):
    good = finished.with_suffix(".ckpt.h5")
    foreign, short, flipped = (tmp_path / f"{name}.ckpt.h5" for name in ("foreign", "short", "flipped"))
    foreign.write_text("x" * 4000)
    short.write_bytes(good.read_bytes()[:-100])
    data = bytearray(good.read_bytes())
    data[len(data) // 2] ^= 1
    flipped.write_bytes(data)
    for path, what in (
        (foreign, "is not a checkpoint"),
        (short, "truncated"),
        (flipped, "damaged"),
        (tmp_path / "none.ckpt.h5", "no such checkpoint"),
    ):
        sim = recorded(finished)
        with pytest.raises(mpm.ResultsError, match=what):
            sim.resume(path)
        with pytest.raises(mpm.ResultsError, match=what):
            mpm.Simulation.from_checkpoint(path)


OTHERS = {
    "material": {"E": 2.0},
    "kernels": {"integrator": USF()},
    "courant number": {"integrator": MUSL(cfl=0.3)},
    "domain": {"room": 1.0},
}


@pytest.mark.parametrize("name", OTHERS)
def test_checkpoint_of_another_composition(finished, name):
    with pytest.raises(mpm.ResultsError, match=r"checkpoint of another composition \(.+ differ\)"):
        recorded(finished, **OTHERS[name]).resume(finished.with_suffix(".ckpt.h5"))


@pytest.mark.parametrize(
    "parts",
    [
        (TwoPointTraction("bar", (0.06,), "xmax"), Wall("xmin", condition="no slip")),
        (TwoPointTraction("bar", (0.05,), "xmin"), Wall("xmin", condition="no slip")),
        (TwoPointTraction("bar", (0.05,), "xmax"), Wall("xmax", condition="no slip")),
        (TwoPointTraction("bar", (0.05,), "xmax"), Wall("xmin", condition="no slip"), Gravity((0.1,))),
    ],
)
def test_checkpoint_of_other_conditions(finished, parts):
    """Another traction, another face: numbers that the text of the step does not show."""
    with pytest.raises(mpm.ResultsError, match="checkpoint of another composition"):
        recorded(finished, *parts).resume(finished.with_suffix(".ckpt.h5"))


def test_checkpoint_with_other_gravity(tmp_path):
    path = tmp_path / "run.vtkhdf"
    recorded(path, Gravity((0.1,))).run(until=0.2, quiet=True)
    with pytest.raises(mpm.ResultsError, match="components differ"):
        recorded(path, Gravity((0.2,))).resume(path.with_suffix(".ckpt.h5"))
    recorded(path, Gravity((0.1,))).resume(path.with_suffix(".ckpt.h5"))


def test_checkpoint_with_other_records(finished):
    with pytest.raises(mpm.ResultsError, match=r"had 1 Record\(s\), this simulation has 0"):
        bar(TwoPointTraction("bar", (0.05,), "xmax"), Wall("xmin", condition="no slip"), n=4).resume(finished.with_suffix(".ckpt.h5"))


def test_checkpoint_of_another_version(finished):
    path = finished.with_suffix(".ckpt.h5")
    arrays, attributes = checkpoint.load(path)
    checkpoint.save(path, arrays, attributes | {"mpmkit": "99.0"})
    with pytest.raises(mpm.ResultsError, match=r"written by mpmkit 99\.0, this is .*resume with the version that wrote it"):
        recorded(finished).resume(path)


def test_resume_with_missing_results(finished):
    finished.unlink()
    with pytest.raises(mpm.ResultsError, match=r"run\.vtkhdf"):
        recorded(finished).resume(finished.with_suffix(".ckpt.h5"))


def test_resume_of_a_scene_with_functions(tmp_path):
    """A file cannot hold them: it says what to do, and that works."""

    def pull(t):
        return (0.05 * t,)

    def made(name):
        return recorded(tmp_path / name, TwoPointTraction("bar", pull, "xmax"), every=0.1)

    whole = made("whole.vtkhdf")
    whole.run(until=0.4, quiet=True)
    made("run.vtkhdf").run(until=0.2, quiet=True)
    with pytest.raises(mpm.ResultsError, match=r"compose it in the script again and call sim\.resume\('.*run\.ckpt\.h5'\)"):
        mpm.Simulation.from_checkpoint(tmp_path / "run.ckpt.h5")
    other = made("run.vtkhdf").resume(tmp_path / "run.ckpt.h5")
    other.run(until=0.4, quiet=True)
    same_state(whole, other)

    def push(t):
        return (-0.05 * t,)

    with pytest.raises(mpm.ResultsError, match="kernels"):
        recorded(tmp_path / "run.vtkhdf", TwoPointTraction("bar", push, "xmax"), every=0.1).resume(tmp_path / "run.ckpt.h5")


def test_components_are_told_apart_without_addresses():
    def pull(t):
        return (0.05 * t,)

    load = TwoPointTraction("bar", pull, "xmax")
    assert "0x" not in loop._told(load) and "pull" in loop._told(load)
    assert loop._told(load) != loop._told(attrs.evolve(load, face="xmin"))
    assert loop._told(MUSL(XPIC(3))) != loop._told(MUSL(XPIC(2)))


# --- progress -----------------------------------------------------------------------------------------------------
def test_summary_names_the_files(tmp_path, capsys):
    sim = recorded(tmp_path / "run.vtkhdf")
    sim.run(until=0.2)
    text = capsys.readouterr().err
    for name in ("run.vtkhdf", "run.history.csv", "run.ckpt.h5"):
        assert str(tmp_path / name) in text
    assert "finished at t = 0.2 s" in text and "energy balance" in text and "momentum error" in text
    assert run(bar(v=0.1), 0.2).step_number > 0
    assert capsys.readouterr().err == ""
