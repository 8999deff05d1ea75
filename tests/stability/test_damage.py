"""Files that were damaged, disks that are full, paths that cannot be: the very same numbers or a ResultsError, never a crash or a wrong number.

More damage, read by a process of its own: ``python tests/stability/fuzz.py damage --count 3000``.
"""

import os
import random
import shutil
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest
from damaged_files import DAMAGES, contents, continued, judge, rows, state
from killed_run import scene

import mpmkit as mpm

READERS = {".vtkhdf": (contents, continued), ".ckpt.h5": (state,), ".history.csv": (rows,)}


@pytest.fixture(autouse=True)
def plain_python(monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """The files of a short run."""
    path = tmp_path_factory.mktemp("good") / "run.vtkhdf"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NUMBA_DISABLE_JIT", "1")
        mpm.scene.loads(scene(path)).run(until=0.05, quiet=True)
    return path


@pytest.mark.parametrize("suffix", READERS)
def test_damaged_files(suffix, good, tmp_path):
    raw = good.with_suffix(suffix).read_bytes()
    for read in READERS[suffix]:
        wanted = read(good.with_suffix(suffix))
        for number in range(25):
            rng = random.Random(f"{suffix}{number}")
            change = rng.choice(DAMAGES)
            bad = (tmp_path / f"bad{number}.vtkhdf").with_suffix(suffix)
            bad.write_bytes(change(raw, rng))
            outcome, text = judge(read, bad, wanted)
            assert outcome != "fault", f"{change.__name__} {number}, {read.__name__}: {text}"


def test_every_number_of_a_frame_is_watched(good, tmp_path):
    """A single bit of each array in turn, changed through HDF5 itself, so that the file is whole and only the number is wrong."""
    import h5py

    names = ["VTKHDF/Points", "VTKHDF/Steps/Values", "VTKHDF/FieldData/step", "VTKHDF/FieldData/kinetic", "VTKHDF/Steps/PointOffsets"]
    names += [f"VTKHDF/PointData/{name}" for name in ("v", "stress", "body", "id", "size")]
    for name in names:
        bad = tmp_path / "bad.vtkhdf"
        shutil.copyfile(good, bad)
        with h5py.File(bad, "r+", locking=False) as file:
            rows = file[name][:]
            rows.view(np.uint8).reshape(-1)[-5 if rows.dtype.itemsize > 4 else -1] ^= 1
            file[name][:] = rows
        with pytest.raises(mpm.ResultsError, match="does not fit its checksum"):
            contents(bad)


def test_scene_and_facts_are_watched(good, tmp_path):
    raw = good.read_bytes()
    for text in (b"NeoHookean", b'"plane strain"', b'"fields"'):
        at = raw.index(text)
        bad = tmp_path / "bad.vtkhdf"
        bad.write_bytes(raw[: at + 3] + bytes([raw[at + 3] ^ 1]) + raw[at + 4 :])
        with pytest.raises(mpm.ResultsError, match="does not fit its checksum"):
            contents(bad)


# --- a full disk ----------------------------------------------------------------------------------------------------
FULL = """
import resource, signal, sys, warnings
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
import mpmkit as mpm
from mpmkit._core.running import recorder
recorder.CHECKPOINT_SECONDS = 0.0
text = open(sys.argv[1]).read()
for k, limit in enumerate(map(int, sys.argv[2:])):
    sim = mpm.scene.loads(text.replace("run.vtkhdf", f"run{k}.vtkhdf"))
    sim.compose()
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    try:
        sim.run(until=0.05, quiet=True)
        text_of = "whole"
    except mpm.ResultsError as error:
        text_of = str(error).replace(chr(10), " | ")
    resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    print(k, text_of, flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no limit of the size of files")
def test_full_disk(good, tmp_path):
    """Files may grow to a limit that lies somewhere between nothing and what the run needs; frames before it are readable."""
    import subprocess

    rng = random.Random(1)
    sizes = [good.with_suffix(s).stat().st_size for s in (".vtkhdf", ".ckpt.h5")]
    limits = [600, 20_000, *sorted(rng.randrange(max(sizes) + (1 << 18)) for _ in range(5)), 1 << 30]
    (tmp_path / "scene.toml").write_text(scene(tmp_path / "run.vtkhdf"))
    command = [sys.executable, "-W", "ignore", "-c", FULL, str(tmp_path / "scene.toml"), *map(str, limits)]
    done = subprocess.run(command, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) == len(limits) and lines[-1].endswith("whole")
    all_frames = mpm.Results(good).times.tolist()
    for k, line in enumerate(lines):
        path = tmp_path / f"run{k}.vtkhdf"
        assert line.endswith("whole") or ("cannot write" in line and f"run{k}." in line and "File too large" in line), line
        try:
            found = contents(path)["times"]
        except mpm.ResultsError:
            found = []
        assert found == all_frames[: len(found)], line
        if "frame" in line.split("|")[0]:
            assert f"the {len(found)} frames before it are kept" in line
    assert any(not line.endswith("whole") for line in lines)


# --- paths ----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("a" * 300 + ".vtkhdf", "File name too long"),
        ("x" * 5000 + "/run.vtkhdf", "File name too long"),
        ("file/run.vtkhdf", "cannot make the folder"),
        ("folder.vtkhdf", "this is a folder"),
        ("beside/run.vtkhdf", "this is a folder"),
        ("/proc/run.vtkhdf", "/proc"),
        ("locked/run.vtkhdf", "cannot be written"),
    ],
)
@pytest.mark.parametrize("overwrite", [False, True])
def test_paths_that_cannot_be_written(name, says, overwrite, tmp_path, monkeypatch):
    """Refused before the first step, also where the folder lies in the place of the checkpoint."""
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("")
    Path("folder.vtkhdf").mkdir()
    Path("beside/run.ckpt.h5").mkdir(parents=True)
    Path("locked").mkdir(mode=0o500)
    if name.startswith("/proc") and not Path("/proc").is_dir():
        pytest.skip("no such folder on this system")
    if name.startswith("locked") and os.access("locked", os.W_OK):
        pytest.skip("this user may write to folders that are locked")
    sim = mpm.scene.loads(scene(Path("run.vtkhdf")))
    sim.records[:] = [mpm.Record(name, overwrite=overwrite)]
    with pytest.raises(mpm.ResultsError, match=says):
        sim.run(until=0.05, quiet=True)
    assert sim.step_number == 0


@pytest.mark.parametrize("name", ["a\0b.vtkhdf", "\udcff.vtkhdf"])
def test_names_that_no_file_can_have(name):
    with pytest.raises(mpm.ParameterError, match=r"Record\.path must be text that a file can be called"):
        mpm.Record(name)


@pytest.mark.skipif(sys.platform == "win32", reason="open files cannot be removed")
@pytest.mark.parametrize("what", ["the result file", "the history", "the folder"])
def test_files_removed_while_the_run_goes_on(what, tmp_path):
    folder = tmp_path / "out"
    sim = mpm.scene.loads(scene(folder / "run.vtkhdf"))
    sim.run(until=0.02, quiet=True)
    {
        "the result file": lambda: (folder / "run.vtkhdf").unlink(),
        "the history": lambda: (folder / "run.history.csv").unlink(),
        "the folder": lambda: shutil.rmtree(folder),
    }[what]()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(mpm.ResultsError, match=r"run\."):
            sim.run(until=0.05, quiet=True).history  # noqa: B018  the first thing that needs what is gone
    assert np.isfinite(sim.particles("a")["x"]).all()
