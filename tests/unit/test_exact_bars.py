"""Exact elastic bars, vibration and interfaces: wave equation, energy, end conditions, and the numbers of the report's tests."""

import math

import numpy as np
import pytest

from mpmkit.errors import ParameterError
from mpmkit.exact import BarImpact, ForcedBar, Interface, Pulse, SmoothPulse, Step, VibratingBar, impedance

BAR = {"L": 1.0, "E": 1e4, "rho": 1.0}  # C = 100 m/s, so a wave needs 0.01 s
EPS = np.finfo(float).eps


def bars():
    smooth = SmoothPulse(magnitude=2.0, duration=0.004)
    yield "fixed-pulled", ForcedBar(**BAR, right=smooth)
    yield "free-pulled", ForcedBar(**BAR, right=smooth, left="free")
    yield "both pulled", ForcedBar(**BAR, right=smooth, left=SmoothPulse(magnitude=-1.0, duration=0.006))
    yield "pulled-fixed", ForcedBar(**BAR, right="fixed", left=smooth)


CASES = [pytest.param(bar, id=name) for name, bar in bars()]


@pytest.mark.parametrize("bar", CASES)
def test_fields_satisfy_the_wave_equation(bar):
    # rate: the residuals of rho v_t = s_x and s_t = E v_x by central differences fall with the square of the step
    x = np.linspace(0.05, 0.95, 37)[:, None]
    t = np.linspace(0.001, 0.055, 61)[None, :]

    def residual(h):
        k = h / bar.C
        v_t = (bar.velocity(x, t + k) - bar.velocity(x, t - k)) / (2 * k)
        s_x = (bar.stress(x + h, t) - bar.stress(x - h, t)) / (2 * h)
        s_t = (bar.stress(x, t + k) - bar.stress(x, t - k)) / (2 * k)
        v_x = (bar.velocity(x + h, t) - bar.velocity(x - h, t)) / (2 * h)
        u_t = (bar.displacement(x, t + k) - bar.displacement(x, t - k)) / (2 * k)
        return [np.abs(bar.rho * v_t - s_x).mean(), np.abs(s_t - bar.E * v_x).mean() / bar.C, np.abs(u_t - bar.velocity(x, t)).mean()]

    # Each residual is small against its terms; a wrong sign of any wave would leave it of their size.
    scale = [bar.rho * 2.0 * np.pi / 0.004 / bar.Z, bar.rho * 2.0 * np.pi / 0.004 / bar.Z, 2.0 / bar.Z]
    coarse, fine = residual(4e-3), residual(1e-3)
    for c, f, s in zip(coarse, fine, scale, strict=True):
        assert f < 2e-3 * s
        assert f < c / 8 or f < 1e-12 * s


@pytest.mark.parametrize("bar", CASES)
def test_end_conditions_hold(bar):
    t = np.linspace(0.0, 0.07, 301)
    for end, x in (("left", 0.0), ("right", bar.L)):
        what = getattr(bar, end)
        if what == "fixed":  # rounding, times the velocity of the waves
            assert np.abs(bar.velocity(x, t)).max() <= 50 * EPS * 2.0 / bar.Z
            assert np.abs(bar.displacement(x, t)).max() <= 50 * EPS * 2.0 / bar.Z * 0.01
        else:  # near-rounding: arrival times are rounded before the traction is evaluated, slope 2 pi / 4 ms
            wanted = 0.0 if what == "free" else what.value(t)
            assert np.abs(bar.stress(x, t) - wanted).max() <= 1e-11


@pytest.mark.parametrize("bar", CASES)
def test_energy_equals_the_work_of_the_tractions(bar):
    # midpoint rule in space and time: the smooth pulse makes its error O(h^2), 1e-4 of the energy
    n = 2000
    x = (np.arange(n) + 0.5) * bar.L / n
    times = (np.arange(8 * n) + 0.5) * 0.04 / (8 * n)
    work = sum(
        sign * what.value(times) * bar.velocity(end, times)
        for what, end, sign in ((bar.right, bar.L, 1.0), (bar.left, 0.0, -1.0))
        if not isinstance(what, str)
    ).sum() * (0.04 / (8 * n))
    energy = 0.5 * (bar.rho * bar.velocity(x, 0.04) ** 2 + bar.stress(x, 0.04) ** 2 / bar.E).mean() * bar.L
    assert energy > 1e-6
    assert energy == pytest.approx(work, rel=1e-4)


