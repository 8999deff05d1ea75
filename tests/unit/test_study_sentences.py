from __future__ import annotations

import pytest
from small_study import ENDS, STRESS, results

import mpmkit as mpm
from mpmkit.studies import sentences
from mpmkit.studies.numbers import exponent, joined, number, quantity, seconds
from mpmkit.studies.results import StudyResults


def said(found=None, title=STRESS, **more):
    return sentences.sections(found or results(), **more)[title]


def changed(change):
    """The made-up study with every row changed."""
    made = results()
    return StudyResults([row | change(row) for row in made], made.meta)


def test_the_cheapest_composition_for_an_asked_error():
    lines = said(asked=["1%"])
    assert lines[0] == (
        "For an error of 0.01 Pa the cheapest is GIMP at spacing 0.1 m: 0.01 Pa in 1.5 ms; the next, QuadraticBSpline at spacing 0.05 m, "
        "takes 5.3 times as long."
    )
    assert "Linear does not reach 0.01 Pa with the resolutions of this study; its smallest error is 0.02 Pa." in lines


def test_levels_are_powers_of_ten_that_somebody_reaches():
    lines = [line for line in said() if line.startswith("For ")]
    assert [line.split(" Pa")[0].removeprefix("For an error of ") for line in lines] == ["0.1", "0.01", "0.001", "0.0001", "1e-5"]
    assert lines[-1].endswith("no other composition reaches it.")
    assert said(asked=[1e-9])[0] == "No run has an error of 1e-9 Pa or less."


def test_a_narrow_study_is_asked_in_finer_steps():
    lines = said(changed(lambda row: {"errors": {STRESS: 1.0 + row["resolution"]} if row["errors"] else {}}))
    assert lines[0].startswith("For an error of 2 Pa the cheapest is Linear at spacing 0.1 m")


def test_times_within_their_spread_are_called_the_same():
    lines = said(changed(lambda row: {"seconds_low": 1e-4} if row["seconds"] else {}), asked=[0.1])
    assert "GIMP at spacing 0.1 m takes the same within the spread of the times (1.5 ms)." in lines[0]


def test_orders_and_the_price_of_the_next_digit():
    lines = said()
    assert (
        "GIMP: observed order 2.00 (95% between 2.00 and 2.00, 3 resolutions); the next digit costs 10 times the time (10 to 10)." in lines
    )


def test_where_finer_cells_stop_helping_and_whether_cell_crossing_is_to_blame():
    start = "Linear: finer than spacing 0.025 m hardly helps (error 0.025 Pa there, 0.02 Pa at 0.0125 m, order 0.32 after 1.00)"
    assert f"{start}." in said()
    crossing = said(changed(lambda row: {"travel": 3.0}))
    assert (
        f"{start}; particles move up to 3 cells there, so they cross cells, which QuadraticBSpline does not mind (order 3.00)." in crossing
    )
    assert f"{start}; particles stayed in their cells whenever errors were taken, so crossing cells is hardly the reason." in said(
        changed(lambda row: {"travel": 0.1})
    )


def test_an_error_that_grows_is_never_reached():
    def grows(row):
        return {"errors": {STRESS: 0.1 / row["resolution"]}} if row["composition"] == "Linear" else {}

    lines = said(changed(grows), asked=[0.5])
    assert "Linear never reaches 0.5 Pa; its smallest error is 1 Pa." in lines
    assert any(line.startswith("Linear: finer than spacing 0.1 m makes it worse") for line in lines)


def test_more_particles_in_a_cell():
    rows = [
        {"label": f"{n}", "composition": f"ppc={n}", "choices": {"bodies.*.particles_per_cell": n}, "labels": {"bodies.*.particles_per_cell": f"{n}"},
         "resolution": 0.1, "errors": {"e": e}, "seconds": 0.1 * n, "seconds_low": 0.1 * n, "seconds_high": 0.1 * n}
        for n, e in ((1, 0.3), (4, 0.1), (9, 0.095))
    ]  # fmt: skip
    lines = said(StudyResults(rows, {"errors": [{"label": "e", "unit": "1"}]}), "e")
    assert "more than 4 particles in a cell do not help (error 0.1, 0.095 with 9, which takes 2.2 times as long)." in lines
    rows[2]["errors"] = {"e": 0.01}
    lines = said(StudyResults(rows, {"errors": [{"label": "e", "unit": "1"}]}), "e")
    assert "more particles in a cell still help at 9 (error 0.1 with 4, 0.01 with that)." in lines


def test_runs_that_did_not_end_well_are_named_with_the_reason():
    lines = said(title=sentences.RUNS)
    assert lines[0] == "GIMP, 0.0125 blew up: energy was created: 0.6 times the largest energy of the run, at step 812."
    assert lines[1] == "QuadraticBSpline, 0.1 was refused: QuadraticBSpline needs at least 12 cells, the grid has 10."


def test_noisy_times_and_missing_runs_are_told():
    found = changed(lambda row: {"seconds_high": 2.0 * row["seconds"]} if row["seconds"] else {})
    found.meta["complete"] = False
    lines = said(found, sentences.RUNS)
    assert "spread by more than" in lines[-2] and lines[-1] == "The study was interrupted; runs are missing."


def test_problems_are_not_compared_with_each_other():
    made = results()
    rows = [
        row | {"problem": p, "composition": f"{p}, {row['composition']}", "label": f"{p}, {row['label']}"}
        for p in ("A=1", "A=2")
        for row in made
    ]
    found = sentences.sections(StudyResults(rows, made.meta))
    assert f"{STRESS}, A=1" in found and STRESS not in found
    assert found[f"{STRESS}, A=2"] == said() and found[f"{ENDS}, A=1"] == said(title=ENDS)


@pytest.mark.parametrize("text", ["0", "-1%", "much", "nan", float("inf")])
def test_asked_errors_that_cannot_be(text):
    with pytest.raises(mpm.ParameterError, match="an asked error must be a number above zero or a percentage"):
        results().sentences([text])


def test_numbers_read_well():
    assert [number(v) for v in (0.0025, 1e-5, 340.4, 12345.6, 0.0, None)] == ["0.0025", "1e-5", "340", "12000", "0", ""]
    assert (quantity(0.006, "s"), quantity(0.25, "1"), seconds(300.0), seconds(8000.0)) == ("6 ms", "0.25", "5 min", "2.2 h")
    assert (exponent(1.234), exponent(-400.0)) == ("1.23", "-∞")
    assert joined(["a", "b", "c"]) == "a, b and c"
