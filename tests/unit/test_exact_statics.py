"""Cylinder, column, spinning disk, incline and cell crossing: equilibrium, compatibility, yield and pinned numbers."""

import math

import numpy as np
import pytest

from mpmkit.errors import ParameterError
from mpmkit.exact import (
    BlockOnIncline,
    Column,
    DiskOnIncline,
    PlasticCylinder,
    SpinningDisk,
    SuddenColumn,
    ThickCylinder,
    cell_crossing_force,
    gimp,
    lame,
    nodal_force,
)

EPS = np.finfo(float).eps


def slope(function, x, h=1e-4):
    """Fourth-order central difference."""
    return (8 * (function(x + h) - function(x - h)) - (function(x + 2 * h) - function(x - 2 * h))) / (12 * h)


def radial_balance(solution, r, body_force=0.0):
    """Residual of ds_r/dr + (s_r - s_theta) / r + rho b_r = 0."""
    return slope(solution.stress_r, r) + (solution.stress_r(r) - solution.stress_theta(r)) / r + body_force


def test_thick_cylinder():
    c = ThickCylinder(a=1.0, b=2.0, pressure=0.7, E=1000.0, nu=0.3, outer_pressure=0.2)
    r = np.linspace(1.01, 1.99, 41)
    assert np.abs(radial_balance(c, r)).max() <= 1e-10  # fourth-order differences with h = 1e-4
    assert (float(c.stress_r(1.0)), float(c.stress_r(2.0))) == pytest.approx((-0.7, -0.2), rel=20 * EPS)
    lam, mu = lame(1000.0, 0.3)
    e_r, e_theta = slope(c.displacement, r), c.displacement(r) / r
    assert np.abs(lam * (e_r + e_theta) + 2 * mu * e_r - c.stress_r(r)).max() <= 1e-9
    assert np.abs(lam * (e_r + e_theta) + 2 * mu * e_theta - c.stress_theta(r)).max() <= 1e-9
    assert np.abs(lam * (e_r + e_theta) - c.stress_z).max() <= 1e-9


def test_plastic_cylinder_numbers():
    # pinned, closed forms for a=1 b=2 Y=1: first yield sqrt(3)/4, collapse 2 ln 2 / sqrt(3), p = 0.72078 at c = 1.5
    c = PlasticCylinder(a=1.0, b=2.0, pressure=0.7207815213969602, Y=1.0, E=1000.0)
    assert c.first_yield_pressure == pytest.approx(math.sqrt(3) / 4, rel=4 * EPS)
    assert c.collapse_pressure == pytest.approx(2 * math.log(2) / math.sqrt(3), rel=4 * EPS)
    assert c.plastic_radius == pytest.approx(1.5, rel=1e-12)
    assert c.pressure_at(1.5) == pytest.approx(c.pressure, rel=1e-14)


@pytest.mark.parametrize("pressure", [0.3, 0.5, 0.72, 0.80037])
def test_plastic_cylinder_fields(pressure):
    c = PlasticCylinder(a=1.0, b=2.0, pressure=pressure, Y=1.0, E=1000.0)
    r = np.linspace(1.01, 1.99, 50)
    r = r[np.abs(r - c.plastic_radius) > 1e-3]
    assert np.abs(radial_balance(c, r)).max() <= 1e-10
    assert float(c.stress_r(1.0)) == pytest.approx(-pressure, rel=1e-12)
    assert abs(float(c.stress_r(2.0))) <= 1e-12
    # Mises stress of (s_r, s_theta, their mean) is sqrt(3)/2 (s_theta - s_r): Y inside c, below it outside
    mises = math.sqrt(3) / 2 * (c.stress_theta(r) - c.stress_r(r))
    assert np.allclose(mises[r < c.plastic_radius], 1.0, rtol=1e-12)
    assert np.all(mises[r > c.plastic_radius] < 1.0)
    # stress is continuous at c, and outside c the elastic law with nu = 1/2 gives the hoop strain
    side = np.array([c.plastic_radius - 1e-9, c.plastic_radius + 1e-9])
    if c.plastic_radius > 1.0:
        assert np.ptp(c.stress_r(side)) <= 1e-8 and np.ptp(c.stress_theta(side)) <= 1e-8
    elastic = r[r > c.plastic_radius]
    hoop = (c.stress_theta(elastic) - 0.5 * (c.stress_r(elastic) + c.stress_z(elastic))) / 1000.0
    assert c.displacement(elastic) / elastic == pytest.approx(hoop, rel=1e-12)


