"""Bundled constitutive models against closed forms."""

import math

import numpy as np
import pytest
from mpmkit_materials import HypoelasticJaumann, LinearElastic, NeoHookean, NewtonianFluid, VonMises

import mpmkit as mpm
from mpmkit.testing import drive
from mpmkit.testing.element import exponential, straight

EPS = np.finfo(float).eps
E, NU, RHO = 1000.0, 0.3, 1000.0
LAM, MU = E * NU / ((1 + NU) * (1 - 2 * NU)), E / (2 * (1 + NU))


def uniaxial(strain, steps):
    """Logarithmic strain in the x direction in equal steps, lateral strain zero."""
    return np.array([np.diag([math.exp(e), 1, 1]) for e in np.linspace(0, strain, steps + 1)])


def simple_shear(g, steps):
    """F = I + g e1 e2."""
    return straight(np.array([[0, g, 0], [0, 0, 0], [0, 0, 0.0]]), steps)


def pure_shear(e, steps):
    """Plane, volume-preserving: stretches exp(e), exp(-e), 1."""
    return np.array([np.diag([math.exp(s), math.exp(-s), 1]) for s in np.linspace(0, e, steps + 1)])


def test_linear_elastic_uniaxial_strain():
    """sigma_xx = (lam + 2 mu) eps, lateral lam eps. Rounding: of 1 - F, eps times the modulus."""
    stress = drive(LinearElastic(E=E, nu=NU, rho=RHO), straight(np.diag([1e-3, 0, 0]), 1)).stress[-1]
    assert stress == pytest.approx([(LAM + 2 * MU) * 1e-3, LAM * 1e-3, LAM * 1e-3, 0, 0, 0], abs=4 * EPS * E)


def test_linear_elastic_wave_speeds():
    """Uniaxial strain and uniaxial stress at the start: sqrt((lam + 2 mu) / rho) and sqrt(E / rho). Rounding."""
    law = LinearElastic(E=E, nu=NU, rho=RHO)
    start = np.eye(3)[None]
    assert drive(law, start).wave_speed[0] == pytest.approx(math.sqrt((LAM + 2 * MU) / RHO), rel=1e-14)
    assert drive(law, start, bar=True).wave_speed[0] == pytest.approx(math.sqrt(E / RHO), rel=1e-14)


def test_linear_elastic_bar_of_the_report():
    """SAND2002-0482: E = 1e4, rho = 1 give C = 100, and sigma = rho C v for the strain v / C. Rounding."""
    law = LinearElastic(E=1e4, nu=0.0, rho=1.0)
    history = drive(law, straight(np.diag([-1e-3, 0, 0]), 1), bar=True)
    assert history.wave_speed[0] == pytest.approx(100.0, rel=1e-14)
    assert history.stress[-1] == pytest.approx([-10.0, 0, 0, 0, 0, 0], abs=4 * EPS * 1e4)
    assert history.energy[-1] == pytest.approx(0.5 * 1e4 * 1e-6, rel=1e-12)


@pytest.mark.parametrize("form", ["quadratic", "log"])
def test_neo_hookean_uniaxial_and_shear(form):
    """Closed forms at a stretch of 1.2 and a shear of 0.5. Rounding: 1e-13 of E."""
    law = NeoHookean(E=E, nu=NU, rho=RHO, form=form)
    J = 1.2
    volumetric = 0.5 * LAM * (J * J - 1) if form == "quadratic" else LAM * math.log(J)
    stress = np.array(law.stress((1.2, 0, 0, 0, 1.0, 0, 0, 0, 1.0), LAM, MU))
    assert stress == pytest.approx([(volumetric + MU * (J * J - 1)) / J, volumetric / J, volumetric / J, 0, 0, 0], abs=1e-13 * E)
    g = 0.5
    stress = np.array(law.stress((1.0, g, 0, 0, 1.0, 0, 0, 0, 1.0), LAM, MU))
    assert stress == pytest.approx([MU * g * g, 0, 0, MU * g, 0, 0], abs=1e-13 * E)


def test_neo_hookean_is_the_corrected_law():
    """Guilkey's eq 11 at a stretch of 1.2 gives 246.6 Pa; eq 12 with only its bracket repaired would give 274.7 Pa (rounded to 0.1)."""
    law = NeoHookean(E=E, nu=NU, rho=RHO)
    stress = law.stress((1.2, 0, 0, 0, 1.0, 0, 0, 0, 1.0), 577.0, 384.0)[0]
    assert stress == pytest.approx((577.0 / 2 + 384.0) * (1.2 - 1 / 1.2), rel=1e-14)
    assert stress == pytest.approx(246.6, abs=0.05)


