"""mpmkit stability on the command line, and the page of the docs."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from mpmkit.cli.app import group
from mpmkit.stability.cases import cases
from mpmkit.stability.compositions import published


def call(*arguments):
    return CliRunner().invoke(group, ["stability", *arguments])


def test_list_has_every_case():
    text = call("--list").output
    assert all(name in text for name in cases())
    data = json.loads(call("--list", "--json", "--case", "rest").output)
    assert [(c["name"], c["dim"]) for c in data] == [("rest", 2)]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--case", "res"], "no hard case is named 'res'; did you mean 'rest'?"),
        (["--with", "QuadraticBSplin"], "did you mean 'QuadraticBSpline'?"),
        (["--with", "FEM"], "the hard cases say nothing about FEM (discretization)"),
        (["--quick", "--all"], "contradict each other"),
        (["--limits", "--case", "rest"], "--limits searches the limits of the main compositions"),
    ],
)
def test_what_cannot_be_is_said_before_anything_is_written(arguments, words, tmp_path):
    result = call(*arguments, "--output", str(tmp_path / "out"))
    assert result.exit_code != 0
    assert words in result.output + str(result.exception)
    assert not (tmp_path / "out").exists()


def test_a_run_writes_data_table_and_picture_and_goes_on_where_it_was(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")  # a few hundred numbers, no loop of steps
    arguments = ["--case", "cell-crossing", "--quick", "--jobs", "2", "--output", str(tmp_path)]
    first = call(*arguments)
    assert first.exit_code == 0, first.output
    assert {p.name for p in tmp_path.iterdir()} == {f"stability.{ending}" for ending in ("json", "jsonl", "md", "png")}
    data = json.loads((tmp_path / "stability.json").read_text())
    assert {c["status"] for c in data["cells"]} == {"holds"}
    again = call(*arguments)
    assert "4 of 4 cells are known from earlier runs" in again.output
    assert json.loads((tmp_path / "stability.json").read_text())["cells"] == [c | {"seconds": 0.0} for c in data["cells"]]


@pytest.mark.physics
def test_a_plugin_of_a_third_party_goes_through_the_cases(tmp_path, monkeypatch):
    """The example plugin, installed as an installer would: its material takes the place of the cases' own."""
    source = Path(__file__).parents[1] / "third_party_plugin/src/mpmkit_mooney.py"
    shutil.copy(source, tmp_path)
    info = tmp_path / "mpmkit_mooney-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mpmkit-mooney\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[mpmkit]\nmooney = mpmkit_mooney\n")
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-m", "mpmkit", "stability", "--with", "mooney", "--quick", "--case", "rest", "--json"]
    out = subprocess.run([*command, "--output", str(tmp_path / "out")], capture_output=True, text=True, env=environment, timeout=600)
    assert out.returncode == 0, out.stderr
    data = json.loads(out.stdout)
    assert len(data["compositions"]) > 2
    assert all("MooneyRivlin" in c["name"] for c in data["compositions"])
    assert {c["status"] for c in data["cells"]} == {"holds"}


def test_the_page_shows_what_was_measured(tmp_path):
    docs = Path(__file__).parents[2] / "docs"
    if not (docs / "data/stability.json").exists():
        pytest.skip("not measured yet: python docs/stability.py")
    spec = importlib.util.spec_from_file_location("stability_page", docs / "stability.py")
    page = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(page)
    for name in (page.DATA, page.PICTURE):
        (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / page.DATA).write_bytes((docs / page.DATA).read_bytes())
    page.write(tmp_path)
    assert (tmp_path / page.TABLES).read_text(encoding="utf-8") == (docs / page.TABLES).read_text(encoding="utf-8")
    assert (docs / page.PICTURE).exists()
    data = json.loads((docs / page.DATA).read_text(encoding="utf-8"))
    assert data["contradicted"] == []
    assert data["unexplained"] == []
    # every case that is there has been measured, and holds for the default composition
    assert {c["name"] for c in data["cases"]} == set(cases())
    assert [c["name"] for c in data["compositions"]] == [c.label for c in published()]
    assert {c["status"] for c in data["cells"] if c["composition"] == 0} <= {"holds", "waiting"}
