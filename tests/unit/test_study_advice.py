from __future__ import annotations

import json
import re

import pytest
import tomli_w
from small_study import EXACT, Here, bar

import mpmkit as mpm
from mpmkit.cli import main
from mpmkit.parameters import example_arguments
from mpmkit.studies import Study, advising, problem, published
from mpmkit.studies.results import StudyResults

LABEL = "stress.xx, L1 [0.001 Pa]"


def facts(**more):
    told = {
        "space": "1D",
        "dim": 1,
        "length": 1.0,
        "materials": ["elastic"],
        "contact": False,
        "moves at the start": False,
        "loads": ["Wall"],
    }
    return told | more


def study(orders, **more):
    """A study with errors (8 h)^p at 8, 16, 32 cells, by name of the shape."""
    rows = [
        {"label": f"{shape}, {n}", "composition": shape, "choices": {}, "labels": {"shape": shape}, "resolution": 1.0 / n, "travel": 0.01,
         "errors": {"e": (8.0 / n) ** p}, "seconds": 1e-3 * n, "ns_per_particle_step": 100.0 if shape == "Linear" else 150.0}
        for shape, p in orders.items() for n in (8, 16, 32)
    ]  # fmt: skip
    about = {shape: {"problem": facts(**more), "components": {"shape": {"kind": shape}, "integrator": "MUSL"}} for shape in orders}
    meta = {
        "name": "made up",
        "errors": [{"label": "e", "unit": "1"}],
        "resolution": {"name": "cell size", "unit": "m"},
        "compositions": about,
    }
    return StudyResults(rows, meta)


def test_the_problem_of_a_scene():
    sim = mpm.scene.loads(json.dumps(bar()), format="json")
    assert problem.describe(sim) == facts(loads=["TwoPointTraction", "Wall"])
    expected = {"shape": {"kind": "Linear"}, "integrator": "MUSL", "bodies.*.particles_per_cell": 1}
    assert problem.components(sim).items() >= expected.items()


def test_materials_are_told_apart_by_what_they_do_with_work():
    materials = mpm.materials
    found = [
        problem.family(m)
        for m in (
            materials.NeoHookean(E=1.0, nu=0.3, rho=1.0),
            materials.VonMises(**example_arguments(materials.VonMises)),
            materials.NewtonianFluid(**example_arguments(materials.NewtonianFluid)),
        )
    ]
    assert found == ["elastic", "plastic", "viscous"]


def test_equal_problems_are_alike_and_others_less():
    score, same, differs = problem.alike(facts(), facts(), 0.1, 0.2)
    assert score == 1.0 and differs == [] and "particles stay in their cells" in same
    crossing, _, differs = problem.alike(facts(), facts(), 3.0, 0.2)
    assert differs == ["particles stay in their cells there, but cross them here"]
    other, _, differs = problem.alike(facts(), facts(space="3D", dim=3, contact=True), 0.1, 0.1)
    assert other < crossing < 1.0 and differs == ["3D, not 1D", "several bodies, not one body"]
    assert problem.alike(facts(), facts(), None, 0.1)[0] < 1.0


def test_errors_are_read_between_measured_ones_and_a_little_beyond():
    (one,) = published.known([study({"Linear": 1.0})])
    assert one.error_at(16) == (pytest.approx(0.5), published.INSIDE)
    assert one.error_at(8 * 2**0.5) == (pytest.approx(0.5**0.5), published.INSIDE)
    assert one.error_at(64) == (pytest.approx(0.125), published.BEYOND)
    assert one.error_at(4) == (1.0, published.COARSER)
    assert one.error_at(1000) is None
    assert one.cells_for(0.5) == (pytest.approx(16.0), published.INSIDE)
    assert one.cells_for(0.125) == (pytest.approx(64.0), published.BEYOND)
    assert one.cells_for(0.001) is None


def test_what_has_stalled_is_not_carried_on():
    (one,) = published.known([study({"Linear": 0.05})])
    assert one.stalls and one.error_at(64) is None and one.cells_for(0.1) is None


def test_errors_with_a_unit_say_nothing_about_other_scenes():
    found = study({"Linear": 1.0})
    found.meta["errors"][0]["unit"] = "Pa"
    assert published.known([found]) == []


def test_published_studies_are_complete_and_name_no_place():
    files = sorted(published.FOLDER.glob("*.json"))
    assert len(files) >= 2
    for path in files:
        assert not re.search(r"[\s\"](/\w+/|[A-Z]:\\\\)", path.read_text())
        found = StudyResults.load(path)
        assert found.meta["complete"] and published.known([found]), path


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A scene, a short look at it, and no published studies."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(advising, "SCOUT_SECONDS", 0.1)
    monkeypatch.setattr(published, "FOLDER", tmp_path / "none")
    (tmp_path / "bar.toml").write_text(tomli_w.dumps(bar()))
    return tmp_path


pytestmark = pytest.mark.usefixtures("plain_python")


