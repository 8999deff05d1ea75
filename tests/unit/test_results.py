"""`Results`: from a file and from memory alike."""

import subprocess
import sys

import numpy as np
import pytest

import mpmkit as mpm
from mpmkit._core.running.history import HistoryFile
from mpmkit._core.running.paths import history_path
from mpmkit._core.running.vtkhdf import ParticleFile

BODIES = ["left", "right"]
META = {"bodies": BODIES, "dim": 2, "space": "plane strain", "versions": {"mpmkit": "0.1.0"}, "units": {"stress": "Pa"}}


def frames(count=5, n=12):
    rng = np.random.default_rng(4)
    body = np.repeat([0, 1], n // 2)
    return [
        (0.25 * k, 10 * k, {"x": rng.random((n, 2)), "v": rng.random((n, 2)), "stress": rng.random((n, 6)), "body": body})
        for k in range(count)
    ]


HISTORY = {"step": np.arange(0, 50, 10), "t": np.arange(5) * 0.25, "kinetic": np.linspace(2, 1, 5)}


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "disks.vtkhdf"
    with ParticleFile.create(path, {"v": 3, "stress": 6}, {"body": frames()[0][2]["body"]}, (), {**META, "scene": "until = 1.0"}) as file:
        for time, step, data in frames():
            file.append(time, step, data["x"], {k: a for k, a in data.items() if k != "x"})
    with HistoryFile.create(history_path(path), tuple(HISTORY)) as history:
        for row in zip(*HISTORY.values(), strict=True):
            history.append(row)
    return path


@pytest.fixture(params=["file", "memory"])
def results(request, path):
    if request.param == "file":
        return mpm.Results(path)
    return mpm.Results.in_memory(frames(), HISTORY, BODIES, meta=META, scene="until = 1.0")


def test_frames_times_and_fields(results):
    assert results.times.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert len(results.frames) == 5
    assert [f.step for f in results.frames] == [0, 10, 20, 30, 40]
    assert set(results.fields) == {"x", "v", "stress", "body"}
    for k, (time, _, data) in enumerate(frames()):
        frame = results.frames[k]
        assert (frame.time, frame.n_particles) == (time, 12)
        for name, array in data.items():
            assert frame[name].shape == array.shape, "vectors have as many columns as the run has dimensions"
            # rounding: the file keeps float32, half an eps of values below 1
            np.testing.assert_allclose(frame[name], array, rtol=0, atol=np.finfo("f4").eps / 2)
    assert results.frames[-1].time == 1.0
    assert [f.time for f in results.frames[1:3]] == [0.25, 0.5]
    with pytest.raises(IndexError, match="frame 5 of a run with 5 frames"):
        results.frames[5]


def test_nearest_time(results):
    assert results.at(0.6).time == 0.5
    assert results.at("260 ms").time == 0.25
    assert results.at(99.0).time == 1.0
    with pytest.raises(mpm.ResultsError, match="time must be a number of seconds, got nan"):
        results.at(float("nan"))


def test_bodies(results):
    assert results.bodies == ("left", "right")
    right = results.frames[1].body("right")
    assert right.n_particles == 6
    np.testing.assert_array_equal(right["v"], results.frames[1]["v"][6:])
    assert set(dict(right)) == set(results.fields)
    with pytest.raises(mpm.ResultsError, match=r"no body 'rihgt'; did you mean 'right'\? \(bodies: left, right\)"):
        results.frames[1].body("rihgt")


def test_history_and_scene(results):
    assert results.history["kinetic"].tolist() == HISTORY["kinetic"].tolist()
    assert results.history.t[-1] == 1.0
    assert results.scene == "until = 1.0"
    with pytest.raises(mpm.ResultsError, match="no column 'kinetik'; did you mean 'kinetic'"):
        results.history["kinetik"]
    assert not hasattr(results.history, "kinetik")


def test_wrong_names_are_answered(results):
    with pytest.raises(mpm.ResultsError, match=r"no field 'stres'; did you mean 'stress'\? \(it holds .*Record\(fields="):
        results.frames[0]["stres"]
    assert "stres" not in results.frames[0]


def test_shown_in_words_and_in_notebooks(results):
    assert "5 frames" in repr(results) and "left" in repr(results)
    assert "12 particles" in repr(results.frames[2])
    for text in (results._repr_html_(), results.frames[0]._repr_html_()):
        assert text.count("<table>") == text.count("</table>") == 1 and "stress" in text


def test_lone_body_needs_no_numbers():
    one = mpm.Results.in_memory([(0.0, 0, {"x": np.zeros((3, 1))})], {}, ["bar"])
    assert one.frames[0].body("bar").n_particles == 3


def test_a_run_that_goes_on(tmp_path):
    path = tmp_path / "a.vtkhdf"
    file = ParticleFile.create(path, {}, meta={"dim": 2})
    results = mpm.Results(path)
    assert (len(results.frames), results.fields) == (0, ())
    with pytest.raises(mpm.ResultsError, match="no frame yet"):
        results.at(0.0)
    file.append(0.5, 1, np.zeros((4, 2)), {})
    assert len(results.frames) == 0, "what was seen stays"
    assert results.refresh().times.tolist() == [0.5]
    assert results.frames[0]["x"].shape == (4, 2)
    file.close()
    with pytest.raises(mpm.ResultsError, match="no such history"):
        results.history  # noqa: B018
    path.unlink()
    with pytest.raises(mpm.ResultsError, match="is gone"):
        results.frames[0]["x"]


def test_pandas(results):
    pandas = pytest.importorskip("pandas")
    table = results.to_pandas(0.5)
    assert isinstance(table, pandas.DataFrame) and len(table) == 12
    assert list(table["body"].unique()) == BODIES
    np.testing.assert_array_equal(table["stress.xy"], results.at(0.5)["stress"][:, 3])
    assert table.attrs == {"time": 0.5, "step": 20}


def test_xarray(results):
    pytest.importorskip("xarray")
    data = results.to_xarray()
    np.testing.assert_array_equal(data["stress"].sel(component6="yy", time=0.75), results.at(0.75)["stress"][:, 1])
    assert data["v"].dims == ("time", "particle", "component2")


def test_pyvista(results):
    pytest.importorskip("pyvista")
    cloud = results.to_pyvista()
    assert cloud.n_points == 12 and cloud.point_data["v"].shape == (12, 3)


def test_a_missing_library_is_named(results, monkeypatch):
    for method, module in (("to_pandas", "pandas"), ("to_xarray", "xarray"), ("to_pyvista", "pyvista")):
        monkeypatch.setitem(sys.modules, module, None)
        with pytest.raises(mpm.ResultsError, match=rf"Results.{method} needs {module}, which is not installed: pip install 'mpmkit\["):
            getattr(results, method)()


def test_reading_imports_neither_numba_nor_matplotlib(path):
    read = f"import sys, mpmkit; mpmkit.Results({str(path)!r}).frames[0]['x']"
    code = f"{read}; print({{'numba', 'matplotlib', 'pandas', 'rich'}} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "set()"
