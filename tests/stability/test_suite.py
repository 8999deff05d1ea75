"""The machinery of the suite: verdicts, compositions, child processes, kept results, table and picture."""

from __future__ import annotations

import json
import math
import re

import attrs
import fake_cases as fake
import numpy as np
import pytest

import mpmkit as mpm
from mpmkit._core.composing.cautions import CAUTIONS
from mpmkit._core.registry import registry
from mpmkit.errors import ParameterError, PluginError
from mpmkit.integrators import MUSL, USL
from mpmkit.materials import NeoHookean
from mpmkit.shapes import Linear, QuadraticBSpline
from mpmkit.stability import Case, Composition, Figure, Verdict, compositions, matrix, pool, run, table
from mpmkit.stability.case import simulation
from mpmkit.stability.cases import cases
from mpmkit.stability.cases._tools import momentum_error
from mpmkit.stability.expected import EXPECTED, Expected, contradicted, explain
from mpmkit.stability.judge import judge
from mpmkit.stability.keeping import FILE, Kept, key
from mpmkit.stability.suite import verdict_data, verdict_of
from mpmkit.testing.flight import plain_python

DEFAULT = compositions.default()


# --- figures and verdicts ----------------------------------------------------------------------------------------
def test_margins():
    assert Figure("x", -0.5, 2.0).margin == 0.25
    assert Figure("x", 0.0, 0.0).margin == 0.0
    assert Figure("x", 1e-300, 0.0).margin == math.inf
    assert Figure("x", math.nan, 1.0).margin == math.inf
    assert Verdict("holds").margin is None


@pytest.mark.parametrize(
    ("measure", "status", "words"),
    [
        (fake.holds, "holds", ""),
        (fake.bounded, "bounded", "error is -2, the limit 1"),
        (fake.nan, "fails", "error is nan"),
        (fake.guard, "fails", "particle 3 of body 'a'"),
        (fake.refused, "refused", "these do not fit"),
        (fake.broken, "fails", "unexpected ZeroDivisionError: division by zero"),
    ],
)
def test_verdicts(measure, status, words):
    verdict = judge(fake.case(measure), DEFAULT)
    assert verdict.status == status
    assert words in verdict.reason


def test_a_verdict_names_no_file_of_the_machine():
    verdict = judge(fake.case(fake.stopped), DEFAULT)
    assert (verdict.status, verdict.reason) == ("fails", "energy was created")


def test_a_case_that_waits_is_not_run():
    assert judge(fake.WAITING, DEFAULT) == Verdict("waiting", reason="waits for a shock equation of state")


def test_verdicts_survive_json():
    verdict = Verdict("fails", (Figure("a", math.inf, 1.0), Figure("b", 0.25, 0.0)), "why", 0.5, None, ("one",))
    text = json.dumps(verdict_data(verdict), allow_nan=False)
    assert verdict_of(json.loads(text)) == verdict


def test_the_ledgers_of_a_case_are_watched():
    import mpmkit as mpm
    from mpmkit.materials import NeoHookean

    def measure(composition, quick):
        sim = simulation(composition, mpm.Grid(0.0, 2.0, 0.25))
        sim += mpm.Body(mpm.Box(0.5, 1.0), NeoHookean(E=1e4, nu=0.3, rho=1000.0), v=1.0)
        sim.run(until=0.1, quiet=True)
        return [Figure("anything", 0.0, 1.0)]

    def judged(composition):
        with plain_python():
            return judge(fake.case(measure), composition)

    plain = judged(DEFAULT)
    assert (plain.status, plain.reason, plain.cautions) == ("holds", "", ())
    assert plain.energy < 1e-12 and plain.momentum < 1e-12  # rounding: free flight
    # the same with an effect under test: what holds for every scene is judged in place of the case's own figures
    from mpmkit.effects import Damping

    added = judged(attrs.evolve(DEFAULT, extra=(Damping(rate=1.0),)))
    assert [f.name for f in added.figures] == ["energy made", "momentum error"]
    assert added.status == "holds"
    caution = next(one for one in CAUTIONS if one.name == "strains from raw velocities")
    raw = judged(attrs.evolve(DEFAULT, shape=Linear(), integrator=USL(limit=0.0)))
    assert raw.cautions == (caution.name,)


