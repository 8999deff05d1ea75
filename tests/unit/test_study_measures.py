from __future__ import annotations

import numpy as np
import pytest
from small_study import EXACT, bar

import mpmkit as mpm
from mpmkit.exact import AxisAligned, BarImpact, ForcedBar, ThickCylinder, VibratingBar
from mpmkit.exact import Step as SuddenLoad
from mpmkit.studies import Exact, Finest, Quantity, Study, measures, quantities, solutions
from mpmkit.studies.norms import norm
from mpmkit.studies.samples import Sample

EPS = float(np.finfo(float).eps)
FORCED = ForcedBar(L=1.0, E=1.0, rho=1.0, right=SuddenLoad(1.0))


def line(n, t, *, dt=0.0, solution=None, shift=0.0):
    """A bar of n particles that has the exact fields of a solution, velocities those of a time `shift` later."""
    x = (np.arange(n) + 0.5) / n
    start = {"bar": x[:, None]}
    fields = {"x": x[:, None], "V0": np.full(n, 1.0 / n), "v": np.zeros((n, 1)), "stress": np.zeros((n, 6)), "m": np.full(n, 1.0 / n)}
    if solution is not None:
        fields["x"] = x[:, None] + solution.displacement(x, t)[:, None]
        fields["v"] = solution.velocity(x, t + shift)[:, None]
        fields["stress"][:, 0] = solution.stress(x, t)
    return Sample(t, dt, "1D", start, {"bar": fields})


@pytest.mark.parametrize(("kind", "expected"), [("L1", 1.75), ("L2", np.sqrt(4.75)), ("max", 3.0)])
def test_norms_are_weighted_means(kind, expected):
    sizes, weights = [np.array([1.0, 3.0]), np.array([2.0, 0.5])], [np.array([2.0, 2.0]), np.array([2.0, 2.0])]
    expected = {"L1": 1.625, "L2": np.sqrt(14.25 / 4), "max": 3.0}[kind]
    assert norm(kind, "all", sizes, weights) == pytest.approx(expected, rel=4 * EPS)
    assert norm("L1", "largest", sizes, weights) == 2.0
    assert norm("L1", "all", [np.array([1.0, 3.0])], [np.array([3.0, 1.0])]) == 1.5


@pytest.mark.parametrize("field", ["u", "u.x", "x", "v", "stress", "stress.xx"])
def test_the_exact_fields_have_no_error(field):
    solution = VibratingBar(L=1.0, E=1.0, rho=1.0, v0=0.1)
    measure = Exact(solution=solution, field=field, norm="max")
    evaluator = solutions.Evaluator(solution, (0.0,), 0, "1D")
    found = [line(8, t, solution=solution) for t in (0.0, 0.3, 0.7)]
    assert measure.value(found, 0.7, evaluator, False) < 8 * EPS


def test_velocities_of_half_steps_are_compared_there():
    solution, dt = VibratingBar(L=1.0, E=1.0, rho=1.0, v0=0.1), 0.1
    measure = Exact(solution=solution, field="v", norm="max")
    evaluator = solutions.Evaluator(solution, (0.0,), 0, "1D")
    found = [line(8, 0.5, dt=dt, solution=solution, shift=-0.5 * dt)]
    assert measure.value(found, 0.5, evaluator, True) < 8 * EPS
    assert measure.value(found, 0.5, evaluator, False) > 1e-3


def test_manufactured_solutions_and_radial_components():
    waves = AxisAligned(A=0.05)
    X = np.array([[0.2, 0.3], [0.6, 0.9]])
    fields = {"x": waves.position(X, 1e-3), "F": waves.F(X, 1e-3).reshape(-1, 9), "V0": np.ones(2)}
    sample = Sample(1e-3, 0.0, "plane strain", {"b": X}, {"b": fields})
    evaluator = solutions.Evaluator(waves, (0.0,), 0, "plane strain")
    for field in ("u", "u.y", "F", "F.yy"):
        assert Exact(solution=waves, field=field, norm="max").value([sample], 1e-3, evaluator, False) < 8 * EPS
    ring = ThickCylinder(a=1.0, b=2.0, pressure=1.0, E=1000.0, nu=0.3)
    X = np.array([[1.5, 0.0], [0.0, 1.5], [-1.2, 0.9]])
    n = X / 1.5
    radial, around = ring.stress_r(1.5), ring.stress_theta(1.5)
    stress = np.zeros((3, 6))
    for k, (a, b) in {0: (0, 0), 1: (1, 1), 3: (0, 1)}.items():
        m = np.stack([-n[:, 1], n[:, 0]], axis=1)
        stress[:, k] = radial * n[:, a] * n[:, b] + around * m[:, a] * m[:, b]
    sample = Sample(0.0, 0.0, "plane strain", {"b": X}, {"b": {"x": X + ring.displacement(1.5) * n, "stress": stress, "V0": np.ones(3)}})
    evaluator = solutions.Evaluator(ring, (0.0,), 0, "plane strain")
    for field in ("u.r", "stress.rr", "stress.tt"):
        assert Exact(solution=ring, field=field, norm="max").value([sample], 0.0, evaluator, False) < 16 * EPS


