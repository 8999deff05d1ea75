"""The elastic-plastic bar at a wall: jump conditions at every front, energy, momentum, and the numbers of the report's tests."""

import numpy as np
import pytest

from mpmkit.errors import ParameterError
from mpmkit.exact import BarImpact, PlasticBarImpact

BAR = {"V0": 0.1, "L": 0.5, "E": 1e4, "rho": 1.0}  # C = 100 m/s, rho C V0 = 10 Pa
EPS = np.finfo(float).eps

CASES = [
    pytest.param(PlasticBarImpact(**BAR, Y=4.0, Et=2500.0), id="hardening"),
    pytest.param(PlasticBarImpact(**BAR, Y=4.0, Et=0.0), id="perfect"),
    pytest.param(PlasticBarImpact(**BAR, Y=1.3, Et=0.0), id="perfect, weak"),
    pytest.param(PlasticBarImpact(**BAR, Y=6.6, Et=900.0), id="late yield"),
    pytest.param(PlasticBarImpact(**BAR, Y=1.0, Et=5000.0, until=0.03), id="many waves"),
]


def test_linear_hardening_numbers():
    # pinned, exact fractions for Et = E/4, V0 = 0.1, Y = 4: derived by hand from the waves of SAND2002-0482, Figs 13 to 16
    bar = PlasticBarImpact(**BAR, Y=4.0, Et=2500.0)
    assert bar.separation_time == pytest.approx(1 / 75, rel=1e-12)
    assert bar.restitution == pytest.approx(23 / 45, rel=1e-12)
    assert bar.plastic_shortening(0.05) == pytest.approx(3.1111111111e-4, rel=1e-10)  # 9e-4 / 3 + 1e-4 / 9
    assert bar.contact_stress(0.001) == pytest.approx(-7.0, rel=1e-12)
    assert bar.plastic_strain([0.1, 0.32, 0.35, 0.43, 0.46], 0.05) == pytest.approx([-9e-4, -9e-4, -1e-4, -1e-4, 0.0], abs=1e-15)
    # 2 ms after contact: rest behind the plastic wave (50 m/s), the elastic precursor at -4 (100 m/s), free flight ahead
    assert bar.stress([0.05, 0.15, 0.25], 0.002) == pytest.approx([-7.0, -4.0, 0.0], rel=1e-12)
    assert bar.velocity([0.05, 0.15, 0.25], 0.002) == pytest.approx([0.0, -0.06, -0.1], abs=1e-13)
    # of the kinetic energy before, 26.12 % are left in the centre of mass and 6.02 % vibrate
    energies = bar.energies(0.05)
    centre = 0.5 * 0.5 * bar.mean_velocity(0.05) ** 2
    assert centre / 0.0025 == pytest.approx((23 / 45) ** 2, rel=1e-11)
    assert (energies["kinetic"] + energies["elastic"] - centre) / 0.0025 == pytest.approx(0.0602469, rel=1e-5)


def test_scaling_with_speed_and_yield_stress():
    # small strain: speed and yield stress ten times as large make all fields ten times as large
    one, ten = PlasticBarImpact(**BAR, Y=4.0, Et=2500.0), PlasticBarImpact(**BAR | {"V0": 1.0}, Y=40.0, Et=2500.0)
    X = np.linspace(0.01, 0.49, 17)
    for t in (0.003, 0.011, 0.02):
        assert ten.stress(X, t) == pytest.approx(10 * one.stress(X, t), abs=1e-11)
    assert ten.restitution == pytest.approx(one.restitution, rel=1e-12)


def test_perfect_plasticity_numbers():
    # pinned, exact: the wall presses with 4 for 0.01 s and with 2 for 0.01 s, 0.06 = rho L (V0 + v), so v = 0.02 and e = 1/5;
    # the hinge at the face closes with 0.06 m/s for 0.01 s; nothing vibrates afterwards
    bar = PlasticBarImpact(**BAR, Y=4.0, Et=0.0)
    assert bar.separation_time == pytest.approx(0.02, rel=1e-12)
    assert bar.restitution == pytest.approx(0.2, rel=1e-12)
    assert bar.plastic_shortening(0.03) == pytest.approx(6e-4, rel=1e-12)
    assert bar.displacement(0.0, 0.02) == pytest.approx(-6e-4, rel=1e-12)
    assert np.abs(bar.velocity(np.linspace(0, 0.5, 11), 0.03) - 0.02).max() <= 1e-13
    assert np.all(bar.plastic_strain(np.linspace(0, 0.5, 11), 0.03) == 0.0)


@pytest.mark.parametrize("Et", [0.0, 2500.0])
def test_slow_impact_is_elastic(Et):
    # below the yield stress it must be the elastic impact of two bars seen from the contact face
    bar = PlasticBarImpact(**BAR, Y=10.5, Et=Et)
    pair = BarImpact(**BAR, gap=0.0)
    X = np.linspace(0.013, 0.487, 9)
    for t in (0.0021, 0.0047, 0.0083, 0.013):
        assert bar.stress(X, t) == pytest.approx(pair.stress(0.5 + X, t), abs=1e-12)
        assert bar.velocity(X, t) == pytest.approx(pair.velocity(0.5 + X, t), abs=1e-14)
        assert bar.displacement(X, t) == pytest.approx(pair.displacement(0.5 + X, t), abs=1e-16)
    assert bar.restitution == pytest.approx(1.0, rel=1e-12)
    assert abs(bar.plastic_shortening(0.02)) <= 1e-16  # rounding, of the displacement 5e-4


