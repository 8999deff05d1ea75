"""Result files: VTK reads every step, also while they grow and after a kill; resumed files equal uninterrupted ones."""

import os
import random
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from mpmkit._core.reading.vtkhdf import Reader
from mpmkit._core.running.vtkhdf import ParticleFile
from mpmkit.errors import ResultsError

FIELDS = {"x": 3, "v": 3, "stress": 6, "F": 9, "J": 1}
META = {"scene": "until = 1.0\n# ümlaut\n", "bodies": ["left", "right"], "dim": 2, "versions": {"mpmkit": "0.1.0"}}


def frame(k, n=50):
    """Positions, fields and scalars of frame k: every number tells its frame and row."""
    rows = k + np.arange(n)[:, None] / 1000
    data = {
        "v": rows * np.ones(2),
        "stress": rows * np.ones(6),
        "F": (rows * np.ones(9)).reshape(n, 3, 3),
        "J": rows[:, 0],
        "body": np.arange(n) % 2,
    }
    return rows * [1, -1], data, {"kinetic": 0.1 * k}


def write(file, ks, counts=None):
    for k in ks:
        x, data, scalars = frame(k, 50 if counts is None else counts[k])
        file.append(0.1 * k, 10 * k, x, data, scalars)


def create(path, **options):
    return ParticleFile.create(path, FIELDS, {"body": np.arange(50) % 2}, ("kinetic",), META, **options)


def check_with_vtk(path, counts):
    hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

    reader = hdf.vtkHDFReader()
    assert reader.CanReadFile(str(path))
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    assert list(times) == [0.1 * k for k in range(len(counts))]
    for k, n in enumerate(counts):
        reader.SetStep(k)
        reader.Update()
        out = reader.GetOutputDataObject(0)
        points, fields = out.GetPointData(), out.GetFieldData()
        x, data, scalars = frame(k, n)
        assert (out.GetNumberOfPoints(), out.GetNumberOfCells()) == (n, n)
        np.testing.assert_array_equal(vtk_to_numpy(out.GetPoints().GetData()), np.pad(x, ((0, 0), (0, 1))).astype("f4"))
        np.testing.assert_array_equal(vtk_to_numpy(out.GetVerts().GetConnectivityArray()), np.arange(n))
        np.testing.assert_array_equal(vtk_to_numpy(points.GetArray("v")), np.pad(data["v"], ((0, 0), (0, 1))).astype("f4"))
        np.testing.assert_array_equal(vtk_to_numpy(points.GetArray("stress")), data["stress"].astype("f4"))
        np.testing.assert_array_equal(vtk_to_numpy(points.GetArray("F")), data["F"].reshape(n, 9).astype("f4"))
        np.testing.assert_array_equal(vtk_to_numpy(points.GetArray("J")), data["J"].astype("f4"))
        np.testing.assert_array_equal(vtk_to_numpy(points.GetArray("body")), data["body"])
        assert vtk_to_numpy(fields.GetArray("kinetic")) == [scalars["kinetic"]]
        assert vtk_to_numpy(fields.GetArray("step")) == [10 * k]


@pytest.mark.parametrize("compress", [False, True])
def test_vtk_reads_all_steps_while_the_file_is_open_and_after(tmp_path, compress):
    path, counts = tmp_path / "a.vtkhdf", [50, 50, 40, 50, 61, 40]
    with create(path, compress=compress) as file:
        write(file, range(4), counts)
        check_with_vtk(path, counts[:4])
        write(file, range(4, 6), counts)
        check_with_vtk(path, counts)
    check_with_vtk(path, counts)


class Killed(BaseException):
    """Stands for a kill."""


def test_killed_between_two_flushes(tmp_path, monkeypatch):
    """VTK crashes where there are more times than NSteps says: no moment may leave such a file."""
    for survives in range(3):
        path = tmp_path / f"{survives}.vtkhdf"
        file = create(path)
        write(file, range(3))
        flush, left = file._file.flush, [survives]

        def until_killed(flush=flush, left=left):
            flush()
            if left[0] == 0:
                raise Killed
            left[0] -= 1

        monkeypatch.setattr(file._file, "flush", until_killed)
        with pytest.raises(Killed):
            write(file, [3])
        n_steps, n_times = int(file._steps.attrs["NSteps"]), len(file._steps["Values"])
        assert (n_steps, n_times) == [(3, 3), (4, 3), (4, 4)][survives]
        whole = 4 if survives == 2 else 3
        assert len(Reader(path).index().times) == whole
        monkeypatch.undo()
        file._file.close()
        if survives == 0:
            check_with_vtk(path, [50] * 3)
        with ParticleFile.reopen(path) as file:
            assert file.n_frames == whole
            write(file, range(whole, 6))
        check_with_vtk(path, [50] * 6)