def test_relative_scaled_and_in_a_region():
    solution = VibratingBar(L=1.0, E=1.0, rho=1.0, v0=0.1)
    evaluator = solutions.Evaluator(solution, (0.0,), 0, "1D")
    found = [line(8, 0.0, solution=None), line(8, 0.5, solution=None)]
    still = Exact(solution=solution, field="v", relative=True)
    assert still.value(found, 0.5, evaluator, False) == pytest.approx(1.0, rel=8 * EPS)
    largest = Exact(solution=solution, field="v", norm="max").value(found, 0.5, evaluator, False)
    assert Exact(solution=solution, field="v", norm="max", scale=0.1).value(found, 0.5, evaluator, False) == pytest.approx(10 * largest)
    left = Exact(solution=solution, field="v", norm="max", region=mpm.Box(0.0, 0.5))
    assert left.value(found, 0.5, evaluator, False) < 0.75 * largest
    with pytest.raises(mpm.ParameterError, match="no particle starts inside the region"):
        Exact(solution=solution, field="v", region=mpm.Box(2.0, 3.0)).value(found, 0.5, evaluator, False)


def test_the_finest_run_is_interpolated():
    measure = Finest(field="v.x", norm="max")
    fine, coarse = line(40, 1.0), line(8, 1.0)
    for sample in (fine, coarse):
        sample.bodies["bar"]["v"][:, 0] = 3.0 + 2.0 * sample.start["bar"][:, 0]  # linear, so interpolation is exact
    assert measure.compare(measure.arrays([coarse], 1.0), measure.arrays([fine], 1.0)) < 16 * EPS
    coarse.bodies["bar"]["v"][3] += 0.5
    assert measure.compare(measure.arrays([coarse], 1.0), measure.arrays([fine], 1.0)) == pytest.approx(0.5, rel=32 * EPS)


def facts(**history):
    samples = [line(4, 0.0), line(4, 1.0)]
    samples[0].bodies["bar"]["v"][:] = -2.0
    samples[1].bodies["bar"]["v"][:] = 1.0
    samples[1].bodies["bar"]["x"][:] = 0.3 + 2.0 * samples[1].bodies["bar"]["x"]
    return quantities.Facts(history, samples, ("bar",), 0)


def test_quantities_of_a_bar():
    library = quantities.LIBRARY
    assert library["restitution"].compute(facts()) == 0.5
    assert library["final length"].compute(facts()) == pytest.approx(2.0, rel=8 * EPS)
    assert library["run-out"].compute(facts()) == pytest.approx(0.3 + 0.875, rel=8 * EPS)
    t = np.linspace(0.0, 10.0, 201)
    swing = facts(t=t, momentum_x=np.cos(2.0 * t))
    assert library["period"].compute(swing) == pytest.approx(np.pi, rel=1e-5)  # rate: cubic splines, h^4 = 6e-6
    with pytest.raises(mpm.ParameterError, match="changes its sign less than twice"):
        library["period"].compute(facts(t=t, momentum_x=1.0 + t))


def test_restitution_of_two_bodies_is_along_the_line_of_centres():
    samples = [line(4, 0.0), line(4, 1.0)]
    for sample, (va, vb) in zip(samples, ((1.0, -1.0), (-0.25, 0.25)), strict=True):
        other = {k: v.copy() for k, v in sample.bodies["bar"].items()} | {"x": sample.bodies["bar"]["x"] + 2.0}
        sample.bodies["bar"]["v"][:] = va
        other["v"][:] = vb
        sample.bodies["other"] = other
    assert quantities.LIBRARY["restitution"].compute(quantities.Facts({}, samples, ("bar", "other"), 0)) == 0.25