# --- compositions ------------------------------------------------------------------------------------------------
def test_published_compositions_have_every_component():
    found = compositions.published()
    shapes = {type(c.shape).__name__ for c in found}
    integrators = {type(c.integrator).__name__ for c in found}
    transfers = {type(c.integrator.transfer).__name__ for c in found}
    reg = registry()
    assert (shapes, integrators, transfers) == (set(reg.of("shape")), set(reg.of("integrator")), set(reg.of("transfer")))
    pairs = {(type(c.shape).__name__, type(c.integrator).__name__) for c in found}
    assert len(pairs) == len(shapes) * len(integrators)
    assert {c.precision for c in found} == {"float64", "float32"}
    assert None in {c.contact for c in found}
    assert found[0] == DEFAULT
    assert len({compositions.heading(c) for c in found}) == len(found)


def test_the_full_product_contains_what_is_published():
    everything = compositions.everything()
    assert all(c in everything for c in compositions.published())
    assert set(map(compositions.heading, compositions.quick())) <= set(map(compositions.heading, everything))


def test_a_component_takes_the_place_of_its_axis():
    usf = compositions.of_plugin("USF")
    assert {type(c.integrator).__name__ for c in usf} == {"USF"}
    assert {type(c.shape).__name__ for c in usf} == set(registry().of("shape"))
    law = compositions.of_plugin("VonMises")
    assert {type(c.material).__name__ for c in law} == {"VonMises"}
    gravity = compositions.of_plugin("Gravity", few=True)
    assert {type(c.extra[0]).__name__ for c in gravity} == {"Gravity"}
    contact = compositions.of_plugin("FrictionalContact", few=True)
    assert {type(c.contact).__name__ for c in contact} == {"FrictionalContact"}


def test_names_that_nothing_has():
    with pytest.raises(PluginError, match="did you mean 'FrictionalContact'"):
        compositions.of_plugin("FrictionalContakt")
    with pytest.raises(PluginError, match="the hard cases say nothing about FEM"):
        compositions.of_plugin("FEM")
    with pytest.raises(ParameterError, match="no hard case is named 'free-fligth'; did you mean 'free-flight'"):
        run(["free-fligth"])


def test_bodies_that_never_meet_need_no_contact():
    assert compositions.applied(fake.case(fake.holds), DEFAULT).contact is None
    assert compositions.applied(fake.case(fake.holds, contact=True), DEFAULT) == DEFAULT
    assert compositions.applied(fake.case(fake.holds, applies=lambda c: "says nothing"), DEFAULT) is None
    law = attrs.evolve(DEFAULT, material=object())
    assert compositions.applied(fake.case(fake.holds), law) is None
    assert compositions.applied(fake.case(fake.holds, material=True), law).material is law.material


# --- running -----------------------------------------------------------------------------------------------------
def test_crashes_and_time_limits_are_verdicts_and_the_rest_goes_on():
    measures = (fake.crash, fake.leaves, fake.never, fake.holds, fake.refused, fake.bounded)
    found = run([fake.case(m) for m in measures], [DEFAULT], jobs=2, timeout=4.0)
    verdicts = {c.case.name: c.verdict for c in found.cells}
    assert verdicts["crash"].status == "fails" and "signal 11 (SIGSEGV)" in verdicts["crash"].reason
    assert verdicts["leaves"].status == "fails" and "ended with status 7" in verdicts["leaves"].reason
    assert verdicts["never"].status == "fails" and "longer than 4 s" in verdicts["never"].reason
    assert [verdicts[n].status for n in ("holds", "refused", "bounded")] == ["holds", "refused", "bounded"]
    assert len(found.unexplained) == 4
    assert not found.passed


def test_processes_are_replaced_before_they_have_taken_all_memory(monkeypatch):
    monkeypatch.setattr(pool, "RENEWED", 2)
    many = [attrs.evolve(fake.case(fake.process), name=f"process {k}") for k in range(5)]
    processes = [c.verdict.figures[0].value for c in run(many, [DEFAULT], jobs=1).cells]
    assert [processes.count(p) for p in dict.fromkeys(processes)] == [2, 2, 1]


def test_a_case_that_cannot_be_sent_says_so():
    with pytest.raises(ParameterError, match="define its functions in a module, or run with jobs=0"):
        run([fake.case(lambda composition, quick: [])], [DEFAULT], jobs=1)


