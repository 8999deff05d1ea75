"""Runs as nobody plans them: stopped after every step, in other processes, with files moved. All bitwise."""

import hashlib
import os
import shutil
import subprocess
import sys
import warnings

import numpy as np
import pytest
from killed_run import scene

import mpmkit as mpm
from mpmkit._core.running import recorder


@pytest.fixture(autouse=True)
def plain_python(monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    monkeypatch.setattr(recorder, "CHECKPOINT_SECONDS", 0.0)


def bits(sim):
    """A digest of all that can be asked of a simulation."""
    digest = hashlib.sha256()
    for body in sim.bodies:
        for name, array in sorted(sim.particles(body).items()):
            digest.update(name.encode() + np.ascontiguousarray(array).tobytes())
    for name, column in sim.history.items():
        digest.update(name.encode() + np.ascontiguousarray(column).tobytes())
    return digest.hexdigest()


def run(sim, until):
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="energy is being created")
        sim.run(until=until, quiet=True)
    return sim


def test_a_new_process_after_every_step(tmp_path):
    """As if: each step by a simulation of its own, rebuilt from the checkpoint of the one before."""
    stops = [0.005 * k for k in range(1, 13)]
    whole = mpm.scene.loads(scene(tmp_path / "whole.vtkhdf"))
    parts = mpm.scene.loads(scene(tmp_path / "parts.vtkhdf"))
    for stop in stops:
        run(whole, stop)
        run(parts, stop)
        parts = mpm.Simulation.from_checkpoint(tmp_path / "parts.ckpt.h5")
        assert parts.step_number == whole.step_number
    assert bits(parts) == bits(whole)
    text = [(tmp_path / f"{name}.history.csv").read_text() for name in ("whole", "parts")]
    assert text[0] == text[1]
    assert mpm.Results(tmp_path / "whole.vtkhdf").times.tolist() == mpm.Results(tmp_path / "parts.vtkhdf").times.tolist()


CHILD = """
import sys, warnings
sys.path.insert(0, sys.argv[1])
warnings.simplefilter("ignore")
import mpmkit as mpm
from test_odd_runs import bits
sim = mpm.scene.loads(open(sys.argv[2], encoding="utf-8").read())
sim.run(quiet=True)
print(bits(sim))
"""


def test_other_processes_find_the_same_bits(tmp_path):
    """Whatever the seed of Python's hashes, the folder and the language of the machine."""
    text = scene(tmp_path / "run.vtkhdf").replace("until = 0.25", "until = 0.05")
    file = tmp_path / "scene.toml"
    file.write_text(text.split("[[records]]")[0])
    wanted = bits(run(mpm.load(file), 0.05))
    for seed, language in (("1", "C"), ("4294967295", "tr_TR.UTF-8")):
        environment = os.environ | {"PYTHONHASHSEED": seed, "LC_ALL": language, "NUMBA_DISABLE_JIT": "1"}
        command = [sys.executable, "-c", CHILD, os.path.dirname(__file__), str(file)]
        done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert done.stdout.strip() == wanted


def test_files_that_do_not_belong_together(tmp_path):
    """A checkpoint is resumed where its result file is gone, is another one's, or has lost frames: said before anything is written."""
    run(mpm.scene.loads(scene(tmp_path / "run.vtkhdf")), 0.06)
    shutil.copyfile(tmp_path / "run.vtkhdf", tmp_path / "kept.vtkhdf")
    (tmp_path / "run.vtkhdf").unlink()
    with pytest.raises(mpm.ResultsError, match=r"run\.vtkhdf: no such result file"):
        mpm.Simulation.from_checkpoint(tmp_path / "run.ckpt.h5")
    run(mpm.scene.loads(scene(tmp_path / "short.vtkhdf")), 0.02)
    shutil.copyfile(tmp_path / "short.vtkhdf", tmp_path / "run.vtkhdf")
    with pytest.raises(mpm.ResultsError, match="has 2 frames, the checkpoint was written after 4; they do not"):
        mpm.Simulation.from_checkpoint(tmp_path / "run.ckpt.h5")
    shutil.copyfile(tmp_path / "kept.vtkhdf", tmp_path / "run.vtkhdf")
    (tmp_path / "run.history.csv").unlink()
    with pytest.raises(mpm.ResultsError, match=r"run\.history\.csv: no such history"):
        mpm.Simulation.from_checkpoint(tmp_path / "run.ckpt.h5")
