"""The command line from a scene file to results, a picture and a resumed run."""

import json
import subprocess
import sys

import numpy as np
import pytest

import mpmkit as mpm

SCENE = """
until = "2 s"
[grid]
lower = 0
upper = 2
spacing = 0.1
[shape]
kind = "Linear"
[integrator]
kind = "MUSL"
dt = 0.01
[[bodies]]
geometry = { kind = "Box", lower = 0.5, upper = 1.0 }
material = { kind = "LinearElastic", E = 4, nu = 0, rho = 1 }
v = 0.1
[[records]]
path = "bar.vtkhdf"
every = 0.5
"""


@pytest.fixture(scope="module")
def mpmkit(tmp_path_factory):
    """Function: run the command line in one folder, where the scene has already run to t = 1 s."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "bar.toml").write_text(SCENE)

    def call(*arguments):
        return subprocess.run(
            [sys.executable, "-m", "mpmkit", *arguments], cwd=folder, capture_output=True, text=True, timeout=300, check=False
        )

    call.folder = folder
    first = call("run", "bar.toml", "--until", "1 s")
    assert first.returncode == 0, first.stderr
    assert first.stdout == "results: bar.vtkhdf\n"
    return call


def test_results_of_run(mpmkit):
    assert mpm.Results(mpmkit.folder / "bar.vtkhdf").times[-1] == pytest.approx(1.0, rel=1e-12)  # rounding: sum of 100 steps


def test_existing_results_are_kept_unless_asked(mpmkit):
    before = (mpmkit.folder / "bar.vtkhdf").read_bytes()
    refused = mpmkit("run", "bar.toml")
    assert refused.returncode == 1
    assert "--overwrite" in refused.stderr
    assert (mpmkit.folder / "bar.vtkhdf").read_bytes() == before


def test_view(mpmkit):
    done = mpmkit("view", "bar.vtkhdf", "--field", "v", "--time", "500 ms", "--output", "bar.png")
    assert (done.returncode, done.stdout) == (0, "picture: bar.png\n"), done.stderr
    assert (mpmkit.folder / "bar.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    wrong = mpmkit("view", "bar.vtkhdf", "--field", "strss")
    assert wrong.returncode == 1
    assert "did you mean 'stress'" in wrong.stderr


def test_explain_runs_nothing(mpmkit):
    before = sorted(p.name for p in mpmkit.folder.iterdir())
    done = mpmkit("explain", "bar.toml")
    assert done.returncode == 0, done.stderr
    assert "MUSL" in done.stdout
    assert "LinearElastic" in done.stdout
    assert sorted(p.name for p in mpmkit.folder.iterdir()) == before


def test_resume_ends_like_one_run(mpmkit):
    resumed = mpmkit("resume", "bar.ckpt.h5", "--quiet")
    assert (resumed.returncode, resumed.stdout) == (0, ""), resumed.stderr
    whole = mpmkit("run", "bar.toml", "--quiet", "--output", "whole.vtkhdf")
    assert (whole.returncode, whole.stdout, whole.stderr) == (0, "", "")
    a, b = (mpm.Results(mpmkit.folder / name).at(2.0) for name in ("bar.vtkhdf", "whole.vtkhdf"))
    for field in ("x", "v", "stress"):
        assert np.array_equal(a[field], b[field])


def test_check_of_a_real_component(mpmkit):
    done = mpmkit("check", "Linear", "--json")
    assert done.returncode == 0, done.stderr
    assert all(row["passed"] for row in json.loads(done.stdout))
