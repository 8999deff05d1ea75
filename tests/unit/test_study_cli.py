from __future__ import annotations

import json

import pytest
import tomli_w
from small_study import EXACT, bar

from mpmkit.cli import main
from mpmkit.studies import results

pytestmark = pytest.mark.usefixtures("plain_python")


@pytest.fixture
def file(tmp_path, monkeypatch):
    """A study file of two runs, in the current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bar.toml").write_text(tomli_w.dumps(bar()))
    data = {"scene": "bar.toml", "repeat": 1, "axes": {"grid.spacing": [0.25, 0.125]}, "errors": [EXACT]}
    (tmp_path / "pulled.toml").write_text(tomli_w.dumps(data))
    return "pulled.toml"


def call(*arguments, status=0):
    with pytest.raises(SystemExit) as end:
        main(["study", *arguments])
    assert end.value.code == status


def test_a_study_leaves_a_folder_and_reports_and_is_not_done_twice(file, tmp_path, capsys):
    call(file, "--jobs", "1", "--report", "rows.csv", "--report", "rows.md")
    out = capsys.readouterr().out
    assert "stress.xx, L1 [0.001 Pa]" in out and "results: pulled-study, rows.csv, rows.md" in out
    found = results.StudyResults.load("pulled-study")
    assert [row["status"] for row in found] == ["done", "done"]
    assert all(row["seconds"] > 0.0 and row["ns_per_particle_step"] > 0.0 and row["peak_bytes"] > 0 for row in found)
    assert found.name == "pulled" and found.meta["resolution"] == {"name": "cell size", "unit": "m"}
    assert (tmp_path / "rows.csv").read_text() == found.to_csv()
    before = (tmp_path / "pulled-study" / "results.jsonl").read_text()
    call(file, "--quiet", "--json")
    data = json.loads(capsys.readouterr().out)
    assert data["rows"] == found.table()
    assert (tmp_path / "pulled-study" / "results.jsonl").read_text() == before


def test_a_dry_run_predicts_and_runs_nothing(file, tmp_path, capsys):
    call(file, "--dry-run", "--json", "--quiet")
    rows = json.loads(capsys.readouterr().out)
    assert [row["particles"] for row in rows] == [4, 8]
    assert [row["steps"] for row in rows] == [6, 12]
    assert all(row["seconds"] > 0.0 and row["bytes"] > 0 for row in rows)
    assert not (tmp_path / "pulled-study").exists()


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["puled.toml"], 1, "there is no study file 'puled.toml'; did you mean 'pulled.toml'?"),
        (["bar.toml"], 1, "unknown key 'grid'"),
        (["pulled.toml", "--report", "x.pdf"], 1, "cannot write a report to x.pdf: it must end in .html, .md, .csv, .json, .png, .svg"),
        (["pulled.toml", "--report", "bar.toml/x.html"], 1, "cannot write bar.toml/x.html: "),
        (["pulled.toml", "--folder", "bar.toml"], 1, "cannot write to the folder of the study, bar.toml"),
        (["pulled.toml", "--repeat", "-1"], 2, "-1 is not in the range x>=0"),
    ],
)
def test_bad_input(file, capsys, arguments, status, message):
    call(*arguments, status=status)
    assert message in capsys.readouterr().err


def test_a_study_file_with_an_unknown_axis(file, tmp_path, capsys):
    text = (tmp_path / file).read_text()
    (tmp_path / file).write_text(text.replace("grid.spacing", "grid.spacng"))
    call(file, "--dry-run", status=1)
    assert "axis 'grid.spacng': Grid has no field 'spacng'; did you mean 'spacing'?" in capsys.readouterr().err
