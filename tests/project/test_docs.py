"""The docs: a page for everything that is registered, code that runs, tables that are complete."""

from __future__ import annotations

import importlib.util
import re

import pytest
from blocks import blocks
from conftest import ROOT

from mpmkit._core.registry import registry
from mpmkit.parameters import specs

LONG = {"01-two-disks", "load-a-boundary"}
"""Pages with thousands of steps: compiled, and left for ``-m physics``; the others run as plain Python."""
WITH_CODE = sorted(p for folder in ("tutorials", "howto", "explanation") for p in (ROOT / "docs" / folder).glob("*.md"))


def script(path):
    """A script of the docs as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_component_gets_a_page(root, tmp_path):
    generate = script(root / "docs/generate.py")
    generate.main(tmp_path, root / "examples")
    components = tmp_path / "reference/components"
    index = (components / "index.md").read_text()
    for entry in registry().entries:
        page = (components / f"{entry.name}.md").read_text()
        assert f"({entry.name}.md)" in index
        assert page.startswith(f"# {entry.name}\n")
        assert f"*{entry.kind}, from {entry.distribution} {entry.version}*" in page
        for name in specs(entry.component):
            assert f"| `{name}` |" in page, f"{entry.name}.{name}"


def test_pages_of_removed_components_go_away(root, tmp_path):
    generate = script(root / "docs/generate.py")
    gone = tmp_path / "reference/components/Gone.md"
    gone.parent.mkdir(parents=True)
    gone.write_text("# Gone")
    generate.main(tmp_path, root / "examples")
    assert not gone.exists()


def test_every_example_has_its_page_and_picture(root, tmp_path):
    generate = script(root / "docs/generate.py")
    generate.main(tmp_path, root / "examples")
    checked = {p.stem for p in (root / "examples").glob("*.py") if "\ndef check(" in p.read_text(encoding="utf-8")}
    assert {p.stem for p in (tmp_path / "gallery/examples").glob("*.md")} == checked
    for path in generate.shows(root / "examples"):
        assert (root / "docs/images" / generate.drawn(path)).exists(), f"{path.name}: its picture is not there; run it once"


def test_the_command_line_page_has_all_commands_and_options(root):
    from mpmkit.cli.app import COMMANDS

    text = script(root / "docs/generate.py").command_line()
    for name in COMMANDS:
        assert f"## mpmkit {name}\n" in text
    assert "--overwrite" in text


def test_the_page_of_conformance_checks_has_all_of_them(root):
    from mpmkit.testing.checks import table
    from mpmkit.testing.suite import ALWAYS

    text = script(root / "docs/generate.py").conformance_checks()
    for name in (*ALWAYS, *(declared.name for declared in table())):
        assert f"| {name} " in text
    assert "Ruff" not in text and "noqa" not in text


@pytest.mark.parametrize("path", [pytest.param(p, id=p.stem, marks=[pytest.mark.physics] * (p.stem in LONG)) for p in WITH_CODE])
def test_python_in_the_docs_runs(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if path.stem not in LONG:
        monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    names: dict = {"__name__": path.stem}
    for block in blocks(path):
        if block.language == "python":
            exec(compile("\n" * block.line + block.text, str(path), "exec"), names)


def test_quoted_functions_of_the_generated_step_are_the_real_ones(root):
    # `python docs/generate.py` writes them anew
    page = (root / "docs/explanation/how-a-step-runs.md").read_text(encoding="utf-8")
    assert page.count("```py\n@compiled\n") == 3
    assert script(root / "docs/generate.py").quoting(page) == page


@pytest.mark.physics
def test_the_statements_of_the_how_to_on_loads_hold(root, tmp_path, monkeypatch):
    # statics: the outermost node carries the share 1 - thickness / 2 of the force of a layer, all of it in the two-point form;
    # the tolerance is what the damping has left after 0.2 s
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for block in blocks(root / "docs/howto/load-a-boundary.md"):
        exec(block.text, names)
    assert [names["layer"], names["thin_layer"], names["two_point"]] == pytest.approx([0.5, 0.75, 1.0], abs=0.01)


def test_all_columns_of_the_history_are_explained(root):
    from mpmkit._core.running.ledger import COLUMNS

    text = (root / "docs/reference/fields.md").read_text()
    assert set(COLUMNS) <= set(re.findall(r"`(\w+)`", text))


def test_every_page_is_in_a_table_of_contents(root):
    docs = root / "docs"
    listed = set()
    for path in docs.rglob("*.md"):
        for block in re.findall(r"```\{toctree\}\n(.*?)```", path.read_text(encoding="utf-8"), flags=re.DOTALL):
            for line in block.splitlines():
                if line and not line.startswith(":"):
                    listed |= set(path.parent.glob(f"{line}.md"))
    hidden = {docs / "index.md", docs / "reference/fields-table.md", docs / "performance-tables.md", docs / "stability-tables.md"}
    pages = {p for p in docs.rglob("*.md") if "_build" not in p.parts} - hidden
    assert pages - listed == set()


def test_links_within_the_docs_exist(root):
    generated = {"reference/components", "reference/command-line.md", "reference/conformance-checks.md", "gallery/examples"}
    docs = root / "docs"
    for path in docs.rglob("*.md"):
        for target in re.findall(r"\]\(([^)#\s]+)", path.read_text(encoding="utf-8")):
            if "://" in target:
                continue
            place = (path.parent / target).resolve()
            written = any(place.is_relative_to(docs / g) or path.is_relative_to(docs / g) for g in generated)
            assert written or place.exists(), f"{path.relative_to(root)}: {target}"


def test_the_picture_of_one_step_is_drawn_by_its_script(root, tmp_path):
    script(root / "docs/figures/one_step.py").main(tmp_path / "one-step.svg")
    assert (tmp_path / "one-step.svg").stat().st_size > 50_000
    assert (root / "docs/images/one-step.svg").exists()