def test_fixed_bar_pulled_by_a_step():
    # pinned, SAND2002-0482 section 4, first test: stress in {0, 1, 2}, period 4 L / C, end moves 0 .. 2 f L / E
    bar = ForcedBar(**BAR, right=Step(1.0))
    assert bar.period == pytest.approx(0.04, rel=4 * EPS)
    assert bar.stress(0.75, 0.005) == 1.0 and bar.stress(0.25, 0.005) == 0.0 and bar.stress(0.5, 0.02 - 1e-6) == 2.0
    assert bar.displacement(1.0, 0.02) == pytest.approx(2e-4, rel=10 * EPS)
    assert bar.displacement(1.0, [0.01, 0.03]) == pytest.approx([1e-4, 1e-4], rel=10 * EPS)
    t = np.linspace(1e-3, 0.035, 13) + 1e-5
    x = np.linspace(0.05, 0.95, 9)[:, None]
    assert set(np.unique(bar.stress(x, t))) <= {0.0, 1.0, 2.0}
    assert np.array_equal(bar.stress(x, t), bar.stress(x, t + bar.period))


def test_bar_pressed_at_both_ends_by_pulses():
    # pinned, SAND2002-0482 section 4: at t = 1.5 L / C stress and displacement vanish and velocities are +-2 f / (rho C)
    bar = ForcedBar(**BAR, right=Pulse(-1.0, 0.01), left=Pulse(-1.0, 0.01))
    x = np.linspace(0.02, 0.98, 24)  # without the middle, where two fronts are just meeting
    assert bar.period == pytest.approx(0.02, rel=4 * EPS)
    assert np.all(bar.stress(x, 0.015) == 0.0)
    assert np.abs(bar.displacement(x, 0.015)).max() <= 10 * EPS * 1e-4
    assert np.allclose(np.abs(bar.velocity(x, 0.015)), 0.02, rtol=4 * EPS, atol=0)
    assert np.abs(bar.stress(np.linspace(0, 1, 101)[:, None], np.linspace(0, 0.02, 101))).max() == 2.0


def test_bar_pulled_at_both_ends_keeps_its_centre():
    bar = ForcedBar(**BAR, right=Step(1.0), left=Step(1.0))
    assert np.abs(bar.displacement(0.5, np.linspace(0, 0.1, 57))).max() <= 50 * EPS * 1e-3


def test_free_bar_pulled_at_one_end_accelerates_as_a_whole():
    # two bars parted by an empty cell are two such bars: mean acceleration f / (rho L) = 2 for L = 0.5
    bar = ForcedBar(L=0.5, E=1e4, rho=1.0, right=Step(1.0), left="free")
    x = (np.arange(400) + 0.5) / 800
    for t in (0.0031, 0.0123, 0.0377):
        assert bar.velocity(x, t).mean() == pytest.approx(2.0 * t, rel=2e-3)  # midpoint rule across one front


def test_elastic_impact_numbers():
    # pinned, closed forms of the report's impact test: t_c = gap / (2 V0), duration 2 L / C, stress -rho C V0, restitution 1
    impact = BarImpact(V0=0.1, L=0.5, gap=0.5, E=1e4, rho=1.0)
    assert (impact.contact_time, impact.duration) == pytest.approx((2.5, 0.01), rel=4 * EPS)
    assert impact.contact_stress == pytest.approx(-10.0, rel=4 * EPS)
    assert impact.restitution == 1.0
    assert impact.kinetic_energy(0.0) == pytest.approx(0.005, rel=4 * EPS)
    assert impact.kinetic_energy(2.505) == pytest.approx(0.0, abs=1e-14 * 0.005 * 2.5 / 0.005)
    assert impact.kinetic_energy(3.0) == impact.kinetic_energy(0.0)


def test_elastic_impact_agrees_with_its_fields():
    impact = BarImpact(V0=0.1, L=0.5, gap=0.02, E=1e4, rho=1.0)
    x = (np.arange(1000) + 0.5) * 0.5 / 1000
    x = np.concatenate([x, x + 0.52])
    for t in impact.contact_time + np.array([-0.05, 0.0013, 0.0049, 0.0081, 0.02]):
        v, s = impact.velocity(x, t), impact.stress(x, t)
        assert abs(v.mean()) <= 10 * EPS * 0.1  # momentum, exactly balanced by symmetry
        # midpoint rule: each of the two fronts is located to one of 1000 intervals
        assert 0.5 * v @ v * 5e-4 == pytest.approx(impact.kinetic_energy(t), abs=2e-3 * 0.005)
        assert 0.5 * s @ s / 1e4 * 5e-4 == pytest.approx(impact.strain_energy(t), abs=2e-3 * 0.005)
    t = np.linspace(0.0, 0.13, 40001)
    for point in (0.1, 0.5, 0.6, 1.02):  # the displacement is the integral of the velocity
        steps = np.cumsum(impact.velocity(point, 0.5 * (t[1:] + t[:-1]))) * t[1]
        assert np.abs(steps - impact.displacement(point, t[1:])).max() <= 2 * t[1] * 0.1
    # while in contact the two faces are at one place
    during = impact.contact_time + np.linspace(0, 0.01, 11)
    assert 0.5 + impact.displacement(0.5, during) == pytest.approx(0.52 + impact.displacement(0.52, during), abs=1e-15)