@pytest.mark.parametrize("bar", CASES)
def test_energy_is_balanced_and_plastic_work_never_falls(bar):
    times = np.linspace(0.0, bar.end, 60)
    energies = [bar.energies(t) for t in times]
    # rounding of some hundred events, times the energy before
    assert np.abs(np.array([sum(e.values()) for e in energies]) / 0.0025 - 1.0).max() <= 1e-10
    assert np.diff([e["plastic"] for e in energies]).min() >= -1e-14
    assert energies[-1]["plastic"] > 0.001 * 0.0025


@pytest.mark.parametrize("bar", CASES)
def test_momentum_is_the_impulse_of_the_wall(bar):
    starts = [epoch.start for epoch in bar.epochs] + [bar.end]
    impulse = -np.diff(starts) @ np.array([epoch.face_stress for epoch in bar.epochs])
    assert 0.5 * (bar.mean_velocity(bar.end) + 0.1) == pytest.approx(impulse, rel=1e-10)
    stresses = bar.contact_stress(np.linspace(0, bar.end, 500))
    assert stresses.max() <= 1e-10  # the wall never pulls


@pytest.mark.parametrize("bar", CASES)
def test_jump_conditions_hold_at_every_front(bar):
    for epoch in bar.epochs:
        assert epoch.widths(epoch.start, bar.L).min() >= -1e-10
        for front, a, b in zip(epoch.fronts, epoch.states, epoch.states[1:], strict=False):
            assert abs((b.stress - a.stress) + bar.rho * front.speed * (b.velocity - a.velocity)) <= 1e-9  # of 10 Pa: momentum
            if front.speed != 0.0:  # compatibility: the strain jumps by -[v] / c
                strain = (b.stress - a.stress) / bar.E + b.plastic_strain - a.plastic_strain
                assert abs(strain + (b.velocity - a.velocity) / front.speed) <= 1e-12  # of 1e-3
        for state in epoch.states:
            assert abs(state.stress) <= state.yield_stress * (1 + 1e-9)
            assert state.yield_stress >= bar.Y


def test_displacement_is_the_integral_of_the_velocity():
    bar = PlasticBarImpact(**BAR, Y=4.0, Et=2500.0)
    X = np.array([0.02, 0.21, 0.37, 0.5])
    t = np.linspace(0.0, 0.03, 3001)
    steps = np.cumsum([bar.velocity(X, s) for s in 0.5 * (t[1:] + t[:-1])], axis=0) * t[1]
    exact = np.array([bar.displacement(X, s) for s in t[1::100]])
    # every front passes within one step: an error of the order of t[1] times the velocity
    assert np.abs(steps[::100] - exact).max() <= 4 * t[1] * 0.1


def test_return_mapping_scheme_converges_to_the_fronts():
    # rate: an independent explicit scheme at Courant number 1 approaches separation momentum and permanent strain
    bar = PlasticBarImpact(**BAR, Y=4.0, Et=2500.0)
    errors = [abs(leapfrog_momentum(n, bar) - 0.5 * bar.mean_velocity(0.012)) / 0.05 for n in (40, 80, 160)]
    assert errors[2] < 0.01
    assert errors[2] < 0.6 * errors[0]


def leapfrog_momentum(n, bar, until=0.012):
    """Momentum at `until` by masses and springs with return mapping, wall at the left."""
    h = bar.L / n
    dt = h / bar.C
    mass = np.full(n + 1, bar.rho * h)
    mass[[0, -1]] *= 0.5
    v = np.full(n + 1, -bar.V0)
    stress, limit = np.zeros(n), np.full(n, bar.Y)
    hardening = bar.E * bar.Et / (bar.E - bar.Et)
    for _ in range(round(until / dt)):
        v += dt * np.diff(np.concatenate([[0.0], stress, [0.0]])) / mass
        v[0] = max(v[0], 0.0)
        trial = stress + bar.E * dt / h * np.diff(v)
        slip = np.maximum(np.abs(trial) - limit, 0.0) / (bar.E + hardening)
        stress = trial - bar.E * slip * np.sign(trial)
        limit = limit + hardening * slip
    return mass @ v


def test_bad_input_is_named():
    with pytest.raises(ParameterError, match=r"Et must be < E = 10000, got 10000"):
        PlasticBarImpact(**BAR, Y=4.0, Et=1e4)
    bar = PlasticBarImpact(**BAR, Y=4.0, Et=2500.0, until=0.005)
    with pytest.raises(ParameterError, match=r"still in contact"):
        _ = bar.separation_time
    with pytest.raises(ParameterError, match=r"give a larger until"):
        bar.stress(0.1, 0.006)
    with pytest.raises(ParameterError, match=r"X must lie in \[0, 0.5\], got 0.6"):
        bar.stress([0.1, 0.6], 0.001)