def test_a_cheaper_composition_is_named_with_its_time(place):
    study({"Linear": 0.5, "QuadraticBSpline": 2.0}, loads=["TwoPointTraction", "Wall"]).save(place / "made-up.json")
    found = advising.advise("bar.toml", "10%", studies=["made-up.json"])
    assert found.study == "made up" and found.likeness == 1.0 and found.sure == "fairly sure"
    assert (found.here.error, found.here.origin) == (1.0, published.INSIDE)
    assert found.here.particles == 8 and found.here.seconds > 0.0 and found.done == 1.0
    (best,) = found.options
    assert best.choices["shape"] == {"kind": "QuadraticBSpline"} and "integrator" not in best.choices
    assert best.spacing == pytest.approx(1.0 / 26)  # 8 sqrt(10) = 25.3 cells, next even number: 1.5 m in whole cells, 1 m too
    assert best.error == pytest.approx((8 / 26) ** 2) and best.particles == 26 and best.seconds > 0.0
    text = " ".join(found.sentences())
    assert "Its error is likely about 1 (e; study 'made up', measured there): not enough for 0.1." in text
    assert "The cheapest for 0.1: QuadraticBSpline, MUSL with FLIP, 1 particle in a cell at cell size 0.0385 m" in text
    assert "How sure: fairly sure. The study 'made up' is alike in 100 %" in text


def test_an_error_that_no_composition_reaches(place):
    study({"Linear": 1.0}, loads=["TwoPointTraction", "Wall"]).save(place / "made-up.json")
    found = advising.advise("bar.toml", 1e-4, studies=["made-up.json"])
    assert found.options == []
    assert "No composition of the study 'made up' reaches 0.0001; its smallest error is 0.25." in " ".join(found.sentences())


def test_without_a_study_that_applies_it_says_so(place):
    found = advising.advise("bar.toml", "1%")
    assert found.study is None and found.sure == "not known"
    assert "No published study has an error of this kind" in found.sentences()[1]
    study({"Linear": 1.0}, space="3D", dim=3, contact=True, materials=["plastic"]).save(place / "made-up.json")
    lines = advising.advise("bar.toml", "1%", studies=["made-up.json"]).sentences()
    assert lines[1].startswith(
        "No published study is of a problem like this one, so nothing is known of its error. The nearest, 'made up', is alike in"
    )
    assert "3D, not 1D" in lines[1] and '"Finest"' in lines[2]


def test_a_long_run_is_predicted_from_a_part_of_it(place):
    found = advising.advise("bar.toml", "1%", until=1e4)
    assert 0.0 < found.done < 1.0
    assert found.here.steps == pytest.approx(
        1e4 / 0.0625, rel=0.1
    )  # rate: steps of half a cell at wave speed 1, and looks at the particles
    assert "% of the run" in found.sentences()[0]


def test_results_of_a_study_are_advice_for_its_own_scene(place):
    made = Study(bar(), {"shape": ["Linear", "GIMP"], "grid.spacing": [0.25, 0.125, 0.0625]}, errors=EXACT, repeat=0)
    made.run(place / "done", Here(), quiet=True)
    found = advising.advise("bar.toml", 0.5, studies=["done"])
    rows = StudyResults.load(place / "done").series(LABEL)["Linear"]
    assert found.likeness == 1.0 and found.here.error == pytest.approx(rows[1]["errors"][LABEL])
    assert all(row["travel"] < 0.1 for row in rows)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["bar.toml", "--error", "x"], "an asked error must be a number above zero"),
        (["baar.toml", "--error", "1%"], "did you mean 'bar.toml'?"),
        (["bar.toml", "--error", "1%", "--studies", "nowhere"], "there are no results of a study at nowhere"),
        (["bar.toml", "--error", "1%", "--studies", "."], "bar.json is no result of a study"),
        (["bar.toml", "--error", "1%", "--field", "v"], "no published study has errors of 'v'"),
    ],
)
def test_bad_input(place, capsys, arguments, message):
    (place / "bar.json").write_text("{}")
    with pytest.raises(SystemExit) as end:
        main(["advise", *arguments])
    assert end.value.code == 1
    assert message in capsys.readouterr().err


def test_the_command_prints_what_python_gets(place, capsys):
    study({"Linear": 0.5, "QuadraticBSpline": 2.0}, loads=["TwoPointTraction", "Wall"]).save(place / "made-up.json")
    with pytest.raises(SystemExit) as end:
        main(["advise", "bar.toml", "--error", "10%", "--studies", "made-up.json", "--quiet", "--json"])
    assert not end.value.code
    data = json.loads(capsys.readouterr().out)
    assert data["study"] == "made up" and data["options"][0]["choices"]["shape"] == {"kind": "QuadraticBSpline"}
    with pytest.raises(SystemExit):
        main(["advise", "bar.toml", "--error", "10%", "--studies", "made-up.json", "--quiet"])
    out = capsys.readouterr().out
    assert "- How sure: fairly sure." in out and "now" in out
