"""Checkpoints: back to the bit, whole or not there, and never a damaged one accepted."""

import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from mpmkit._core.running.checkpoint import load, previous, remove_stale, save
from mpmkit.errors import ResultsError

ARRAYS = {
    "bodies/left/x": np.random.default_rng(0).standard_normal((50, 3)),
    "bodies/left/F": np.float32([1.0, np.nan, -0.0, np.inf, 1e-45]),
    "bodies/right/id": np.arange(7, dtype=np.int32),
    "wide": np.array([2**63 - 1, -(2**63)]),
    "flags": np.array([True, False]),
    "packed": np.array([(1.5, 3)], dtype=[("x", "f8"), ("cell", "i4")]),
    "empty": np.empty((0, 3)),
    "one": np.float64(0.1),
}
ATTRS = {
    "t": 0.1 + 0.2,
    "step": np.int64(7),
    "scene": "Kügelchen = 1\n",
    "nothing": None,
    "inf": float("inf"),
    "nested": {"dt": [1e-300, np.float64(0.1)]},
}


def _saved(tmp_path, times=1):
    path = tmp_path / "run.ckpt.h5"
    for _ in range(times):
        save(path, ARRAYS, ATTRS)
    return path


def test_everything_comes_back_to_the_bit(tmp_path):
    arrays, attrs = load(_saved(tmp_path))
    assert set(arrays) == set(ARRAYS)
    for name, array in ARRAYS.items():
        assert (arrays[name].dtype, np.shape(arrays[name])) == (np.asarray(array).dtype, np.shape(array))
        assert np.asarray(arrays[name]).tobytes() == np.asarray(array).tobytes(), name
    assert attrs == {**ATTRS, "step": 7}
    assert np.float64(attrs["t"]).tobytes() == np.float64(0.1 + 0.2).tobytes()


def test_no_bit_can_flip_unnoticed(tmp_path):
    path = _saved(tmp_path)
    good = path.read_bytes()
    rng = random.Random(3)
    # every part: header, HDF5's own tables, data
    places = [*range(200), 511, *(rng.randrange(len(good)) for _ in range(300)), len(good) - 1]
    for place in places:
        bad = bytearray(good)
        bad[place] ^= 1 << rng.randrange(8)
        path.write_bytes(bad)
        with pytest.raises(ResultsError):
            load(path)
    path.write_bytes(good)
    load(path)


def test_damage_is_named_with_a_way_out(tmp_path):
    path = _saved(tmp_path, times=2)
    good = path.read_bytes()
    spare = str(previous(path))
    path.write_bytes(good[:3000])
    with pytest.raises(ResultsError, match=rf"is truncated: 2488 of {len(good) - 512} bytes(.|\n)*is whole: resume from {spare}"):
        load(path)
    path.write_bytes(b"hello")
    with pytest.raises(ResultsError, match="is not a checkpoint of mpmkit"):
        load(path)
    path.write_bytes(good.replace(b"format 3", b"format 9", 1))
    with pytest.raises(ResultsError, match="in checkpoint format 9, this mpmkit reads format 3"):
        load(path)
    previous(path).unlink()
    path.write_bytes(good[:-1])
    with pytest.raises(ResultsError) as caught:
        load(path)
    assert "resume from" not in str(caught.value), "a spare that is not there must not be offered"
    with pytest.raises(ResultsError, match="no such checkpoint"):
        load(tmp_path / "none.ckpt.h5")


def test_the_one_before_is_kept(tmp_path):
    path = tmp_path / "run.ckpt.h5"
    for k in range(3):
        save(path, {"k": np.array(k)}, {"k": k})
    assert (load(path)[1]["k"], load(previous(path))[1]["k"]) == (2, 1)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.ckpt.h5", "run.ckpt.h5.1"]


def test_a_failed_save_keeps_the_last_one_and_leaves_nothing_behind(tmp_path):
    path = _saved(tmp_path)
    with pytest.raises(ResultsError, match=r"cannot write the checkpoint .*; the checkpoint before it is kept"):
        save(path, {"x": np.array([object()])}, {})
    with pytest.raises(ResultsError, match="cannot write the checkpoint"):
        save(path, {}, {"x": object()})
    assert [p.name for p in tmp_path.iterdir()] == ["run.ckpt.h5"]
    load(path)
    with pytest.raises(ResultsError, match="cannot write the checkpoint"):
        save(tmp_path / "none" / "run.ckpt.h5", {}, {})


_WRITER = """
import sys, numpy as np
from mpmkit._core.running.checkpoint import save
k = 0
while True:
    save(sys.argv[1], {"x": np.full((20000, 3), k, dtype=float)}, {"k": k})
    k += 1
    print(k, flush=True)
"""


def test_killed_at_any_moment_the_last_one_is_whole(tmp_path):
    path, rng = tmp_path / "run.ckpt.h5", random.Random(5)
    for _ in range(4):
        with (tmp_path / "log").open("w+") as log:
            writer = subprocess.Popen([sys.executable, "-c", _WRITER, str(path)], stdout=log)
            end = time.monotonic() + 20
            while os.path.getsize(tmp_path / "log") == 0 and time.monotonic() < end:
                time.sleep(0.005)
            time.sleep(rng.uniform(0, 0.15))
            writer.send_signal(signal.SIGKILL)
            writer.wait()
            log.seek(0)
            acknowledged = int(log.read().split("\n")[-2])
        arrays, attrs = load(path)
        assert attrs["k"] >= acknowledged - 1
        assert (arrays["x"] == attrs["k"]).all()
        remove_stale(path)
        assert not list(tmp_path.glob("*.tmp")) and not list(tmp_path.glob(".*.tmp"))


def test_stale_temporary_files_of_other_runs_stay(tmp_path):
    for name in (".run.ckpt.h5.abc.tmp", ".other.ckpt.h5.abc.tmp"):
        (tmp_path / name).touch()
    assert [p.name for p in remove_stale(tmp_path / "run.ckpt.h5")] == [".run.ckpt.h5.abc.tmp"]
    assert [p.name for p in tmp_path.iterdir()] == [".other.ckpt.h5.abc.tmp"]


_FULL = """
import resource, signal, sys, numpy as np
import mpmkit._core.running.checkpoint as checkpoint
if sys.argv[2] == "unnoticed":
    checkpoint.reserve = lambda file, n_bytes: None
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000))
for n in (1000, 1_000_000):
    checkpoint.save(sys.argv[1], {"x": np.full(n, n)}, {"n": n})
"""


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="needs a limit on the size of files")
@pytest.mark.parametrize("full", ["noticed", "unnoticed"])
def test_a_full_disk_keeps_the_last_one(tmp_path, full):
    path = tmp_path / "run.ckpt.h5"
    done = subprocess.run([sys.executable, "-c", _FULL, str(path), full], check=False, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1, done.stderr
    assert "cannot write the checkpoint" in done.stderr and "the checkpoint before it is kept" in done.stderr
    assert load(path)[1] == {"n": 1000}
    assert [p.name for p in tmp_path.iterdir()] == ["run.ckpt.h5"]