def test_labels_say_norm_and_unit():
    assert Exact(solution=FORCED, field="stress.xx", norm="L1").label == "stress.xx, L1 [Pa]"
    assert Exact(solution=FORCED, field="displacement", relative=True).label == "u, relative L2"
    assert Exact(solution=FORCED, field="v", scale=2.0, norm="max").label == "v, max [2 m/s]"
    assert Finest(field="v.x").label == "v.x, L2 from the finest [m/s]"
    assert Quantity(quantity="period", exact=1.0).label == "period, error [s]"
    assert Quantity(quantity="energy drift").label == "energy drift, error"
    assert Quantity(quantity="kinetic", exact=1.0, relative=True, name="mine").label == "mine"


def test_a_table_says_the_same_as_the_object():
    for measure in (
        Exact(solution=FORCED, field="v.x", times=[0.1, "200 ms"], bodies="bar", region=mpm.Box(0.0, 0.5)),
        Finest(field="stress", norm="max", times=5, reference="best"),
        Quantity(quantity="restitution", exact={"solution": BarImpact(V0=0.1, L=0.5, gap=0.5, E=1e4, rho=1.0), "attribute": "restitution"}),
        Quantity(quantity="kinetic", exact=2.0, relative=True),
    ):
        assert measures.read(measure.plain()).plain() == measure.plain()
    assert Exact(solution=FORCED, field="v", times=[0.1, "200 ms"]).times == (0.1, 0.2)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"kind": "Exakt"}, "no error measure is named 'Exakt'; did you mean 'Exact'?"),
        ({"kind": "Exact", "field": "v"}, "Exact needs solution"),
        (EXACT | {"norn": "L1"}, "Exact has no parameter 'norn'; did you mean 'norm'?"),
        (EXACT | {"norm": "L3"}, "norm must be one of L1, L2, max, got 'L3'"),
        (EXACT | {"field": "stres"}, "no field is named 'stres'; did you mean 'stress'?"),
        (EXACT | {"field": "stress.xw"}, "stress has no component 'xw'"),
        (EXACT | {"field": "F"}, "the exact solution ForcedBar has no F"),
        (EXACT | {"times": []}, "times is empty"),
        (EXACT | {"times": [-1.0]}, "times must be >= 0"),
        (EXACT | {"relative": True}, "scale must be > 0, and not be given together with relative"),
        (EXACT | {"solution": {"kind": "ForcdBar"}}, "no exact solution is named 'ForcdBar'; did you mean 'ForcedBar'?"),
        (EXACT | {"solution": {"kind": "ForcedBar", "l": 1.0}}, "ForcedBar has no parameter 'l'; did you mean 'L'?"),
        (EXACT | {"solution": {"kind": "Interface"}, "field": "v"}, "it gives no fields at points; compare a Quantity"),
        (EXACT | {"solution": 3}, "solution must be a table"),
        ({"kind": "Quantity", "quantity": "restituton"}, "no quantity is named 'restituton'; did you mean 'restitution'?"),
        ({"kind": "Quantity", "quantity": "restitution"}, r"Quantity\('restitution'\) needs its exact value"),
        ({"field": "v"}, "an error measure is a table"),
    ],
)
def test_measures_that_cannot_be(table, message):
    with pytest.raises(mpm.ParameterError, match=message):
        measures.read(table)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"solution": {"kind": "ForcedBar", "L": 0.5}}, "ForcedBar has no exact values for body 'bar' of this scene: .* must lie in"),
        ({"solution": {"kind": "AxisAligned"}, "field": "u"}, "AxisAligned has no exact values for body 'bar' of this scene"),
        ({"bodies": ["bra"]}, "no body is named 'bra'"),
        ({"times": [2.0]}, "errors are asked for at 2 s, but the run ends at 0.75 s"),
    ],
)
def test_a_measure_that_does_not_fit_the_scene_is_refused_before_any_run(changed, message):
    with pytest.raises(mpm.ParameterError, match=message):
        Study(bar(), {"grid.spacing": [0.125]}, errors=EXACT | changed).plan()


def test_parameters_of_the_material_are_those_of_the_body():
    sim = mpm.scene.loads(__import__("json").dumps(bar()), format="json")
    solution, notes = solutions.build(EXACT["solution"], sim, {}, ".", ())
    assert (solution.E, solution.rho) == (1.0, 1.0) and not notes
    _, notes = solutions.build(EXACT["solution"] | {"rho": 2.0}, sim, {}, ".", ())
    assert notes == ["the exact solution has rho = 2, the material 1"]
