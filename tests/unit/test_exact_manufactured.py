"""Manufactured solutions: kinematics and equation of motion by finite differences, pinned points, and the compiled body force."""

import numpy as np
import pytest

from mpmkit.errors import ParameterError
from mpmkit.exact import AxisAligned, Vortex
from mpmkit.exact.hyperelastic import cauchy, energy, first_piola, lame

EPS = np.finfo(float).eps
FORMS = ("log", "quadratic")
SOLUTIONS = [
    *(
        pytest.param(AxisAligned(dim=dim, form=form, k=k), id=f"aligned {dim}D {form} k={k}")
        for dim in (1, 2, 3)
        for form in FORMS
        for k in (1, 2)
    ),
    *(
        pytest.param(Vortex(A=A, T=0.7, start=start, form=form, center=(0.1, -0.2)), id=f"vortex A={A} {start} {form}")
        for A, start, form in ((0.2, "sin", "log"), (1.0, "smooth", "quadratic"))
    ),
]


def points(solution, n=60):
    rng = np.random.default_rng(7)
    if isinstance(solution, AxisAligned):
        return rng.uniform(0.02, 0.98, (n, solution.dim))
    R, angle = rng.uniform(0.77, 1.23, n), rng.uniform(0, 2 * np.pi, n)
    return np.stack([R * np.cos(angle), R * np.sin(angle)], axis=1) + np.array(solution.center)


def times(solution):
    return np.array([0.11, 0.37, 0.83]) * (solution.period if isinstance(solution, AxisAligned) else solution.T)


def gradient(function, X, h=1e-3):
    """Fourth-order central difference of function(X) in each reference direction; the direction is the last axis."""
    out = []
    for a in range(X.shape[1]):
        step = h * np.eye(X.shape[1])[a]
        out.append((8 * (function(X + step) - function(X - step)) - (function(X + 2 * step) - function(X - 2 * step))) / (12 * h))
    return np.stack(out, axis=-1)


@pytest.mark.parametrize("solution", SOLUTIONS)
def test_equation_of_motion(solution):
    # rate: fourth-order differences of the stress; the tolerance is h^4 times the derivatives of the profile, checked to
    # fall by 16 as h is halved
    X, dim = points(solution), solution.dim
    for t in times(solution):
        residuals = []
        for h in (2e-3, 1e-3):
            div = np.einsum("niaa->ni", gradient(lambda Y, t=t: solution.first_piola(Y, t)[:, :dim, :dim], X, h))
            residuals.append(
                np.abs(solution.rho * (solution.acceleration(X, t) - solution.body_force(X, t)) - div).max() / np.abs(div).max()
            )
        assert residuals[1] < 1e-5
        assert residuals[1] < residuals[0] / 12 or residuals[1] < 1e-10


@pytest.mark.parametrize("solution", SOLUTIONS)
def test_kinematics(solution):
    X, dim = points(solution), solution.dim
    for t in times(solution):
        F = solution.F(X, t)
        gradient_of_u = gradient(lambda Y, t=t: solution.displacement(Y, t), X)
        assert np.abs(F[:, :dim, :dim] - np.eye(dim) - gradient_of_u).max() < 1e-6 * max(1.0, np.abs(F).max())
        k = 1e-4 * (solution.period if isinstance(solution, AxisAligned) else solution.T)
        v = (solution.displacement(X, t + k) - solution.displacement(X, t - k)) / (2 * k)
        a = (solution.velocity(X, t + k) - solution.velocity(X, t - k)) / (2 * k)
        # second-order differences: (2 pi 1e-4)^2 / 6 of the derivative, times a few for the turning of the vortex
        assert np.abs(v - solution.velocity(X, t)).max() < 3e-6 * np.abs(v).max()
        assert np.abs(a - solution.acceleration(X, t)).max() < 3e-6 * np.abs(a).max()
        assert np.array_equal(solution.position(X, t), X + solution.displacement(X, t))
        assert np.all(F[:, 2, 2] == 1.0) or dim == 3


@pytest.mark.parametrize("solution", SOLUTIONS)
def test_compiled_body_force_agrees(solution):
    numba = pytest.importorskip("numba")
    plain = solution.body_force_kernel()
    # nothing but floats may be captured, so that the function can be compiled and identified by its values
    assert all(type(cell.cell_contents) is float for cell in plain.__closure__)
    compiled = numba.njit(plain)
    X = points(solution, 25)
    for t in times(solution):
        exact = solution.body_force(X, t)
        scale = np.abs(exact).max() + np.abs(solution.acceleration(X, t)).max()
        for function in (plain, compiled):
            b = np.array([function(tuple(float(c) for c in p), float(t)) for p in X])
            assert b.shape == (25, 3)
            # rounding: a few hundred operations; both terms of b nearly cancel in places, hence the scale
            assert np.abs(b[:, : solution.dim] - exact).max() <= 200 * EPS * scale
            assert np.all(b[:, solution.dim :] == 0.0)