@pytest.mark.parametrize("law", ["quadratic", "log", "hencky", "linear"])
def test_column_obeys_its_law(law):
    c = Column(H=50.0, E=1e5, rho=80.0, nu=0.25, law=law)
    lam, mu = lame(1e5, 0.25)
    Y = np.linspace(0.5, 49.5, 30)
    J = c.stretch(Y)
    P = {
        "quadratic": (lam / 2 + mu) * (J - 1 / J),
        "log": lam * np.log(J) / J + mu * (J - 1 / J),
        "hencky": (lam + 2 * mu) * np.log(J) / J,
        "linear": (lam + 2 * mu) * (J - 1),
    }[law]
    assert pytest.approx(-80 * 9.81 * (50 - Y), rel=1e-11) == P
    assert np.abs(1 + slope(c.displacement, Y, 0.05) - J).max() <= 1e-8  # fourth-order differences
    assert c.displacement(0.0) == 0.0
    assert c.stretch(50.0) == pytest.approx(1.0, rel=1e-15)


def test_column_numbers():
    # pinned, independent quadrature of the stretch: H=50 E=1e5 nu=0 rho=80 g=9.81, displacements at mid height and top
    for law, mid, top in (
        ("quadratic", -6.261950713002537, -8.554970852261725),
        ("log", -6.261950713002537, -8.554970852261725),
        ("hencky", -5.161174046001253, -7.229413649310396),
        ("linear", -7.3575, -9.81),
    ):
        column = Column(H=50.0, E=1e5, rho=80.0, law=law)
        assert column.displacement([25.0, 50.0]) == pytest.approx([mid, top], rel=1e-10)


def test_suddenly_loaded_column():
    c = SuddenColumn(H=50.0, modulus=1e5, rho=80.0)
    static = Column(H=50.0, E=1e5, rho=80.0, law="linear")
    Y = np.linspace(1.0, 49.0, 25)
    assert c.period == pytest.approx(200 / math.sqrt(1e5 / 80), rel=4 * EPS)
    assert c.displacement(Y, 0.5 * c.period) == pytest.approx(2 * static.displacement(Y), rel=1e-12)
    assert np.abs(c.displacement(Y, c.period)).max() <= 1e-12
    for t in np.array([0.13, 0.37, 0.61, 0.93]) * c.period:
        fronts = np.abs(np.mod(c.c * t + np.array([[1], [-1]]) * Y + 50, 100) - 50).min(axis=0)
        y = Y[fronts > 1.0]  # away from the fronts, where the second derivatives jump
        k = 1e-4
        balance = c.rho * (c.velocity(y, t + k) - c.velocity(y, t - k)) / (2 * k) - slope(lambda z, t=t: c.stress(z, t), y, 0.1)
        assert np.abs(balance + c.rho * 9.81).max() <= 1e-6 * c.rho * 9.81  # of piecewise quadratic fields: rounding only
        assert np.abs((c.displacement(y, t + k) - c.displacement(y, t - k)) / (2 * k) - c.velocity(y, t)).max() <= 1e-9 * 10
        assert c.stress(y, t) == pytest.approx(1e5 * slope(lambda z, t=t: c.displacement(z, t), y, 0.1), abs=1e-6 * 4e4)
        assert abs(float(c.stress(50.0, t))) <= 1e-9 and c.displacement(0.0, t) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("plane", ["strain", "stress"])
@pytest.mark.parametrize("inner", [0.0, 0.4])
def test_spinning_disk(plane, inner):
    d = SpinningDisk(omega=2.0, R=1.0, E=1e6, nu=0.3, rho=1000.0, plane=plane, inner=inner)
    r = np.linspace(inner + 0.01, 0.99, 40)
    assert np.abs(radial_balance(d, r, 4000.0 * r)).max() <= 1e-6  # of 4000: fourth-order differences
    assert abs(float(d.stress_r(1.0))) <= 1e-11 * 1e3
    if inner > 0.0:
        assert abs(float(d.stress_r(inner))) <= 1e-11 * 1e3
    lam, mu = lame(1e6, 0.3)
    if plane == "stress":
        lam = 2 * lam * mu / (lam + 2 * mu)
    e_r, e_theta = slope(d.displacement, r), d.displacement(r) / r
    assert np.abs(lam * (e_r + e_theta) + 2 * mu * e_r - d.stress_r(r)).max() <= 1e-5  # of 1700 Pa
    assert np.abs(lam * (e_r + e_theta) + 2 * mu * e_theta - d.stress_theta(r)).max() <= 1e-5
    grid = inner + (np.arange(2000) + 0.5) * (1 - inner) / 2000
    momentum = (1000.0 * 2.0 * grid**2 * 2 * np.pi * grid).mean() * (1 - inner)
    assert d.angular_momentum == pytest.approx(momentum, rel=1e-6)  # midpoint rule
    assert d.kinetic_energy == pytest.approx(momentum, rel=1e-6)  # omega / 2 = 1


def test_spinning_disk_numbers():
    # pinned, closed form: (3 + 3/7) / 8 * 4000 Pa at the centre
    d = SpinningDisk(omega=2.0, R=1.0, E=1e6, nu=0.3, rho=1000.0)
    assert (float(d.stress_r(0.0)), float(d.stress_theta(0.0))) == pytest.approx((12000 / 7, 12000 / 7), rel=10 * EPS)
    assert d.displacement([0.0, 1.0]) == pytest.approx([0.0, 5.2e-4], rel=1e-12)