def test_results_are_kept_and_taken_again(tmp_path):
    one = fake.case(fake.holds)
    first = run([one], [DEFAULT], jobs=0, folder=tmp_path)
    assert first.passed
    lines = (tmp_path / FILE).read_text().splitlines()
    assert len(lines) == 1
    data = json.loads(lines[0])
    # another verdict under the same key is taken as it is: nothing runs again
    (tmp_path / FILE).write_text(json.dumps(data | {"status": "bounded"}) + "\n" + lines[0][:40])
    assert run([one], [DEFAULT], jobs=0, folder=tmp_path).cells[0].verdict.status == "bounded"
    # what an interruption has cut does not spoil what follows it
    run([one, fake.case(fake.bounded)], [DEFAULT], jobs=0, folder=tmp_path)
    assert len(Kept(tmp_path).verdicts) == 2


def test_the_key_knows_case_composition_and_quick():
    other = attrs.evolve(DEFAULT, precision="float32")
    one = fake.case(fake.holds)
    keys = [key(one, DEFAULT, True), key(one, DEFAULT, False), key(one, other, True), key(fake.case(fake.bounded), DEFAULT, True)]
    assert len(set(keys)) == 4
    assert key(one, compositions.default(), True) == keys[0]


# --- explanations ------------------------------------------------------------------------------------------------
def test_an_explanation_of_a_cell_that_holds_is_not_true(monkeypatch):
    rule = Expected(("holds", "bounded"), lambda c: c.precision == "float64", "theory says so", "do something else")
    monkeypatch.setattr("mpmkit.stability.expected.EXPECTED", (rule,))
    found = run([fake.case(fake.holds), fake.case(fake.bounded)], [DEFAULT, attrs.evolve(DEFAULT, precision="float32")], jobs=0)
    assert explain("bounded", DEFAULT, Verdict("bounded")).reason == "theory says so"
    assert explain("bounded", DEFAULT, Verdict("fails")) is None
    assert contradicted("bounded", DEFAULT, Verdict("bounded"), False) == ""
    assert len(found.contradicted) == 1 and "foretells bounded, but it holds" in found.contradicted[0]
    assert len(found.unexplained) == 1 and "float32" in found.unexplained[0]


def composed(shape, integrator, dim=2):
    import mpmkit as mpm
    from mpmkit.materials import NeoHookean

    sim = mpm.Simulation(mpm.Grid((0.0,) * dim, (1.0,) * dim, 0.25), shape, integrator)
    sim += mpm.Body(mpm.Box((0.25,) * dim, (0.5,) * dim), NeoHookean(E=1e4, nu=0.3, rho=1000.0))
    return sim


def test_explain_and_runs_warn_of_what_is_unstable():
    with plain_python(), pytest.warns(UserWarning, match=r"no bound as the weight goes to zero.* To fix: MUSL, USF, USL with its limit"):
        explanation = composed(Linear(), USL(limit=0.0)).explain()
    with plain_python():
        assert "warning: the recipe takes strains" in str(explanation)
        assert len(explanation.data["warnings"]) == 1
        for fine in (USL(), MUSL()):
            assert "warning:" not in str(composed(Linear(), fine).explain())
        assert "warning:" not in str(composed(QuadraticBSpline(), USL(limit=0.0)).explain())


def test_explain_notes_what_is_inaccurate():
    with plain_python():
        assert "note: strain='first-order' updates F" in str(composed(QuadraticBSpline(), MUSL(strain="first-order")).explain())
        assert "note: strain" not in str(composed(QuadraticBSpline(), MUSL(strain="midpoint")).explain())
        assert "note: strain" not in str(composed(QuadraticBSpline(), MUSL(strain="first-order"), dim=1).explain())  # nothing can turn


def test_explanations_name_cases_that_exist():
    named = {name for one in (*EXPECTED, *CAUTIONS) for name in getattr(one, "cases", getattr(one, "shown_by", ()))}
    assert named <= set(cases())


def test_every_caution_is_shown_by_a_case():
    for caution in CAUTIONS:
        assert caution.shown_by and caution.reason and caution.remedy


@pytest.mark.physics
@pytest.mark.parametrize("composition", compositions.studied(compositions.registered()), ids=lambda c: c.label)
def test_cautions_are_true(composition):
    """A case that a caution names does not hold under what it warns of."""
    caution = {"Linear": CAUTIONS[0], "QuadraticBSpline": CAUTIONS[1]}[type(composition.shape).__name__]
    for name in caution.shown_by:
        verdict = judge(cases()[name], compositions.applied(cases()[name], composition), quick=True)
        assert verdict.status == "fails", name
        assert verdict.cautions == (caution.name,)