def test_aligned_points():
    # pinned, E=1e7 nu=0.3 rho=1000 A=0.05 k=1, t=0.0037: an independent symbolic derivation
    X = [[0.1, 0.2], [0.9, 0.15]]
    for form, b in (
        ("log", [[176.70764029720772, -1633.168324975959], [1255.0382883623845, -1782.375096513576]]),
        ("quadratic", [[182.31043086026784, -1650.8268653813034], [710.5221885417029, -998.2152794111548]]),
    ):
        solution = AxisAligned(form=form)
        assert solution.body_force(X, 0.0037) == pytest.approx(np.array(b), rel=1e-11)
        u = [[0.014180088800128438, -0.026972131710012157], [0.014180088800128445, -0.020832594057627565]]
        assert solution.displacement(X, 0.0037) == pytest.approx(np.array(u), rel=1e-12)
        assert solution.period == pytest.approx(0.02, rel=4 * EPS)


def test_aligned_faces_are_rollers():
    solution = AxisAligned(dim=3)
    X = np.random.default_rng(1).uniform(0, 1, (20, 3))
    for axis in range(3):
        for face in (0.0, 1.0):
            X[:, axis] = face
            assert np.abs(solution.displacement(X, 0.003)[:, axis]).max() <= 4 * EPS * 0.05
    stress = solution.stress(X, 0.003)
    assert np.all(stress[:, [0, 0, 1], [1, 2, 2]] == 0.0)


@pytest.mark.parametrize("form", FORMS)
def test_vortex_edges_are_free_and_volume_is_kept(form):
    solution = Vortex(A=1.0, form=form)
    angle = np.linspace(0, 6, 13)
    for R in (0.75, 1.25):
        X = R * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        traction = np.einsum("nij,nj->ni", solution.stress(X, 0.4)[:, :2, :2], X / R)
        assert np.abs(traction).max() <= 1e-10 * 1000.0  # the slope at the edge is rounding
        assert np.abs(solution.displacement(X, 0.4)).max() <= 1e-14
    X = points(solution)
    assert np.abs(np.linalg.det(solution.F(X, 0.4)) - 1.0).max() <= 1e-12
    X = np.array([[0.0, 0.0], [0.3, 0.2], [1.5, 0.0]])
    assert np.all(solution.body_force(X, 0.4) == 0.0) and np.all(solution.velocity(X, 0.4) == 0.0)


def test_vortex_turns_the_middle_by_A():
    X = np.array([[1.0, 0.0]])
    for start in ("sin", "smooth"):
        solution = Vortex(A=0.6, T=2.0, start=start)
        assert solution.position(X, 1.0)[0] == pytest.approx([np.cos(0.6), np.sin(0.6)], rel=1e-14)
        assert np.abs(solution.displacement(X, 2.0)).max() <= 1e-15
    assert np.all(Vortex(start="smooth").velocity(X, 0.0) == 0.0)
    assert Vortex(A=0.6, T=2.0).velocity(X, 0.0)[0] == pytest.approx([0.0, 0.3 * np.pi], rel=1e-14)


@pytest.mark.parametrize("form", FORMS)
def test_stress_is_the_derivative_of_the_energy(form):
    lam, mu = lame(1000.0, 0.3)
    rng = np.random.default_rng(3)
    F = np.eye(3) + 0.3 * rng.uniform(-1, 1, (20, 3, 3))
    P = first_piola(F, lam, mu, form)
    numeric = np.empty_like(P)
    for i in range(3):
        for j in range(3):
            d = np.zeros((3, 3))
            d[i, j] = 1e-5
            numeric[:, i, j] = (energy(F + d, lam, mu, form) - energy(F - d, lam, mu, form)) / 2e-5
    assert np.abs(numeric - P).max() < 1e-6 * np.abs(P).max()  # second-order differences with a step of 1e-5
    assert np.abs(first_piola(np.eye(3)[None], lam, mu, form)).max() <= 4 * EPS * 1000


def test_energy_and_stress_in_uniaxial_stretch():
    # pinned, by hand for F = diag(1.2, 1, 1), E = 1000, nu = 0.3
    F = np.diag([1.2, 1.0, 1.0])[None]
    lam, mu = lame(1000.0, 0.3)
    assert cauchy(F, lam, mu, "quadratic")[0].diagonal() == pytest.approx(
        [246.79487179487174, 105.76923076923075, 105.76923076923075], rel=1e-13
    )
    assert cauchy(F, lam, mu, "log")[0].diagonal() == pytest.approx([228.68023563811917, 87.65459461247816, 87.65459461247816], rel=1e-13)
    assert energy(F, lam, mu, "quadratic") == pytest.approx([25.360490619453614], rel=1e-13)
    assert energy(F, lam, mu, "log") == pytest.approx([24.080502215336068], rel=1e-13)


def test_bad_input_is_named():
    with pytest.raises(ParameterError, match=r"A must be < 1 / "):
        AxisAligned(A=0.2, k=2)
    with pytest.raises(ParameterError, match=r"form must be one of 'quadratic', 'log', got 'lag'; did you mean 'log'"):
        AxisAligned(form="lag")
    with pytest.raises(ParameterError, match=r"X must have the shape \(n, 3\), got \(4, 2\)"):
        AxisAligned(dim=3).displacement(np.zeros((4, 2)), 0.0)
    with pytest.raises(ParameterError, match=r"center must have 2 numbers"):
        Vortex(center=(0.0, 0.0, 0.0))
    with pytest.raises(ParameterError, match=r"nu must be > -1, < 0.5, got 0.5"):
        lame(1.0, 0.5)
