"""Every code block of the README runs, and is what it says it is."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
import tomllib

import pytest
from blocks import blocks

from mpmkit import scene, testing


@pytest.fixture(scope="module")
def readme(root):
    """Blocks of the README."""
    return blocks(root / "README.md")


def one(readme, language, word):
    found = [b for b in readme if b.language == language and word in b.text]
    assert len(found) == 1, f"one {language} block with {word!r} is expected, found {len(found)}"
    return found[0].text


def test_the_tests_below_know_every_block(readme):
    # a new block needs a test of its own here
    assert [b.language for b in readme] == ["sh", "sh", "python", "python", "toml", "python"]


def test_ci_takes_its_commands_from_here(readme, root):
    for word, text in (("mpmkit run", readme[0].text), ("pytest", readme[1].text)):
        out = subprocess.run([sys.executable, root / ".ci/readme.py", root / "README.md", word], capture_output=True, text=True, check=True)
        assert out.stdout == text
        assert text.count("\n") == 1, "a command is one line to copy"
        assert f'"{word}")' in (root / ".ci/run").read_text()


def test_the_main_job_names_a_scene_that_leaves_what_it_views(readme, root):
    path = re.search(r"mpmkit run (\S+)", readme[0].text)[1]
    viewed = re.search(r"mpmkit view (\S+)", readme[0].text)[1]
    assert [r.path for r in scene.load(root / path).records] == [viewed]


def test_the_script_runs_and_is_the_example(readme, root, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    exec(compile(one(readme, "python", "mpm.Simulation("), "README.md", "exec"), names)
    assert "one step" in capsys.readouterr().out
    assert names["results"].frames[-1].time == pytest.approx(3.6, rel=1e-12)  # rounding: the run lands on its end
    assert (tmp_path / "disks.png").stat().st_size > 10_000
    written = scene.dumps(names["sim"])
    monkeypatch.syspath_prepend(str(root / "examples"))
    spec = importlib.util.spec_from_file_location("two_disks", root / "examples/two_disks.py")
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    assert written == scene.dumps(example.scene())
    assert written == scene.dumps(scene.load(root / "examples/two_disks.toml"))


def test_the_material_conforms(readme, tmp_path, monkeypatch):
    text = one(readme, "python", "class Rubber")
    (tmp_path / "mpmkit_rubber.py").write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    module = importlib.import_module("mpmkit_rubber")
    (rubber,) = module.mpmkit_components()
    rows = testing.report(rubber)
    assert len(rows) > 10
    assert [r for r in rows if not r["passed"]] == []
    # the lines of its pyproject.toml and of its test name the same plugin
    ((name, target),) = tomllib.loads(one(readme, "toml", "entry-points"))["project"]["entry-points"]["mpmkit"].items()
    assert target == module.__name__
    assert f'conformance("{name}")' in one(readme, "python", "from mpmkit.testing")


def test_names_of_components_in_the_text_are_registered(root):
    from mpmkit._core.registry import registry

    text = (root / "README.md").read_text().split("## What is in it")[1].split("## Extend it")[0]
    named = set(re.findall(r"`([A-Z]\w+)`", text))
    ours = {e.name for e in registry().entries if e.distribution == "mpmkit"}
    assert named == ours


def test_links_and_pictures_exist(root):
    for document in [*root.glob("*.md"), *(root / "tests").glob("*.md")]:
        for target in re.findall(r"\]\(([^)#\s]+)", document.read_text(encoding="utf-8")):
            if "://" not in target:
                assert (document.parent / target).exists(), f"{document.name}: {target}"
