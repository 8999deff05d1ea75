"""The published studies: their files can be run, their results belong to them, and their pages say what the results say."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from mpmkit.studies import Study, StudyResults, fit

ROOT = Path(__file__).parents[2]
FILES = sorted((ROOT / "examples/studies").glob("*_study.toml"))
NAMES = [path.stem.removesuffix("_study") for path in FILES]


@pytest.fixture(scope="module")
def studies():
    """docs/studies.py as a module."""
    spec = importlib.util.spec_from_file_location("published_studies", ROOT / "docs/studies.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_study_has_words_results_a_page_and_a_picture(studies):
    assert sorted(studies.STUDIES) == NAMES
    for name in NAMES:
        assert studies.data_file(name).is_file(), f"{name}: python docs/studies.py {name} makes its results"
        assert (ROOT / f"docs/images/study_{name}.png").stat().st_size > 10_000, name
    assert {p.stem for p in (ROOT / "docs/studies").glob("*.md")} == {*NAMES, "index"}
    kept = {p for folder in (ROOT / "docs/data/studies", ROOT / "src/mpmkit/studies/published") for p in folder.glob("*.json")}
    assert kept == {studies.data_file(name) for name in NAMES}, "results without a study"


@pytest.mark.parametrize("name", NAMES)
def test_study_can_be_run_and_its_results_belong_to_it(studies, name):
    study = Study.from_file(studies.study_file(name))
    plan, results = study.plan(), StudyResults.load(studies.data_file(name))
    assert {run.label for run in plan if run.status not in ("planned", "refused")} == set()
    assert results.name == study.name and results.meta["complete"]
    assert results.meta["axes"] == {axis.name: list(axis.labels) for axis in study.axes}
    assert results.meta["measures"] == [m.plain() for m in study.errors]
    assert [row["label"] for row in results] == [run.label for run in plan]
    refused = {run.label: run.reason for run in plan if run.status == "refused"}
    assert {row["label"]: row["reason"] for row in results if row["status"] == "refused"} == refused
    assert [row["label"] for row in results if row["status"] == "failed"] == []


@pytest.mark.parametrize("name", NAMES)
def test_page_says_what_the_results_say(studies, name):
    # python docs/studies.py --redraw writes the pages anew
    assert (ROOT / f"docs/studies/{name}.md").read_text(encoding="utf-8") == studies.page(name, studies.results_of(name))


def test_the_first_page_says_what_all_results_say(studies):
    found = {name: studies.results_of(name) for name in studies.STUDIES}
    assert (ROOT / "docs/studies/index.md").read_text(encoding="utf-8") == studies.index(found)


def test_advice_is_short_and_orders_of_theory_have_a_source(studies):
    for name, words in studies.STUDIES.items():
        assert 2 <= len(words["said"]) <= 4 and all(len(line.split()) > 8 for line in words["said"]), name
        for expected in words.get("theory", ()):
            assert expected["source"] and expected["compositions"], name


def test_ranking_of_a_study_that_is_done_again(studies):
    # the same results rank the same; with the times of one composition ten times as long they do not
    results = studies.results_of("waves")
    for k, row in enumerate(results.rows):
        row |= {"seconds": 1.0 + k, "seconds_low": 0.9 + k, "seconds_high": 1.1 + k} if row["status"] == "done" else {}
    told = studies.ranking(results, results, "waves")
    assert told["same"] == told["pairs"] > 100 and told["tau"] == pytest.approx(1.0) and told["agree"] == told["levels"] > 3
    slower = StudyResults(
        [r | {"seconds": 100.0 * r["seconds"]} if r["seconds"] and "Linear" in r["label"] else r for r in results], results.meta
    )
    told = studies.ranking(results, slower, "waves")
    assert told["same"] < told["pairs"] and told["tau"] < 0.9


def test_order_of_the_front_picture_is_that_of_its_study(studies):
    front = studies.WORDS["front"]
    part = studies.results_of(front["study"]).parts()[front["problem"]]
    assert any(order is not None for order in fit.orders(part, part.measures[front["error"]]).values())
    assert (ROOT / f"docs/images/{studies.FRONT}").stat().st_size > 10_000
