from __future__ import annotations

import json
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import study_functions
from small_study import EXACT, Here, bar

import mpmkit as mpm
from mpmkit.exact import ForcedBar
from mpmkit.exact import Step as SuddenLoad
from mpmkit.studies import Finest, Quantity, Study, child, cost, store
from mpmkit.studies.results import StudyResults

pytestmark = pytest.mark.usefixtures("plain_python")
EPS = float(np.finfo(float).eps)
LABEL = "stress.xx, L1 [0.001 Pa]"


def study(axes=None, errors=EXACT, **more):
    return Study(more.pop("scene", bar()), axes or {"grid.spacing": [0.25, 0.125]}, errors=errors, repeat=more.pop("repeat", 0), **more)


def test_errors_are_those_of_the_same_run_by_hand(tmp_path):
    results = study().run(tmp_path, Here(), quiet=True)
    for row in results:
        sim = mpm.scene.loads(json.dumps(bar(round(1.0 / row["resolution"]))), format="json")
        X = sim.particles("bar")["x"][:, 0]
        sim.run(quiet=True)
        exact = ForcedBar(L=1.0, E=1.0, rho=1.0, right=SuddenLoad(1.0)).stress(X, 0.75)
        wrong = np.abs(sim.particles("bar")["stress"][:, 0] / 1e-3 - exact).mean()
        assert row["status"] == "done" and row["errors"][LABEL] == pytest.approx(wrong, rel=8 * EPS)
        assert (row["steps"], row["particles"]) == (sim.step_number, len(X))
        assert row["seconds"] is None
    assert results.meta["complete"] and results.meta["errors"] == [{"label": LABEL, "unit": "1"}]


def test_what_is_there_is_not_done_again(tmp_path):
    first, again, more = Here(), Here(), Here()
    before = study().run(tmp_path, first, quiet=True)
    after = study().run(tmp_path, again, quiet=True)
    assert (first.done, again.done) == (2, 0)
    assert after.table() == before.table()
    study({"grid.spacing": [0.5, 0.25, 0.125]}).run(tmp_path, more, quiet=True)
    assert more.done == 1
    changed = Here()
    study(errors=EXACT | {"norm": "max"}).run(tmp_path, changed, quiet=True)
    assert changed.done == 2


def test_what_is_there_counts_only_within_the_budgets_of_now(tmp_path):
    study().run(tmp_path, Here(), quiet=True)
    results = study(memory_budget="1 MB", time_budget=1e-9).run(tmp_path, Here(), quiet=True)
    assert {row["status"] for row in results} == {"over budget"}
    assert "1 MB are allowed" in results.rows[0]["reason"]
    results = study(time_budget=1e-9).run(tmp_path, Here(), quiet=True)
    assert "1e-09 s are allowed" in results.rows[0]["reason"]


def test_an_interrupted_study_goes_on_where_it_was(tmp_path):
    one = study({"grid.spacing": [0.5, 0.25, 0.125]})
    with pytest.raises(KeyboardInterrupt):
        one.run(tmp_path, Interrupting(), quiet=True)
    partial = StudyResults.load(tmp_path)
    assert not partial.meta["complete"] and len(partial) == 1
    with open(tmp_path / store.LINES, "a") as file:
        file.write('{"kind": "errors", "key')  # killed while it wrote
    rest = Here()
    assert len(one.run(tmp_path, rest, quiet=True).done()) == 3
    assert rest.done == 2


class Interrupting(Here):
    """Ctrl-C while the second job runs."""

    def submit(self, function, job):
        if self.done < 1:
            return super().submit(function, job)
        return Pending()


class Pending:
    """A job that is interrupted when somebody looks at it the second time."""

    looked = 0

    def done(self):
        Pending.looked += 1
        if Pending.looked > 2:
            raise KeyboardInterrupt
        return False

    def cancel(self):
        return True


def test_results_of_other_versions_are_done_again_and_that_is_said(tmp_path, capsys):
    study().run(tmp_path, Here(), quiet=True)
    path = tmp_path / store.LINES
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    path.write_text("".join(json.dumps(line | {"sources": "other", "versions": "mpmkit 0.0.1"}) + "\n" for line in lines))
    again = Here()
    results = study().run(tmp_path, again, quiet=False)
    assert again.done == 2
    assert "do not count, and are done again (mpmkit 0.0.1)" in results.meta["notes"][0]
    assert "do not count" in capsys.readouterr().err


