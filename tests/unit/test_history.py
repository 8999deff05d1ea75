"""The history file: exact numbers, no lost rows, clean cuts."""

import numpy as np
import pytest

from mpmkit._core.running.history import HistoryFile, read_history
from mpmkit._core.running.paths import checkpoint_path, history_path
from mpmkit.errors import ResultsError


def _rows(n):
    values = np.random.default_rng(1).standard_normal((n, 2)) * 10.0 ** np.arange(-150, -150 + n)[:, None]
    return [{"step": 10 * k, "t": values[k, 0], "kinetic": values[k, 1]} for k in range(n)]


def test_floats_come_back_to_the_bit(tmp_path):
    rows = [*_rows(20), {"step": 999, "t": np.float32(0.1), "kinetic": float("inf")}, {"step": 1000, "t": float("nan"), "kinetic": -0.0}]
    with HistoryFile.create(tmp_path / "a.history.csv", ("step", "t", "kinetic")) as history:
        for row in rows:
            history.append(row)
    back = read_history(tmp_path / "a.history.csv")
    assert back["step"].dtype == np.int64
    for name in ("t", "kinetic"):
        assert back[name].tobytes() == np.array([float(r[name]) for r in rows]).tobytes()


def test_rows_are_in_the_file_while_it_is_open(tmp_path):
    history = HistoryFile.create(tmp_path / "a.csv", ("step", "t"))
    history.append((0, 0.0))
    history.append((10, 0.5))
    assert read_history(tmp_path / "a.csv")["t"].tolist() == [0.0, 0.5]
    history.close()


def test_resume_drops_later_rows_and_a_cut_one(tmp_path):
    path = tmp_path / "a.csv"
    with HistoryFile.create(path, ("step", "t", "kinetic")) as history:
        for row in _rows(5):
            history.append(row)
    before = path.read_bytes().splitlines(keepends=True)
    with path.open("a") as torn:
        torn.write("50,0.12")
    assert len(read_history(path)["step"]) == 5, "a row without its end is not there yet"
    with HistoryFile.reopen(path, step=20) as history:
        assert path.read_bytes() == b"".join(before[:4])
        history.append((30, 1.0, 2.0))
        history.truncate(10)
        history.append((20, 3.0, 4.0))
    assert read_history(path)["step"].tolist() == [0, 10, 20]
    assert read_history(path)["t"][-1] == 3.0


def test_text_columns_may_hold_anything(tmp_path):
    with HistoryFile.create(tmp_path / "a.csv", ("step", "limit")) as history:
        history.append((0, 'wave speed, "left"\nsecond line'))
        history.append((1, "x"))
        history.truncate(0)
    assert read_history(tmp_path / "a.csv")["limit"].tolist() == ['wave speed, "left" second line']


def test_empty_history_has_its_columns(tmp_path):
    HistoryFile.create(tmp_path / "a.csv", ("step", "t")).close()
    assert {k: len(v) for k, v in read_history(tmp_path / "a.csv").items()} == {"step": 0, "t": 0}


def test_errors_say_what_is_wrong(tmp_path):
    path = tmp_path / "a.csv"
    history = HistoryFile.create(path, ("step", "t"))
    with pytest.raises(ResultsError, match="exactly its columns; these differ: T, t"):
        history.append({"step": 0, "T": 1.0})
    with pytest.raises(ResultsError, match="a row of 3 numbers for 2 columns"):
        history.append((0, 1.0, 2.0))
    history.close()
    with pytest.raises(ResultsError, match=r"exists: .*overwrite=True"):
        HistoryFile.create(path, ("step", "t"))
    HistoryFile.create(path, ("step", "v"), overwrite=True).close()
    with pytest.raises(ResultsError, match="one of them 'step'"):
        HistoryFile.create(tmp_path / "b.csv", ("t",))
    with pytest.raises(ResultsError, match="no such history"):
        read_history(tmp_path / "none.csv")
    path.write_text("hello\n")
    with pytest.raises(ResultsError, match="is not a history"):
        read_history(path)
    path.write_text("step,t\n0,1.0\n")
    with pytest.raises(ResultsError, match="the last 'check'"):
        read_history(path)
    path.write_text("step,t,check\n0,1.0,2.0\n")
    with pytest.raises(ResultsError, match="line 2 does not fit its checksum"):
        read_history(path)
    with pytest.raises(ResultsError, match="none 'check'"):
        HistoryFile.create(tmp_path / "b.csv", ("step", "check"))


def test_a_changed_digit_is_noticed(tmp_path):
    path = tmp_path / "a.csv"
    with HistoryFile.create(path, ("step", "t", "kinetic")) as history:
        for row in _rows(3):
            history.append(row)
    good = path.read_text()
    for at, letter in enumerate(good):
        path.write_text(good[:at] + ("3" if letter != "3" else "4") + good[at + 1 :])
        try:
            found = read_history(path)
        except ResultsError:
            with pytest.raises(ResultsError):
                HistoryFile.reopen(path)
            continue
        assert letter == "\n" and at == len(good) - 1, f"character {at}, {letter!r}"
        assert len(found["step"]) == 2  # without its end the last row counts as not yet written


def test_names_beside_the_result_file():
    assert str(history_path("out/disks.fine.vtkhdf")).endswith("disks.fine.history.csv")
    assert str(checkpoint_path("disks.hdf")) == "disks.ckpt.h5"