@pytest.mark.parametrize("compress", [False, True])
def test_a_resumed_file_reads_as_if_never_interrupted(tmp_path, compress):
    path, counts = tmp_path / "a.vtkhdf", [50, 40, 50, 61, 50, 40]
    with create(path, compress=compress) as file:
        write(file, range(6), [50, 40, 50, 33, 20, 10])
    with ParticleFile.reopen(path) as file:
        assert file.n_frames == 6
        assert file.times.tolist() == [0.1 * k for k in range(6)]
        file.truncate(3)
        assert len(Reader(path).index().times) == 3
        write(file, range(3, 6), counts)
    reader = Reader(path)
    index = reader.index()
    assert index.count.tolist() == counts
    assert index.steps.tolist() == [0, 10, 20, 30, 40, 50]
    for k, n in enumerate(counts):
        x, data, scalars = frame(k, n)
        np.testing.assert_array_equal(reader.array(k, "x", index)[:, :2], x.astype("f4"))
        np.testing.assert_array_equal(reader.array(k, "stress", index), data["stress"].astype("f4"))
        np.testing.assert_array_equal(reader.array(k, "body", index), data["body"])
        assert reader.scalars(k) == scalars
    check_with_vtk(path, counts)
    with ParticleFile.reopen(path) as file:
        file.truncate(0)
        write(file, range(2))
    assert len(Reader(path).index().times) == 2
    with ParticleFile.reopen(path) as file, pytest.raises(ResultsError, match="cannot go back to 3 frames, the file has 2"):
        file.truncate(3)


def test_fixed_arrays_are_written_again_only_when_they_change(tmp_path):
    with create(tmp_path / "a.vtkhdf") as file:
        write(file, range(3))
        x, data, scalars = frame(3)
        data.pop("body")
        file.append(0.3, 30, x, data, scalars)
        stored = file._root["PointData/body"]
        assert (stored.shape, stored.dtype) == ((50,), np.int32)
        data["body"] = np.ones(50, dtype=int)
        file.append(0.4, 40, x, data, scalars)
        assert stored.shape == (100,)
        x, data, scalars = frame(5, 40)
        data.pop("body")
        with pytest.raises(ResultsError, match=r"'body' has shape \(50,\) for 40 particles; give it with the frame"):
            file.append(0.5, 50, x, data, scalars)


def test_scene_and_facts_are_kept(tmp_path):
    with create(tmp_path / "a.hdf"):
        reader = Reader(tmp_path / "a.hdf")
    assert reader.scene == META["scene"]
    assert reader.meta == {k: v for k, v in META.items() if k != "scene"}
    ParticleFile.create(tmp_path / "b.hdf", {}, meta={"scene": None}).close()
    assert Reader(tmp_path / "b.hdf").scene is None
    ParticleFile.create(tmp_path / "c.hdf", {}, meta={"scene": "", "long": "x" * 100_000}).close()
    assert Reader(tmp_path / "c.hdf").scene == ""
    assert len(Reader(tmp_path / "c.hdf").meta["long"]) == 100_000


def test_bad_frames_are_refused_before_anything_is_written(tmp_path):
    file = create(tmp_path / "a.vtkhdf")
    x, data, scalars = frame(0)
    bad = [
        ({**data, "J": data["J"][:3]}, scalars, "'J' has 3 rows for 50 particles"),
        ({k: v for k, v in data.items() if k != "v"}, scalars, "lacks the field 'v'"),
        ({**data, "stress": data["stress"][:, :4]}, scalars, "'stress' has 4 components, this file was made for 6"),
        ({**data, "T": data["J"]}, scalars, "was not made for T"),
        (data, {}, "a frame needs the scalars"),
    ]
    for fields, numbers, message in bad:
        with pytest.raises(ResultsError, match=message):
            file.append(0.0, 0, x, fields, numbers)
    assert file.n_frames == 0
    write(file, [0])
    file.close()
    file.close()
    with pytest.raises(ResultsError, match="is closed"):
        write(file, [1])
    for names in ({"a/b": 1}, {"a.b": 1}, {"step": 1}, {"body": 1}):
        with pytest.raises(ResultsError, match=r"cannot be the name|is used twice"):
            ParticleFile.create(tmp_path / "b.vtkhdf", names, {"body": np.zeros(3, int)})


def test_existing_and_unwritable_paths(tmp_path):
    path = tmp_path / "new" / "folder" / "a.vtkhdf"
    with create(path) as file:
        write(file, [0])
    with pytest.raises(ResultsError, match=r"exists: .*overwrite=True"):
        create(path)
    assert len(Reader(path).index().times) == 1, "the refused attempt must not have touched it"
    create(path, overwrite=True).close()
    assert len(Reader(path).index().times) == 0
    with pytest.raises(ResultsError, match="cannot make the folder"):
        create(path / "b.vtkhdf")
    with pytest.raises(ResultsError, match="this is a folder"):
        create(tmp_path, overwrite=True)