def test_incline():
    block = BlockOnIncline(theta=math.pi / 6, mu=0.3, g=10.0)
    assert block.distance(2.0) == pytest.approx(20.0 * (0.5 - 0.3 * math.sqrt(0.75)), rel=10 * EPS)
    assert not BlockOnIncline(theta=0.29, mu=0.3).slips and BlockOnIncline(theta=0.29, mu=0.3).distance(3.0) == 0.0
    rolling, slipping = DiskOnIncline(theta=math.pi / 6, mu=0.3, R=0.5), DiskOnIncline(theta=math.pi / 3, mu=0.3, R=0.5)
    assert not rolling.slips and slipping.slips
    assert rolling.distance(1.3) == pytest.approx(0.5 * rolling.angle(1.3), rel=10 * EPS)
    for disk in (rolling, slipping):
        # Newton's laws with the moment of inertia m R^2 / 2: friction from the torque explains the acceleration
        friction = 0.5 * disk.R * disk.angular_acceleration
        assert 9.81 * math.sin(disk.theta) - friction == pytest.approx(disk.acceleration, rel=10 * EPS)
        assert friction <= 0.3 * 9.81 * math.cos(disk.theta) * (1 + 4 * EPS)
        energy = 0.5 * disk.velocity(1.3) ** 2 + 0.25 * (disk.R * disk.angular_acceleration * 1.3) ** 2
        slid = disk.distance(1.3) - disk.R * disk.angle(1.3)
        assert 9.81 * math.sin(disk.theta) * disk.distance(1.3) == pytest.approx(energy + friction * slid, rel=20 * EPS)
    # the limit of rolling: both formulas meet at tan(theta) = 3 mu
    below, above = (DiskOnIncline(theta=math.atan(0.9) + d, mu=0.3).acceleration for d in (-1e-9, 1e-9))
    assert below == pytest.approx(above, rel=1e-7)


@pytest.mark.parametrize(
    ("inverse", "expected"),
    [
        # pinned: linear, GIMP of half size 1/4, quadratic and cubic B-spline; exact piecewise polynomials. The linear
        # function loses one whole particle, 1/inverse, wherever particles do not divide the cell evenly.
        (1.0, (0.0, 0.0, 0.0, 0.0)),
        (1.1, (1 / 1.1, 0.2 / 1.21, 0.1 / 1.21, 0.00500876)),
        (1.7, (1 / 1.7, 0.3 / 2.89, 0.3 / 2.89, 0.01221250)),
        (2.0, (0.0, 0.0, 0.0, 0.0)),
        (2.2, (1 / 2.2, 0.2 / 4.84, 0.2 / 4.84, 0.00250438)),
        (3.3, (1 / 3.3, 0.6 / 10.89, 0.3 / 10.89, 0.00166959)),
    ],
)
def test_cell_crossing_force(inverse, expected):
    shapes = ("linear", gimp(0.25), "quadratic B-spline", "cubic B-spline")
    for shape, value in zip(shapes, expected, strict=True):
        found = cell_crossing_force(shape, 1 / inverse)
        assert found == pytest.approx(value, abs=1e-8)
        # no sampled position exceeds it, and the best of many comes near
        sampled = np.abs(nodal_force(shape, 1 / inverse, (np.arange(3001) + 0.37) / 3001)).max()
        assert sampled <= found + 1e-12
        assert sampled >= 0.995 * found
    # particles that fill the bar without gaps feel nothing
    assert cell_crossing_force(gimp(min(0.5, 0.5 / inverse)), 1 / inverse) <= 1e-13


def test_bad_input_is_named():
    with pytest.raises(ParameterError, match=r"ThickCylinder.b must be > a = 2, got 1"):
        ThickCylinder(a=2.0, b=1.0, pressure=1.0, E=1.0, nu=0.3)
    with pytest.raises(ParameterError, match=r"pressure must be <= 0.800377 \(collapse\), got 0.9"):
        PlasticCylinder(a=1.0, b=2.0, pressure=0.9, Y=1.0, E=1.0)
    with pytest.raises(ParameterError, match=r"inner must be < R"):
        SpinningDisk(omega=1.0, R=1.0, E=1.0, nu=0.3, rho=1.0, inner=1.0)
    with pytest.raises(ParameterError, match=r"no shape function named 'lineer'; did you mean 'linear'"):
        cell_crossing_force("lineer", 0.5)
    with pytest.raises(ParameterError, match=r"half_size must be > 0, <= 0.5"):
        gimp(0.7)
    with pytest.raises(ParameterError, match=r"spacing must be > 0"):
        cell_crossing_force("linear", 0.0)
    with pytest.raises(ParameterError, match=r"law must be one of .* got 'henky'; did you mean 'hencky'"):
        Column(H=1.0, E=1.0, rho=1.0, law="henky")
