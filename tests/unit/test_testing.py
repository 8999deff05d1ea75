"""The conformance suite itself: each check finds the fault it is there for."""

import math
from functools import cache

import numpy as np
import pytest
from mpmkit_contacts import FrictionalContact
from mpmkit_materials import LinearElastic, NeoHookean, VonMises
from mpmkit_materials.neo_hookean import quadratic_energy, quadratic_stress, quadratic_wave_speed
from mpmkit_shapes import Linear

import mpmkit as mpm
from mpmkit.math import sqrt
from mpmkit.tensor import scale
from mpmkit.testing import conformance, drive, iter_checks, report
from mpmkit.testing.element import exponential, logarithm


class Soft(mpm.ConstitutiveModel):
    """A neo-Hookean law that the faulty ones derive from, W = W(F)."""

    references = ("none",)
    stress = quadratic_stress
    energy = quadratic_energy
    wave_speed = quadratic_wave_speed
    lam = 2e6
    mu = 1e6


def rho():
    return mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1000.0)


@mpm.kernel
def stress_times_two(F, lam, mu):
    return scale(2.0, quadratic_stress.function(F, lam, mu))


@mpm.kernel
def stress_with_offset(F, lam, mu):
    xx, yy, zz, xy, yz, xz = quadratic_stress.function(F, lam, mu)
    return (xx + 1.0, yy, zz, xy, yz, xz)


@mpm.kernel
def stress_of_five(F, lam, mu):
    return quadratic_stress.function(F, lam, mu)[:5]


@mpm.kernel
def half_speed(F, J, lam, mu, rho):
    return 0.5 * quadratic_wave_speed.function(F, J, lam, mu, rho)


@mpm.kernel
def threefold_speed(F, J, lam, mu, rho):
    return 3.0 * quadratic_wave_speed.function(F, J, lam, mu, rho)


@mpm.kernel
def whole_numbers(F, lam, mu):
    xx, yy, zz, xy, yz, xz = quadratic_stress.function(F, lam, mu)
    return (xx, yy, zz, xy, yz, xz / 3 * 3)


@mpm.kernel
def asks_for_pressure(F, lam, mu, nobody_knows):
    return quadratic_stress.function(F, lam, mu)


@mpm.define
class TwiceTheStress(Soft):
    """The stress is not the derivative of the energy, W = W(F)."""

    rho: float = rho()
    stress = stress_times_two


@mpm.define
class Prestressed(Soft):
    """Stress at the start, W = W(F)."""

    rho: float = rho()
    stress = stress_with_offset


@mpm.define
class FiveComponents(Soft):
    """One component is missing, W = W(F)."""

    rho: float = rho()
    stress = stress_of_five


@mpm.define
class Slow(Soft):
    """The wave speed is too low, W = W(F)."""

    rho: float = rho()
    wave_speed = half_speed


@mpm.define
class Fast(Soft):
    """The wave speed wastes time steps, W = W(F)."""

    rho: float = rho()
    wave_speed = threefold_speed


@mpm.define
class Misspelt(Soft):
    """A kernel asks for what is not there, W = W(F)."""

    rho: float = rho()
    stress = asks_for_pressure


@mpm.define
class DoublePrecision(Soft):
    """An integer constant makes double precision, W = W(F)."""

    rho: float = rho()
    stress = whole_numbers


@mpm.define
class Undocumented(Soft):
    """Parameter without a meaning, and with a unit that is none, W = W(F)."""

    rho: float = mpm.parameter("", unit="kg/furlongs_", gt=0.0, example=1000.0)


@mpm.define
class WithoutReference(Soft):
    """No source, W = W(F)."""

    references = ()
    rho: float = rho()


@mpm.define
class BadExample(Soft):
    """The example is refused, W = W(F)."""

    rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=-1.0)


@mpm.define
class OpenRange(Soft):
    """Declares a range and then accepts what is outside, W = W(F)."""

    rho: float = rho()

    def __init__(self, rho):
        object.__setattr__(self, "rho", rho if isinstance(rho, float) else 1.0)


@mpm.define
class SmallUndeclared(LinearElastic):
    """Hooke's law, sigma = C : eps, that does not say it is not objective."""

    expected_failures = {}  # noqa: RUF012


@mpm.define
class DeclaredForNothing(NeoHookean):
    """An objective law, W = W(b), that says it is not."""

    expected_failures = {"objectivity": "said without reason"}  # noqa: RUF012


@mpm.define
class UnknownFailure(NeoHookean):
    """Declares a failure of a check that does not exist, W = W(b)."""

    expected_failures = {"objectivety": "misspelt"}  # noqa: RUF012


@mpm.kernel
def forgets_the_return(stress, L, dt, eps_p, lam, mu):
    k = dt * (lam * (L[0] + L[4] + L[8]))
    a = 2.0 * mu * dt
    xx, yy, zz, xy, yz, xz = stress
    return (xx + k + a * L[0], yy + k + a * L[4], zz + k + a * L[8], xy + a * L[1], yz + a * L[5], xz + a * L[2]), eps_p - 1e-6


@mpm.define
class NeverYields(VonMises):
    """Plasticity that forgets the return, eps_p = -n."""

    stress = forgets_the_return


@mpm.kernel
def wrong_slopes(f):
    return (1.0 - f, f), (-1.0, 1.01)


@mpm.kernel
def jumping_weights(f):
    return (0.9 - f, f + 0.1), (-1.0, 1.0)


@mpm.define
class WrongSlopes(Linear):
    """Slopes that are no derivatives, w = f."""

    weights = wrong_slopes