def test_foreign_and_damaged_files_are_named(tmp_path):
    import h5py

    path = tmp_path / "a.vtkhdf"
    with create(path) as file:
        write(file, range(3))
    whole = path.read_bytes()
    cases = {
        "truncated": (whole[: len(whole) // 2], r"a.vtkhdf is truncated"),
        "empty": (b"", "it is empty"),
        "text": (b"hello world", "no HDF5 file at all"),
    }
    for content, message in cases.values():
        path.write_bytes(content)
        with pytest.raises(ResultsError, match=message):
            Reader(path)
    with pytest.raises(ResultsError, match="no such result file"):
        Reader(tmp_path / "none.vtkhdf")
    with pytest.raises(ResultsError, match="is not a file"):
        Reader(tmp_path)
    with h5py.File(path, "w") as other:
        other["x"] = 1
    with pytest.raises(ResultsError, match="without the group /VTKHDF"):
        Reader(path)
    with h5py.File(path, "w") as other:
        other.create_group("VTKHDF").attrs["Type"] = np.bytes_("ImageData")
    with pytest.raises(ResultsError, match=r"of another program \(type ImageData\)"):
        ParticleFile.reopen(path)
    path.write_bytes(whole)
    with h5py.File(path, "r+") as newer:
        newer["mpmkit"].attrs["format"] = 99
    with pytest.raises(ResultsError, match="written in format 99"):
        Reader(path)


_WRITER = """
import os, sys, numpy as np
from mpmkit._core.running.vtkhdf import ParticleFile
file = ParticleFile.create(sys.argv[1], {"stress": 6}, compress=sys.argv[2] == "1", overwrite=True)
k = 0
while True:
    n = 3000 + 10 * (k % 7)
    file.append(0.1 * k, k, np.full((n, 3), k), {"stress": np.full((n, 6), k)})
    k += 1
    os.write(1, b"%d\\n" % k)
"""


@pytest.mark.parametrize("compress", ["0", "1"])
def test_killed_at_any_moment_all_acknowledged_frames_are_right(tmp_path, compress):
    path, rng = tmp_path / "a.vtkhdf", random.Random(7)
    for _ in range(3):
        with (tmp_path / "log").open("w+") as log:
            writer = subprocess.Popen([sys.executable, "-c", _WRITER, str(path), compress], stdout=log)
            end = time.monotonic() + 30
            while os.path.getsize(tmp_path / "log") == 0 and time.monotonic() < end:
                time.sleep(0.005)
            time.sleep(rng.uniform(0, 0.2))
            writer.send_signal(signal.SIGKILL)
            writer.wait()
            log.seek(0)
            acknowledged = int(log.read().split("\n")[-2])
        reader = Reader(path)
        index = reader.index()
        assert len(index.times) >= acknowledged
        for k in range(len(index.times)):
            assert (reader.array(k, "x", index) == k).all() and (reader.array(k, "stress", index) == k).all()
        with ParticleFile.reopen(path) as file:
            file.append(1e9, 1, np.zeros((5, 3)), {"stress": np.zeros((5, 6))})
        index = reader.index()
        assert (index.count[-1], len(index.times) - 1 >= acknowledged) == (5, True)
        assert (reader.array(acknowledged - 1, "x", index) == acknowledged - 1).all()


_FULL = """
import resource, signal, sys, numpy as np
from mpmkit._core.running.vtkhdf import ParticleFile
from mpmkit.errors import ResultsError
if sys.argv[2] == "unnoticed":  # on file systems that cannot reserve, HDF5 itself meets the full disk
    import mpmkit._core.running.vtkhdf as vtkhdf
    vtkhdf.reserve = lambda file, n_bytes: None
file = ParticleFile.create(sys.argv[1], {"stress": 6})
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, 2_000_000))
try:
    for k in range(1000):
        file.append(0.1 * k, k, np.full((1000, 3), k), {"stress": np.full((1000, 6), k)})
except ResultsError as error:
    print(file.n_frames, error)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="needs a limit on the size of files")
@pytest.mark.parametrize("full", ["noticed", "unnoticed"])
def test_a_full_disk_keeps_the_frames_before(tmp_path, full):
    path = tmp_path / "a.vtkhdf"
    done = subprocess.run([sys.executable, "-c", _FULL, str(path), full], check=False, capture_output=True, text=True, timeout=60)
    if full == "noticed":
        assert (done.returncode, done.stderr) == (0, "")
    kept = int(done.stdout.split()[0])
    assert 5 < kept < 200
    assert f"cannot write frame {kept} at t" in done.stdout and f"the {kept} frames before it are kept" in done.stdout
    if full == "unnoticed":
        return  # the user is told; how HDF5 2.0 ends after such a failure (it may crash at exit) is not ours to promise
    reader = Reader(path)
    index = reader.index()
    assert len(index.times) == kept
    for k in range(kept):
        assert (reader.array(k, "stress", index) == k).all()
    with ParticleFile.reopen(path) as file:
        file.append(1e9, 1, np.zeros((5, 3)), {"stress": np.zeros((5, 6))})
    assert len(reader.index().times) == kept + 1


def test_reserved_room_is_given_back(tmp_path):
    with create(tmp_path / "a.vtkhdf") as file:
        write(file, range(3))
        open_size = os.path.getsize(tmp_path / "a.vtkhdf")
        used = file._file.id.get_filesize()
    assert open_size > used >= os.path.getsize(tmp_path / "a.vtkhdf")
    check_with_vtk(tmp_path / "a.vtkhdf", [50] * 3)
