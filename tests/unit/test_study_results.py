from __future__ import annotations

import csv
import io

import pytest
from small_study import ENDS, STRESS, results

import mpmkit as mpm
from mpmkit.studies.results import STATUS, StudyResults, check_writable


def test_rows_have_all_keys_and_a_known_status():
    keys = set(results().table()[0])
    assert all(set(row) == keys for row in results())
    with pytest.raises(mpm.ResultsError, match=r"row 'x': status must be one of done, refused, .* got 'fine'"):
        StudyResults([{"label": "x", "status": "fine"}])
    assert {row["status"] for row in results()} <= set(STATUS)


def test_series_go_from_coarse_to_fine_and_leave_out_what_failed():
    series = results().series(STRESS)
    assert [row["resolution"] for row in series["GIMP"]] == [0.1, 0.05, 0.025]
    assert [row["resolution"] for row in series["QuadraticBSpline"]] == [0.05, 0.025, 0.0125]
    assert results().measures == (STRESS, ENDS)
    assert results().compositions() == ("Linear", "GIMP", "QuadraticBSpline")


def test_saved_and_loaded_they_are_the_same(tmp_path):
    before = results()
    path = before.save(tmp_path)
    after = StudyResults.load(tmp_path)
    assert path.name == "study.json"
    assert after.table() == before.table()
    assert after.meta == before.meta


def test_csv_has_a_line_for_each_run_with_its_reason(tmp_path):
    text = results().to_csv(tmp_path / "rows.csv")
    rows = list(csv.DictReader(io.StringIO(text)))
    assert (tmp_path / "rows.csv").read_text() == text
    assert len(rows) == 12
    assert rows[0][STRESS] == "0.1"
    assert next(r for r in rows if r["status"] == "unstable")["reason"].startswith("energy was created")


def test_markdown_has_three_digits_and_no_label_beside_the_axes():
    lines = results().to_markdown().splitlines()
    assert lines[0].startswith("| shape | grid.spacing | status | ")
    assert len(lines) == 14
    assert "| 0.000313 |" in lines[-2] or "| 3.13e-05 |" in lines[-2]


def test_pandas():
    pytest.importorskip("pandas")
    assert results().to_pandas()[STRESS].notna().sum() == 10


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "there are no results of a study at"),
        ("{", "not valid JSON"),
        ("[]", "it has no rows"),
        ('{"format": 0, "rows": []}', "has the format 0, this mpmkit reads 1; do the study again"),
    ],
)
def test_other_files_are_refused(tmp_path, text, message):
    if text is not None:
        (tmp_path / "study.json").write_text(text)
    with pytest.raises(mpm.ResultsError, match=message):
        StudyResults.load(tmp_path)


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(mpm.ResultsError, match=r"cannot write .*file/report.html"):
        check_writable(tmp_path / "file" / "report.html")
    with pytest.raises(mpm.ResultsError, match="it is a folder"):
        check_writable(tmp_path)
    with pytest.raises(mpm.ResultsError, match=r"cannot write .*; choose another place"):
        results().to_csv(tmp_path / "file" / "rows.csv")
    check_writable(tmp_path / "new.html")
    assert not (tmp_path / "new.html").exists()