@pytest.mark.parametrize("ends", ["fixed-free", "fixed-fixed"])
@pytest.mark.parametrize("mode", [1, 2, 3])
def test_vibrating_bar_equation_and_ends(ends, mode):
    bar = VibratingBar(L=25.0, E=100.0, rho=1.0, v0=0.1, mode=mode, ends=ends)
    x, h, k = np.linspace(1, 24, 24)[:, None], 1e-3, 1e-4
    t = np.linspace(0.1, 2.0, 9) * bar.period
    s_x = (bar.stress(x + h, t) - bar.stress(x - h, t)) / (2 * h)
    v_t = (bar.velocity(x, t + k) - bar.velocity(x, t - k)) / (2 * k)
    u_x = (bar.displacement(x + h, t) - bar.displacement(x - h, t)) / (2 * h)
    u_t = (bar.displacement(x, t + k) - bar.displacement(x, t - k)) / (2 * k)
    scale = bar.omega * 0.1  # second-order differences: (b h)^2 / 6 and (w k)^2 / 6 are below 1e-7
    assert np.abs(v_t - s_x).max() <= 1e-6 * scale
    assert np.abs(bar.E * u_x - bar.stress(x, t)).max() <= 1e-6 * 1.0
    assert np.abs(u_t - bar.velocity(x, t)).max() <= 1e-6 * 0.1
    assert np.all(bar.velocity(0.0, t) == 0.0)
    free_end = bar.stress(25.0, t) if ends == "fixed-free" else bar.velocity(25.0, t)
    assert np.abs(free_end).max() <= 20 * EPS
    grid = (np.arange(4000) + 0.5) * 25 / 4000
    for time in t[:3]:  # midpoint rule, error (pi mode / 4000)^2
        energy = 0.5 * (bar.velocity(grid, time) ** 2 + bar.stress(grid, time) ** 2 / 100).mean() * 25
        assert energy == pytest.approx(bar.energy, rel=1e-5)
        assert bar.velocity(grid, time).mean() == pytest.approx(bar.mean_velocity(time), abs=1e-6)


def test_vibrating_bar_numbers():
    # pinned, closed forms: w = pi/50 * 10, v_cm = 0.2/pi cos(w t), energy 1/16
    bar = VibratingBar(L=25.0, E=100.0, rho=1.0, v0=0.1)
    assert (bar.period, bar.omega, bar.energy) == pytest.approx((10.0, math.pi / 5, 0.0625), rel=4 * EPS)
    assert bar.mean_velocity([0.0, 5.0]) == pytest.approx([0.2 / math.pi, -0.2 / math.pi], rel=10 * EPS)


@pytest.mark.parametrize(("Z1", "Z2"), [(100.0, 100.0), (100.0, 1.0), (3.0, 700.0), (5.0, 0.0)])
def test_interface_jump_conditions(Z1, Z2):
    face = Interface(Z1=Z1, Z2=Z2)
    r, t = face.reflection, face.transmission
    assert 1.0 + r == pytest.approx(t, abs=4 * EPS)  # stress is continuous
    if Z2 > 0.0:
        assert (1.0 - r) / Z1 == pytest.approx(t / Z2, rel=40 * EPS)  # velocity is continuous
        assert r**2 / Z1 + t**2 / Z2 == pytest.approx(1.0 / Z1, rel=10 * EPS)  # energy flux is kept
        stress, velocity = face.impact_stress(2.0, -1.0), face.impact_velocity(2.0, -1.0)
        assert stress == pytest.approx(-Z1 * (2.0 - velocity), rel=10 * EPS)  # jump condition of each body
        assert stress == pytest.approx(-Z2 * (velocity + 1.0), rel=10 * EPS)
    assert face.impact_stress(-1.0, 1.0) == 0.0
    assert impedance(1e4, 1.0) == 100.0


def test_bad_input_is_named():
    with pytest.raises(ParameterError, match=r"ForcedBar.L must be > 0"):
        ForcedBar(L=0.0, E=1.0, rho=1.0)
    with pytest.raises(ParameterError, match=r"left must be one of 'fixed', 'free', got 'fixd'; did you mean 'fixed'"):
        ForcedBar(**BAR, left="fixd")
    with pytest.raises(ParameterError, match=r"x must lie in \[0, 1\], got 1.5"):
        ForcedBar(**BAR).stress([0.5, 1.5], 0.0)
    with pytest.raises(ParameterError, match=r"must lie in a bar"):
        BarImpact(V0=0.1, L=0.5, gap=0.5, E=1e4, rho=1.0).stress(0.7, 0.0)
    with pytest.raises(ParameterError, match=r"the bodies part"):
        Interface(Z1=1.0, Z2=1.0).impact_velocity(0.0, 1.0)
    with pytest.raises(ParameterError, match=r"modulus must be > 0"):
        impedance(-1.0, 1.0)
    assert ForcedBar(L="50 cm", E="10 kPa", rho=1.0).L == 0.5