def test_runs_that_do_not_end_well_are_rows_with_a_reason(tmp_path):
    results = study({"integrator.dt": [0.05, 10.0], "bodies.*.particles_per_cell": [1, 0]}).run(tmp_path, Here(), quiet=True)
    ends = {row["label"]: (row["status"], row["reason"]) for row in results}
    assert ends["dt=0.05, particles_per_cell=1"][0] == "done"
    assert ends["dt=10, particles_per_cell=1"][0] == "unstable"
    assert "is above the stable limit" in ends["dt=10, particles_per_cell=1"][1]
    assert ends["dt=0.05, particles_per_cell=0"][0] == "refused"
    assert "particles_per_cell" in ends["dt=0.05, particles_per_cell=0"][1]


def test_a_study_of_refused_runs_says_so(tmp_path):
    with pytest.raises(mpm.CompositionError, match="all runs of the study are refused:\n  particles_per_cell=0: .*particles_per_cell"):
        study({"bodies.*.particles_per_cell": [0]}).run(tmp_path, Here(), quiet=True)


def test_a_run_that_needs_too_much_memory_is_not_started(tmp_path):
    with pytest.raises(mpm.CompositionError, match="it needs about .* of memory, 500 B are allowed"):
        study(memory_budget="500 B").run(tmp_path, Here(), quiet=True)


def test_a_function_makes_the_scene_and_velocities_start_half_a_step_before(tmp_path):
    error = {"kind": "Exact", "solution": f"{study_functions.__file__}:solution", "field": "v", "norm": "L2", "relative": True}
    axes = {"N": [8, 16], "shape": [mpm.shapes.QuadraticBSpline()]}
    staggered = study(axes, error, scene=study_functions.swinging).run(tmp_path, Here(), quiet=True)
    plain = study(axes, error, scene=study_functions.swinging, startup="as given").run(tmp_path, Here(), quiet=True)
    errors = [[row["errors"]["v, relative L2"] for row in results] for results in (staggered, plain)]
    assert errors[0][0] / errors[0][1] > 3.5  # rate: second order
    assert errors[1][0] / errors[1][1] < 2.5  # rate: first order
    assert [row["composition"] for row in staggered] == ["QuadraticBSpline"] * 2
    other = study(axes | {"shift": [True]}, error, scene=study_functions.swinging).run(tmp_path, Here(), quiet=True)
    assert "velocities are compared as they are: the scene does not start with those of the exact solution" in other.rows[0]["notes"]


def test_a_function_that_raises_is_one_failed_point(tmp_path):
    results = study({"N": [8, 9]}, Quantity(quantity="energy drift"), scene=study_functions.broken).run(tmp_path, Here(), quiet=True)
    assert [row["status"] for row in results] == ["done", "failed"]
    assert results.rows[1]["reason"] == "RuntimeError: odd"


@pytest.mark.parametrize(
    ("scene", "axes", "message"),
    [
        (study_functions.swinging, {"M": [8]}, "swinging has no argument 'M'"),
        (study_functions.swinging, {"shap": [8]}, "did you mean 'shape'?"),
        (lambda N: None, {"N": [8]}, "cannot be found by another process"),
        ("study_functions.py:nothing", {"N": [8]}, "cannot import 'study_functions.py:nothing'"),
        (3, {}, "Study.scene must be a scene file, a table, a Simulation, or a function"),
    ],
)
def test_functions_that_cannot_be(scene, axes, message):
    with pytest.raises(mpm.ParameterError, match=message):
        Study(scene, axes, errors=EXACT)


def test_a_simulation_with_functions_needs_a_function():
    with pytest.raises(mpm.ParameterError, match=r"cannot be written as a scene .* give a function make\(\*\*choices\)"):
        Study(study_functions.swinging(), {"grid.spacing": [0.1]}, errors=EXACT)


def test_against_the_finest_run_and_a_named_one(tmp_path):
    runs = [{"name": "best", "set": {"grid.spacing": 0.0625}}]
    errors = [Finest(field="u.x", relative=True), Finest(field="u.x", relative=True, reference="best", name="from best")]
    results = study({"grid.spacing": [0.25, 0.125]}, errors, runs=runs).run(tmp_path, Here(), quiet=True)
    coarse, fine, best = results.rows
    label = errors[0].label
    assert 0.0 < coarse["errors"][label] < 1.0 and label not in fine["errors"]
    assert coarse["errors"]["from best"] > fine["errors"]["from best"] > 0.0
    assert best["errors"] == {}
    again = Here()
    assert study({"grid.spacing": [0.25, 0.125]}, errors, runs=runs).run(tmp_path, again, quiet=True).table() == results.table()
    assert again.done == 0