# --- table and picture -------------------------------------------------------------------------------------------
def suite_data():
    found = run([fake.case(m) for m in (fake.holds, fake.bounded, fake.guard, fake.refused)], compositions.published(), jobs=0)
    return found.data()


def test_table_and_picture(tmp_path):
    from PIL import Image

    data = json.loads(json.dumps(suite_data(), allow_nan=False))
    page = table.page(data)
    for heading in ("# Hard cases", "## What does not hold, and why", "### Without an explanation", "## The cases", "## All cells"):
        assert f"{heading}\n" in page
    assert "error -2, limit 1" in page
    # cases whose bodies never meet have no cell for the column without contact
    assert len(data["cells"]) == 4 * (len(data["compositions"]) - 1)
    matrix.draw(data, tmp_path / "matrix.png")
    with Image.open(tmp_path / "matrix.png") as picture:
        assert picture.width > 800
        colours = {colour for _, colour in picture.convert("RGB").getcolors(100_000)}
    found = {"holds", "bounded", "fails"}
    wanted = {name: tuple(int(matrix.LOOKS[name][0][k : k + 2], 16) for k in (1, 3, 5)) for name in found}
    for name, colour in wanted.items():
        # pinned: a palette of 64 colours keeps large areas within a few steps of 255
        assert any(max(abs(a - b) for a, b in zip(colour, c, strict=True)) < 6 for c in colours), name


def test_panels_are_few_and_narrow():
    columns = [{"group": name} for name, size in (("a", 21), ("b", 3), ("c", 3), ("d", 3), ("e", 4)) for _ in range(size)]
    assert [len(p) for p in matrix._panels(columns)] == [21, 13]
    assert [len(p) for p in matrix._panels(columns[:4])] == [4]
    assert [len(p) for p in matrix._panels([{"group": "a"}] * 50)] == [17, 17, 16]


def test_what_is_beyond_a_limit_of_zero_is_not_a_failed_run():
    assert matrix.shown({"status": "bounded", "margin": "inf"}) == "∞"
    assert matrix.shown({"status": "fails", "margin": "inf"}) == "F"
    assert matrix.shown({"status": "fails", "margin": None}) == "F"


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0"), (1e-9, "0"), (0.043, ".04"), (0.7, ".70"), (1.0, "1"), (1.001, "1.1"), (24.2, "24"), (3.1e5, "3e5")]
)
def test_margins_in_few_characters(value, text):
    assert matrix.margin(value) == text


def test_grey_shows_the_picture_too():
    def grey(colour):
        return 0.299 * int(colour[1:3], 16) + 0.587 * int(colour[3:5], 16) + 0.114 * int(colour[5:7], 16)

    order = [grey(matrix.LOOKS[name][0]) for name in ("holds", "bounded", "fails")]
    assert order[0] > order[1] + 30 > order[2] + 60
    for name, (fill, ink, _) in matrix.LOOKS.items():
        assert abs(grey(fill) - grey(ink)) > 90, name


# --- the cases themselves ----------------------------------------------------------------------------------------
@pytest.mark.parametrize("case", cases().values(), ids=cases())
def test_cases_are_documented(case: Case):
    assert re.fullmatch(r"[a-z0-9]+(-[a-z0-9]+)*", case.name)
    for text in (case.title, case.failure, case.criterion, case.source):
        assert len(text) > 8
    assert case.dim in (1, 2, 3)
    assert isinstance(DEFAULT, Composition)


def test_the_momentum_of_rings_counts_along_the_axis_only():
    """A ring that is let go when stretched flies inwards: what all sides have in common is zero, and so is what the suite calls an error."""
    with plain_python():
        rings = mpm.Simulation(
            mpm.Grid((0.5, 0.0), (2.5, 2.0), 0.25, coordinates="axisymmetric"), shape=QuadraticBSpline(), integrator=MUSL()
        )
        F = np.diag([1.0, 1.0, 1.2])
        rings += mpm.Body(mpm.Box((0.75, 0.75), (1.0, 1.0)), NeoHookean(E=1.0, nu=0.0, rho=1.0), F=F, name="ring")
        rings.run(until=0.5, quiet=True)
    change = rings.history["momentum_x"] - rings.history["impulse_x"]
    assert np.abs(change).max() > 1e-2 * rings.history["mass"][0]
    assert momentum_error(rings, 1.0) < 1e-14
