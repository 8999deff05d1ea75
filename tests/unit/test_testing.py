"""The conformance suite itself: names, reports, declared failures, single points. What each check finds is in tests/conformance."""

import math
import sys
import warnings

import numpy as np
import pytest
from mpmkit_materials import LinearElastic, NeoHookean, VonMises
from mpmkit_materials.neo_hookean import quadratic_stress

import mpmkit as mpm
from mpmkit.math import sqrt
from mpmkit.tensor import scale
from mpmkit.testing import collect, conformance, drive, iter_checks, report
from mpmkit.testing.element import exponential, logarithm
from mpmkit.testing.suite import run_one


@mpm.kernel
def stress_times_two(F, lam, mu):
    return scale(2.0, quadratic_stress.function(F, lam, mu))


@mpm.define
class TwiceTheStress(NeoHookean):
    """The stress is not the derivative of the energy, W = W(F)."""

    stress = stress_times_two


@mpm.define
class Knowing(TwiceTheStress):
    """The same, W = W(F), which says so."""

    expected_failures = {  # noqa: RUF012
        "stress is the derivative of the energy": "twice the stress",
        "work is stored or dissipated": "twice the stress",
        "objectivity": "which is not true",
    }


@mpm.define
class Untouchable(NeoHookean):
    """Raises what no one expects, W = W(F)."""

    @property
    def energy(self):
        sys.exit("enough")


@mpm.define
class Warning_(NeoHookean):  # noqa: N801
    """Warns and prints, W = W(F)."""

    def check(self):
        warnings.warn("an old plugin", DeprecationWarning, stacklevel=2)
        print("noise")


def rows_of(target, *names):
    """Rows of some checks by name."""
    return {check.name: run_one(check) for check in iter_checks(target) if check.name in names}


def test_report_says_what_and_why():
    name = "stress is the derivative of the energy"
    row = rows_of(TwiceTheStress, name)[name]
    assert row["component"] == "TwiceTheStress"
    assert row["kind"] == "material"
    assert not row["passed"]
    assert "Cauchy stress: found" in row["reason"]
    known = rows_of(LinearElastic, "objectivity")["objectivity"]
    assert known["passed"]
    assert known["reason"].startswith("known failure: a small-strain")


def test_declared_failures_pass_with_their_reason_and_fail_when_they_are_not_true():
    true = ("stress is the derivative of the energy", "work is stored or dissipated")
    rows = rows_of(Knowing, *true, "objectivity")
    for name in true:
        assert rows[name]["passed"]
        assert rows[name]["known"]
        assert rows[name]["reason"] == "known failure: twice the stress"
    assert not rows["objectivity"]["passed"]
    assert (
        "declares 'objectivity' as a known failure (which is not true), but the check passes: remove the entry"
        in rows["objectivity"]["reason"]
    )


def test_a_component_that_ends_the_process_is_a_failed_check():
    rows = rows_of(Untouchable, "kernel arguments resolve", "is frozen")
    assert {name: row["passed"] for name, row in rows.items()} == {"kernel arguments resolve": False, "is frozen": True}
    assert rows["kernel arguments resolve"]["reason"] == "SystemExit: enough"


def test_warnings_are_kept_and_do_no_harm(capsys):
    with pytest.warns(DeprecationWarning, match="an old plugin"):
        row = rows_of(Warning_, "repr rebuilds it")["repr rebuilds it"]
    assert row["passed"]
    assert row["warnings"] == ["DeprecationWarning: an old plugin"]
    assert 0.0 < row["seconds"] < 10.0


def test_a_component_is_checked_with_its_own_parameters():
    names = [check.name for check in iter_checks(VonMises(E=1e7, nu=0.3, rho=1.0, yield_stress=1e4, strain="small"))]
    assert "work is stored or dissipated" in names
    assert not any("[" in name for name in names)


def test_two_checks_of_one_name_are_refused():
    with pytest.raises(ValueError, match="two checks of material are named 'objectivity'"):
        collect.check("material", "objectivity")(lambda component, rng: None)


def test_unknown_plugin_is_named_with_the_nearest():
    with pytest.raises(mpm.PluginError, match="did you mean 'NeoHookean'"):
        list(iter_checks("NeoHokean"))


def test_a_plugin_that_cannot_be_loaded_is_one_failed_check(fakes):
    fakes.add("mpmkit-broken", "broken_rubber", "import a_module_that_does_not_exist", point="broken")
    rows = report("broken")
    assert [(r["component"], r["check"], r["passed"]) for r in rows] == [("broken", "entry point loads", False)]
    assert "a_module_that_does_not_exist" in rows[0]["reason"]


def test_two_components_of_one_name_fail(fakes):
    fakes.material("mpmkit-one", "rubber_one", "TwinRubber")
    fakes.material("mpmkit-two", "rubber_two", "TwinRubber")
    row = rows_of("mpmkit-one", "entry point loads")["entry point loads"]
    assert not row["passed"]
    assert "mpmkit-one" in row["reason"]
    assert "mpmkit-two" in row["reason"]


def test_conformance_is_a_parametrised_pytest_function():
    function = conformance("NeoHookean")
    mark = next(m for m in function.pytestmark if m.name == "parametrize")
    assert "NeoHookean-objectivity" in mark.kwargs["ids"]


def test_logarithm_and_exponential_are_inverse():
    """Rounding: 1e-15 of matrices of size 1."""
    from scipy.linalg import expm

    A = np.random.default_rng(3).uniform(-0.3, 0.3, (3, 3))
    assert exponential(A) == pytest.approx(expm(A), abs=4e-15)
    assert logarithm(exponential(A)) == pytest.approx(A, abs=4e-15)


def test_drive_refuses_what_it_cannot_follow():
    law = NeoHookean(E=1e6, nu=0.3, rho=1000.0)
    with pytest.raises(mpm.ParameterError, match=r"shape \(n, 3, 3\), got \(3, 3\)"):
        drive(law, np.eye(3))
    with pytest.raises(mpm.ParameterError, match=r"inverts the material .* at step 1"):
        drive(law, [np.eye(3), -np.eye(3)])
    with pytest.raises(mpm.ParameterError, match="step 1 of the path is too large"):
        drive(law, [np.eye(3), np.diag([50.0, 1, 1])])
    with pytest.raises(mpm.ParameterError, match="NeoHookean has no kernel bar_stress"):
        drive(law, [np.eye(3)], bar=True)


def test_drive_gives_l_with_the_exponential_update():
    """Constant rate: ln F / t, to rounding."""
    law = mpm.materials.HypoelasticJaumann(E=1.0, nu=0.0, rho=1.0)
    history = drive(law, [np.diag([math.exp(0.1 * n), 1, 1]) for n in range(4)], dt=0.5)
    assert history.stress[:, 0] == pytest.approx([0.0, 0.1, 0.2, 0.3], abs=1e-14)
    assert history.wave_speed[-1] == pytest.approx(sqrt(math.exp(0.3) * (1 + sqrt(0.5) * 0.3 * sqrt(2 / 3))), rel=1e-14)