@pytest.mark.parametrize("form", ["quadratic", "log"])
def test_neo_hookean_wave_speed_bounds_the_acoustic_tensor(form):
    """The fastest direction is a principal one: rho0 c^2 / l^2 = d2W / dl^2 of the largest stretch, by differences. Rate: 1e-6.

    Attained where the two smaller stretches are equal, else at most 5 % above it for stretches between 0.7 and 1.4.
    """
    law = NeoHookean(E=E, nu=NU, rho=RHO, form=form)
    for stretches in ((1.0, 1.0, 1.0), (1.3, 0.9, 0.9), (1.3, 0.9, 1.1), (0.8, 0.7, 0.75), (1.2, 1.2, 1.4), (1.2, 1.2, 0.9)):
        a = int(np.argmax(stretches))
        step = 1e-4

        def energy(shift, stretches=stretches, a=a):
            F = np.diag(stretches)
            F[a, a] += shift
            return law.energy(tuple(F.ravel()), LAM, MU)

        second = (energy(step) - 2 * energy(0.0) + energy(-step)) / step**2
        F = np.diag(stretches)
        c = law.wave_speed(tuple(F.ravel()), float(np.linalg.det(F)), LAM, MU, RHO)
        wanted = stretches[a] * math.sqrt(second / RHO)
        attained = sorted(stretches)[0] == sorted(stretches)[1]
        assert wanted * (1.0 - 1e-6) < c < wanted * ((1.0 + 1e-6) if attained else 1.05)


def test_neo_hookean_wave_speed_in_uniaxial_strain():
    """rho0 c^2 = (lam/2 + mu)(1 + J^2) when the largest stretch is J. Rounding."""
    law = NeoHookean(E=E, nu=NU, rho=RHO)
    c = law.wave_speed((1.5, 0, 0, 0, 1.0, 0, 0, 0, 1.0), 1.5, LAM, MU, RHO)
    assert c == pytest.approx(math.sqrt((0.5 * LAM + MU) * (1 + 1.5**2) / RHO), rel=1e-14)


def test_jaumann_simple_shear():
    """s12 = G sin g, s11 = G (1 - cos g). Rate: 1e-6 of G with 1e4 steps; the step is second order."""
    law = HypoelasticJaumann(E=E, nu=NU, rho=RHO)
    path = simple_shear(3.0, 10_000)
    history = drive(law, path)
    g = path[:, 0, 1]
    assert np.abs(history.stress[:, 3] / MU - np.sin(g)).max() < 1e-6
    assert np.abs(history.stress[:, 0] / MU - (1 - np.cos(g))).max() < 1e-6


def test_jaumann_is_second_order():
    """Rate: halving the step divides the error by four (3.9 at least, three resolutions)."""
    law = HypoelasticJaumann(E=E, nu=NU, rho=RHO)
    errors = [abs(drive(law, simple_shear(1.0, n)).stress[-1, 3] / MU - math.sin(1.0)) for n in (20, 40, 80)]
    assert errors[0] / errors[1] > 3.9
    assert errors[1] / errors[2] > 3.9


def test_jaumann_rotation_keeps_the_invariants():
    """Ten turns of 100 steps each. Rounding: 1e-12 of the stress."""
    law = HypoelasticJaumann(E=E, nu=NU, rho=RHO)
    F1 = np.diag([1.01, 0.995, 1.0])
    axis = np.array([1.0, 2.0, -1.0]) / math.sqrt(6.0) * 2 * math.pi / 100
    x, y, z = axis
    turn = exponential(np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]))
    path = [*straight(F1 - np.eye(3), 10)]
    for _ in range(1000):
        path.append(turn @ path[-1])
    history = drive(law, path)
    before, after = history.stress[10], history.stress[-1]
    assert after == pytest.approx(before, abs=1e-10 * np.abs(before).max())  # whole turns: the same components again
    assert history.energy[-1] == pytest.approx(history.energy[10], rel=1e-12)


def test_jaumann_uniaxial_strain_is_logarithmic():
    """sigma_xx = (lam + 2 mu) ln(l). Rounding."""
    history = drive(HypoelasticJaumann(E=E, nu=NU, rho=RHO), uniaxial(0.3, 5))
    assert history.stress[-1, 0] == pytest.approx((LAM + 2 * MU) * 0.3, rel=1e-13)
    bar = drive(HypoelasticJaumann(E=E, nu=NU, rho=RHO), uniaxial(0.3, 5), bar=True)
    assert bar.stress[-1, 0] == pytest.approx(E * 0.3, rel=1e-13)