@mpm.define
class JumpingWeights(Linear):
    """Weights that jump and become negative, w = f + 0.1."""

    weights = jumping_weights


@mpm.define
class QuadraticByName(Linear):
    """Claims more than it reproduces, w = f."""

    order = 2


@mpm.kernel
def sticky_impulse(m_a, v_a, m_b, v_b, normal):
    m = m_a * m_b / (m_a + m_b)
    return (-m * (v_a[0] - v_b[0]), -m * (v_a[1] - v_b[1]), -m * (v_a[2] - v_b[2]))


@mpm.kernel
def lopsided_impulse(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    u = (v_a[0] - v_b[0]) * normal[0] + (v_a[1] - v_b[1]) * normal[1] + (v_a[2] - v_b[2]) * normal[2] - max(gap, 0.0) / dt
    p = 3.0 * m_a * max(u, 0.0)
    return (-p * normal[0], -p * normal[1], -p * normal[2])


@mpm.define
class Sticky(FrictionalContact):
    """Bodies that never let go, p = -m u."""

    impulse = sticky_impulse


@mpm.define
class Lopsided(FrictionalContact):
    """Only the mass of one body counts, p = -3 m_a u."""

    impulse = lopsided_impulse


@mpm.kernel
def half_the_velocity(v):
    return (0.5 * v[0], 0.5 * v[1], 0.5 * v[2])


@mpm.kernel
def thrust(v, dv_n):
    return (v[0] + dv_n, v[1], v[2])


@mpm.define
class HalfWall(mpm.BoundaryLayer):
    """Lets half the velocity pass, v/2 = v/2, and pushes where it should rub."""

    references = ("none",)
    constrain = half_the_velocity
    rub = thrust


@mpm.kernel
def always(L, rho, c, h):
    return -rho * c * h * (L[0] + L[4] + L[8])


@mpm.define
class PullingViscosity(mpm.Effect):
    """Viscous pressure in expansion, q = -rho c h div v."""

    references = ("none",)
    viscous_pressure = always


@mpm.kernel
def slightly_less(v_grid):
    return 0.999 * v_grid


@mpm.define
class Losing(mpm.Transfer):
    """Loses velocity, v = 0.999 v."""

    references = ("none",)
    velocity = slightly_less


@mpm.define
class Forgetful(mpm.Integrator):
    """Forgets contact and the stress."""

    references = ("none",)

    def step(self, s):
        s.p2g()
        s.forces()
        s.momentum()
        s.boundary()
        s.g2p()
        s.strain()


@cache
def failing(cls):
    return {row["check"] for row in report(cls) if not row["passed"]}


@pytest.mark.parametrize(
    ("cls", "check"),
    [
        (TwiceTheStress, "stress is the derivative of the energy"),
        (TwiceTheStress, "work is stored or dissipated"),
        (Prestressed, "stress-free at the start"),
        (FiveComponents, "returns stress and state"),
        (Slow, "wave speed bounds the acoustic tensor"),
        (Fast, "wave speed bounds the acoustic tensor"),
        (Misspelt, "kernel arguments resolve"),
        (DoublePrecision, "single precision stays single"),
        (Undocumented, "parameters are documented"),
        (WithoutReference, "docstring has equation and reference"),
        (BadExample, "examples construct"),
        (OpenRange, "bad values are refused"),
        (SmallUndeclared, "objectivity"),
        (DeclaredForNothing, "objectivity"),
        (UnknownFailure, "known failures are checks"),
        (NeverYields, "stays on or inside the yield surface"),
        (NeverYields, "dissipation never decreases"),
        (WrongSlopes, "partition of unity"),
        (WrongSlopes, "slopes are derivatives of the weights"),
        (WrongSlopes, "linear fields are reproduced"),
        (JumpingWeights, "continuous across cells"),
        (JumpingWeights, "weights are not negative"),
        (JumpingWeights, "mirror symmetric"),
        (QuadraticByName, "declared order is reproduced"),
        (Sticky, "no pull"),
        (Sticky, "no effect at a distance"),
        (Sticky, "friction is bounded"),
        (Lopsided, "equal under swap"),
        (Lopsided, "no energy from friction and impact"),
        (HalfWall, "applying twice is applying once"),
        (HalfWall, "nothing passes a wall at rest"),
        (HalfWall, "friction gains no energy"),
        (PullingViscosity, "viscous pressure only in compression"),
        (Losing, "keeps a constant velocity"),
        (Losing, "falls freely"),
        (Forgetful, "recipe is complete and in order"),
    ],
)
def test_each_check_finds_its_fault(cls, check):
    assert check in failing(cls)


def test_a_good_component_has_no_failure():
    assert failing(NeoHookean) == set()


def test_report_says_what_and_why():
    row = next(r for r in report(TwiceTheStress) if r["check"] == "stress is the derivative of the energy")
    assert row["component"] == "TwiceTheStress"
    assert row["kind"] == "material"
    assert not row["passed"]
    assert "Cauchy stress: found" in row["reason"]
    known = next(r for r in report(LinearElastic) if r["check"] == "objectivity")
    assert known["passed"]
    assert known["reason"].startswith("known failure: a small-strain")


def test_a_component_is_checked_with_its_own_parameters():
    names = [check.name for check in iter_checks(VonMises(E=1e7, nu=0.3, rho=1.0, yield_stress=1e4, strain="small"))]
    assert "work is stored or dissipated" in names
    assert not any("[" in name for name in names)


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
    row = next(r for r in report("mpmkit-one") if r["check"] == "entry point loads")
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