def test_quantities_and_functions_of_ones_own(tmp_path):
    right = {"solution": {"kind": "VibratingBar", "L": 1.0, "E": 1.0, "rho": 1.0, "v0": 1e-3}, "attribute": "energy"}
    errors = [
        Quantity(quantity=study_functions.tip, exact=0.0, unit="m"),
        Quantity(quantity="energy drift"),
        Quantity(quantity="energy", exact=right, relative=True, name="energy"),
    ]
    (row,) = study({"N": [8]}, errors, scene=study_functions.swinging).run(tmp_path, Here(), quiet=True)
    assert 0.0 < row["errors"]["tip, error [m]"] < 1e-3
    assert row["values"]["tip, error [m]"] == row["errors"]["tip, error [m]"]
    assert row["errors"]["energy drift, error"] < 0.05 and row["errors"]["energy"] < 0.05


def test_named_runs_alone():
    runs = [{"name": "a", "set": {"shape": "Linear"}}, {"name": "b", "set": {"shape": "GIMP", "grid.spacing": 0.25}}]
    plan = Study(bar(), runs=runs, errors=EXACT).plan()
    assert [(r.label, r.composition, r.resolution) for r in plan] == [("a", "Linear", 0.125), ("b", "GIMP", 0.25)]
    with pytest.raises(mpm.ParameterError, match="two runs are called 'a'"):
        Study(bar(), runs=[runs[0], runs[0]], errors=EXACT).plan()
    with pytest.raises(mpm.ParameterError, match="no run is named 'c'"):
        Study(bar(), runs=runs, errors=Finest(field="v", reference="c"))


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"repeat": -1}, "Study.repeat must be >= 0"),
        ({"startup": "stagered"}, "did you mean 'staggered'?"),
        ({"time_budget": 0.0}, "Study.time_budget must be > 0"),
        ({"memory_budget": "2 GV"}, "Study.memory_budget"),
        ({"resolution": "shap"}, "there is no axis 'shap'"),
        ({"errors": [EXACT, EXACT]}, "two errors are called"),
        ({"errors": (), "repeat": 0}, "has nothing to measure"),
    ],
)
def test_studies_that_cannot_be(more, message):
    with pytest.raises(mpm.ParameterError, match=message):
        Study(bar(), {"shape": ["Linear"]}, **({"errors": EXACT} | more))


def test_budgets_with_units():
    made = study(memory_budget="2 GiB", time_budget="2 min")
    assert (made.memory_budget, made.time_budget) == (2 * 1024**3, 120.0)


def test_children_time_stop_and_die(tmp_path):
    job = study().job(study().plan()[0])
    with ThreadPoolExecutor(1) as pool:  # a child of its own
        timed = pool.submit(child.run, job | {"task": "time"}).result()
        assert timed["status"] == "done" and timed["seconds"] > 0.0 and timed["steps"] == 7
        stopped = pool.submit(child.run, job | {"task": "errors", "until": 1e6, "measures": [], "time_budget": 0.2}).result()
        assert stopped["status"] == "over budget" and "stopped after 0.2 s of wall time" in stopped["reason"]
        again = pool.submit(child.run, job | {"task": "calibrate"}).result()
        assert again["status"] == "done" and again["dt"] == pytest.approx(0.125)
        assert again["peak_bytes"] > 1e6
        small = pool.submit(child.run, job | {"task": "errors", "memory_budget": 1000}).result()
        assert small["status"] == "over budget" and "1 kB are allowed" in small["reason"]
    child.stop_all()


def test_timing_rounds_go_to_and_fro_and_give_median_and_spread():
    assert [item for _, item in cost.to_and_fro("abc", 2)] == list("abccba")
    times = [{"seconds": s, "reference": r} for s, r in ((3.0, 1.0), (1.0, 1.0), (2.0, 4.0))]
    row = cost.summary(times, 10, 100)
    assert (row["seconds"], row["seconds_low"], row["seconds_high"], row["repeats"]) == (2.0, 1.0, 3.0, 3)
    assert row["reference_seconds"] == 1.0 and math.isclose(row["ns_per_particle_step"], 2e6)


def test_dask_workers(tmp_path):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        results = study().run(tmp_path, client, quiet=True)
    assert [row["status"] for row in results] == ["done", "done"]
    child.stop_all()