@pytest.mark.parametrize("strain", ["finite", "small"])
def test_perfect_plasticity_in_pure_shear(strain):
    """The deviator stops at Y: sigma_xx - sigma_yy = 2 Y / sqrt(3); eps_p = 2/sqrt(3) (e - e_y). Rounding: 1e-12."""
    Y = 10.0
    history = drive(VonMises(E=E, nu=NU, rho=RHO, yield_stress=Y, strain=strain), pure_shear(0.1, 50))
    stress, e_y = history.stress[-1], Y / (2 * math.sqrt(3) * MU)
    assert stress[:3] == pytest.approx([Y / math.sqrt(3), -Y / math.sqrt(3), 0.0], abs=1e-12 * Y)
    assert history.state["eps_p"][-1] == pytest.approx(2 / math.sqrt(3) * (0.1 - e_y), rel=1e-12)
    assert history.dissipation[-1] == pytest.approx(Y * history.state["eps_p"][-1], rel=1e-14)


def test_hardening_in_uniaxial_strain():
    """Closed form: after yield d(sigma_xx) = [K + 4/3 mu (1 - 3 mu / (3 mu + H))] d(eps). Rounding: 1e-12."""
    Y, Et = 10.0, 250.0
    law = VonMises(E=E, nu=NU, rho=RHO, yield_stress=Y, tangent_modulus=Et, strain="small")
    H, K = E * Et / (E - Et), LAM + 2 / 3 * MU
    assert law.hardening == pytest.approx(H, rel=1e-14)
    history = drive(law, uniaxial(0.05, 25))
    eps, e_y = 0.05, Y / (2 * MU)
    q = Y + (eps - e_y) * 2 * MU * H / (3 * MU + H)
    assert history.stress[-1, 0] == pytest.approx(K * eps + 2 / 3 * q, rel=1e-12)
    assert history.state["eps_p"][-1] == pytest.approx((eps - e_y) * 2 * MU / (3 * MU + H), rel=1e-12)


def bar_curve(strain, Y, Et):
    """Uniaxial stress of a first loading."""
    e_y = Y / 1e4
    return 1e4 * strain if strain <= e_y else Y + Et * (strain - e_y)


@pytest.mark.parametrize("Et", [0.0, 2500.0])
@pytest.mark.parametrize("steps", [1, 7, 100])
def test_bar_follows_the_stress_strain_curve(Et, steps):
    """Tension with plasticity: E, then Et, exactly, whatever the steps; unloading with E. Rounding: of F near 1 times E in each step."""
    Y, rounding = 4.0, 1e4 * EPS * (steps + 4)
    law = VonMises(E=1e4, nu=0.0, rho=1.0, yield_stress=Y, tangent_modulus=Et)
    loading = [np.diag([math.exp(e), 1, 1]) for e in np.linspace(0, 1e-3, steps + 1)]
    unloading = [np.diag([math.exp(e), 1, 1]) for e in np.linspace(1e-3, 9e-4, 4)[1:]]
    history = drive(law, loading + unloading, bar=True)
    for n in range(steps + 1):
        assert history.stress[n, 0] == pytest.approx(bar_curve(1e-3 * n / steps, Y, Et), abs=rounding)
    peak = bar_curve(1e-3, Y, Et)
    assert history.stress[-1, 0] == pytest.approx(peak - 1e4 * 1e-4, abs=rounding)
    assert history.state["eps_p"][-1] == pytest.approx(1e-3 - peak / 1e4, abs=rounding / 1e4)


def test_bar_at_the_impact_of_the_report():
    """SAND2002-0482 Figs 13-16, V0 = 0.1, Y = 4, Et = E/4: precursor -4, then the plastic wave of speed 50 brings it to -7. Rounding."""
    law = VonMises(E=1e4, nu=0.0, rho=1.0, yield_stress=4.0, tangent_modulus=2500.0)
    # strain behind the waves: v = 0.04 / 100 up to yield, the remaining 0.06 at the plastic speed sqrt(Et / rho) = 50
    strain = -(0.04 / 100 + 0.06 / 50)
    history = drive(law, uniaxial(strain, 10), bar=True)
    assert history.stress[-1, 0] == pytest.approx(-7.0, rel=1e-12)
    assert history.state["eps_p"][-1] == pytest.approx(9e-4, rel=1e-12)


