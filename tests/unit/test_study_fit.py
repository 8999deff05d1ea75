from __future__ import annotations

import numpy as np
import pytest
from small_study import STRESS, results

from mpmkit.studies import fit

EPS = float(np.finfo(float).eps)


def rows(h, e, seconds=None):
    seconds = seconds or [None] * len(h)
    return [{"composition": "one", "resolution": a, "errors": {"e": b}, "seconds": s} for a, b, s in zip(h, e, seconds, strict=True)]


def test_a_power_law_has_its_order_and_no_spread():
    found = fit.line([1.0, 0.5, 0.25, 0.125], [3.0 * x**2 for x in (1.0, 0.5, 0.25, 0.125)])
    for value in (found.slope, found.low, found.high):
        assert value == pytest.approx(2.0, abs=32 * EPS)  # rounding of logarithms up to 3
    assert found.constant == pytest.approx(3.0, rel=32 * EPS) and found.at(2.0) == pytest.approx(12.0, rel=64 * EPS)


def test_the_interval_is_that_of_linear_regression():
    from scipy.stats import linregress
    from scipy.stats import t as student

    x, y = [1.0, 0.5, 0.25, 0.125], [1.1, 0.45, 0.27, 0.11]
    other = linregress(np.log(x), np.log(y))
    half = student.ppf(0.975, 2) * other.stderr
    found = fit.line(x, y)
    assert found.slope == pytest.approx(other.slope, rel=64 * EPS)
    assert found.high - found.slope == pytest.approx(half, rel=1e4 * EPS)  # residuals are a hundredth of the values
    assert found.low + found.high == pytest.approx(2.0 * found.slope, rel=64 * EPS)


def test_the_interval_holds_the_order_as_often_as_it_says():
    random = np.random.default_rng(5)
    x = 0.5 ** np.arange(4)
    inside = 0
    for _ in range(400):
        found = fit.line(x, x**1.5 * np.exp(0.1 * random.standard_normal(4)))
        inside += found.low < 1.5 < found.high
    assert 0.92 < inside / 400 < 0.98  # 95 % with three standard deviations of 400 draws


@pytest.mark.parametrize("h", [[1.0, 0.5], [1.0, 1.0, 0.5], [1.0, 0.5, 0.0]])
def test_two_resolutions_are_no_order(h):
    assert fit.line(h, [1.0] * len(h)) is None


def test_orders_of_a_study_leave_out_what_has_stalled():
    found = fit.orders(results(), STRESS)
    assert found["Linear"].slope == pytest.approx(1.0, abs=32 * EPS) and found["Linear"].finest == 0.025
    assert found["GIMP"].slope == pytest.approx(2.0, abs=32 * EPS)
    assert found["QuadraticBSpline"].slope == pytest.approx(3.0, abs=64 * EPS)


@pytest.mark.parametrize(
    ("errors", "where"),
    [
        ([0.1, 0.05, 0.025, 0.02], 0.25),
        ([0.1, 0.01, 0.02, 0.03], 0.5),
        ([0.1, 0.1, 0.1, 0.1], 1.0),
        ([0.1, 0.05, 0.04, 0.03], None),
        ([0.1, 0.05, 0.025, 0.0125], None),
        ([0.1, 0.06, 0.03, 0.01], None),
        ([0.1, 0.07, 0.05, 0.035], None),
    ],
)
def test_where_refining_stops_helping(errors, where):
    found = fit.stall(rows([1.0, 0.5, 0.25, 0.125], errors), "e")
    assert (found and found.resolution) == where


def test_the_front_has_what_nothing_else_beats():
    found = [row["label"] for row in fit.front(results(), STRESS)]
    spline = [f"QuadraticBSpline, {h:g}" for h in (0.05, 0.025, 0.0125)]
    assert found == ["Linear, 0.1", "GIMP, 0.1", "GIMP, 0.05", *spline]  # GIMP, 0.025 is slower than the spline at 0.05, and worse


def test_a_digit_more_costs_what_order_and_work_say():
    series = results().series(STRESS)
    price = fit.next_digit(series["GIMP"], STRESS)
    assert price.factor == pytest.approx(10.0, rel=1e-9)  # work h^-2, error h^2
    assert price.low <= price.factor <= price.high
    assert fit.next_digit(series["QuadraticBSpline"], STRESS).factor == pytest.approx(10 ** (2 / 3), rel=1e-9)
    assert fit.next_digit(rows([1.0, 0.5, 0.25], [0.1, 0.1, 0.1], [1.0, 2.0, 4.0]), "e") is None


def test_the_cheapest_row_of_each_composition_with_an_error():
    found = fit.cheapest(results(), STRESS, 0.01)
    assert [row["label"] for row in found] == ["GIMP, 0.1", "QuadraticBSpline, 0.05"]
    assert fit.cheapest(results(), STRESS, 1e-9) == []