def test_yield_surface_holds_on_a_wild_path():
    """|s| <= Y + H eps_p to 1e-9 (here: to rounding) for random large steps, and dissipation grows."""
    rng = np.random.default_rng(1)
    law = VonMises(E=E, nu=NU, rho=RHO, yield_stress=2.0, tangent_modulus=100.0)
    path = [np.eye(3)]
    for _ in range(300):
        path.append(exponential(rng.normal(scale=0.02, size=(3, 3))) @ path[-1])
    history = drive(law, path)
    s = history.stress
    mean = s[:, :3].mean(axis=1, keepdims=True)
    q = np.sqrt(1.5 * (((s[:, :3] - mean) ** 2).sum(axis=1) + 2 * (s[:, 3:] ** 2).sum(axis=1)))
    limit = 2.0 + law.hardening * history.state["eps_p"]
    assert (q <= limit * (1 + 1e-12)).all()
    assert (q >= limit * (1 - 1e-12)).sum() > 100  # a third of the steps and more do yield
    assert np.diff(history.dissipation).min() >= 0


def test_tangent_modulus_must_be_below_youngs_modulus():
    with pytest.raises(mpm.ParameterError, match=r"tangent_modulus must be < E = 1000 Pa, got 1000"):
        VonMises(E=E, nu=NU, rho=RHO, yield_stress=1.0, tangent_modulus=E)


@pytest.mark.parametrize(("name", "value"), [("nu", 0.5), ("rho", -1.0), ("E", 0.0)])
def test_elastic_constants_are_checked(name, value):
    with pytest.raises(mpm.ParameterError, match=rf"NeoHookean.{name} must be"):
        NeoHookean(**({"E": E, "nu": NU, "rho": RHO} | {name: value}))


def test_fluid_pressure_energy_and_speed():
    """Murnaghan's law at 3 % compression; energy by integration of -p dJ. Rounding, and 1e-9 for the quadrature."""
    from scipy.integrate import quad

    K, gamma = 2e6, 7.0
    law = NewtonianFluid(rho=RHO, bulk_modulus=K, viscosity=0.0)
    J = 0.97

    def pressure(j):
        return K / gamma * (j**-gamma - 1)

    history = drive(law, straight(np.diag([J - 1, 0, 0]), 4))
    assert history.stress[-1] == pytest.approx([-pressure(J)] * 3 + [0] * 3, rel=1e-12)
    assert history.energy[-1] == pytest.approx(quad(lambda j: -pressure(j), 1, J, epsrel=1e-12)[0], rel=1e-9)
    assert history.wave_speed[0] == pytest.approx(math.sqrt(K / RHO), rel=1e-14)
    assert history.wave_speed[-1] == pytest.approx(math.sqrt(K * J**-gamma / (RHO / J)), rel=1e-13)


def test_fluid_shear_is_viscous():
    """Couette flow: sigma_xy = mu dv/dy and the heat mu (dv/dy)^2 per time. Rounding: 1e-12 relative."""
    law = NewtonianFluid(rho=RHO, bulk_modulus=2e6, viscosity=3.0)
    rate, dt, steps = 20.0, 1e-4, 100
    history = drive(law, simple_shear(rate * dt * steps, steps), dt)
    assert history.stress[-1, 3] == pytest.approx(3.0 * rate, rel=1e-12)
    assert history.dissipation[-1] == pytest.approx(3.0 * rate**2 * dt * steps, rel=1e-12)
    assert law.diffusivity(1.0, law.viscosity, law.rho) == pytest.approx(4 / 3 * 3.0 / RHO, rel=1e-15)


@pytest.mark.parametrize("form", ["quadratic", "log"])
def test_energies_of_a_closed_path_return(form):
    """A hyperelastic law gives all work back. Rate: trapezoidal rule with 400 steps, 1e-4 of the largest energy."""
    s = np.concatenate([np.linspace(0, 1, 200), np.linspace(1, 0, 201)[1:]])
    A, B = np.array([[0.1, 0.2, 0], [0, -0.1, 0], [0, 0.1, 0.05]]), np.array([[0, 0, 0.1], [0.2, 0, 0], [0, 0, 0]])
    path = np.array([np.eye(3) + t * A + 4 * t * (1 - t) * (1 if n < 200 else -1) * B for n, t in enumerate(s)])
    history = drive(NeoHookean(E=E, nu=NU, rho=RHO, form=form), path)
    assert history.energy[-1] == pytest.approx(0.0, abs=1e-12 * E)
    assert history.work[-1] == pytest.approx(0.0, abs=1e-4 * history.energy.max())
