"""The words of constitutive laws against numpy. Rounding everywhere: 1e-13 of numbers of size 1, unless said otherwise."""

import numpy as np
import pytest
from scipy.linalg import expm

from mpmkit import tensor

RNG = np.random.default_rng(7)
A, B = RNG.uniform(-1, 1, (2, 3, 3))
S = A + A.T
NEAR = 1e-13


def nine(M):
    return tuple(M.ravel().tolist())


def six(M):
    return (M[0, 0], M[1, 1], M[2, 2], M[0, 1], M[1, 2], M[0, 2])


def full(r):
    return np.array(r).reshape(3, 3)


def test_products_and_inverse():
    assert tensor.det(nine(A)) == pytest.approx(np.linalg.det(A), abs=NEAR)
    assert full(tensor.matmul(nine(A), nine(B))) == pytest.approx(A @ B, abs=NEAR)
    assert full(tensor.transpose(nine(A))) == pytest.approx(A.T)
    assert full(tensor.inverse(nine(A))) == pytest.approx(np.linalg.inv(A), abs=NEAR * np.linalg.cond(A) ** 2)
    assert full(tensor.combine(2.0, nine(A), -0.5, nine(B))) == pytest.approx(2 * A - 0.5 * B, abs=NEAR)


def test_symmetric_tensors():
    assert tensor.sym(nine(A)) == pytest.approx(six((A + A.T) / 2), abs=NEAR)
    assert tensor.left_cauchy_green(nine(A)) == pytest.approx(six(A @ A.T), abs=NEAR)
    assert tensor.trace(six(S)) == pytest.approx(np.trace(S), abs=NEAR)
    assert tensor.dev(six(S)) == pytest.approx(six(S - np.trace(S) / 3 * np.eye(3)), abs=NEAR)
    assert tensor.ddot(six(S), six(B + B.T)) == pytest.approx(np.sum(S * (B + B.T)), abs=NEAR)
    assert tensor.norm(six(S)) == pytest.approx(np.linalg.norm(S), abs=NEAR)
    assert tensor.add(six(S), six(S)) == pytest.approx(tensor.scale(2.0, six(S)))
    assert tensor.add_diagonal(six(S), 3.0) == pytest.approx(six(S + 3 * np.eye(3)))


def test_von_mises_of_uniaxial_stress_is_that_stress():
    assert tensor.von_mises((-7.0, 0.0, 0.0, 0.0, 0.0, 0.0)) == pytest.approx(7.0, rel=1e-15)
    assert tensor.von_mises((0.0, 0.0, 0.0, 2.0, 0.0, 0.0)) == pytest.approx(2.0 * np.sqrt(3.0), rel=1e-15)


def test_jaumann_is_the_commutator_with_the_spin():
    W = (B - B.T) / 2
    assert tensor.spin(nine(B)) == pytest.approx((W[0, 1], W[1, 2], W[0, 2]), abs=NEAR)
    assert tensor.jaumann(six(S), nine(B)) == pytest.approx(six(W @ S - S @ W), abs=NEAR)


def test_rotate():
    assert tensor.rotate(nine(A), six(S)) == pytest.approx(six(A @ S @ A.T), abs=NEAR)


@pytest.mark.parametrize("dt", [1e-6, 1e-2, 0.1, 1.0, 30.0])
def test_rotation_is_orthogonal_and_the_exponential_of_the_spin(dt):
    """Orthogonal to rounding for any angle; the exponential to order angle^9 (tried up to about 1/2)."""
    R = full(tensor.rotation(nine(B), dt))
    assert R @ R.T == pytest.approx(np.eye(3), abs=NEAR)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=NEAR)
    W = dt * (B - B.T) / 2
    angle = np.linalg.norm(W) / np.sqrt(2)
    if angle < 0.5:
        assert R == pytest.approx(expm(W), abs=NEAR + 1e-3 * angle**9)


@pytest.mark.parametrize(
    "M",
    [
        pytest.param(S, id="random"),
        pytest.param(-S, id="negative"),
        pytest.param(np.eye(3), id="unit"),
        pytest.param(np.zeros((3, 3)), id="zero"),
        pytest.param(np.diag([1.0, 2.0, 2.0]), id="double largest"),
        pytest.param(np.diag([2.0, 1.0, 1.0]), id="double smallest"),
        pytest.param(np.diag([1.0, 1.0 + 1e-9, 1.0]), id="nearly unit"),
        pytest.param(1e60 * S, id="large"),
        pytest.param(1e-20 * S, id="small"),
    ],
)
def test_largest_eigenvalue(M):
    """Rounding: 1e-14 of the norm, 1e-8 where two eigenvalues coincide (the root of machine epsilon, as for any root of a cubic)."""
    wanted = np.linalg.eigvalsh(M)
    size = np.linalg.norm(M)
    double = min(np.diff(wanted)) < 1e-6 * size
    assert tensor.largest_eigenvalue(six(M)) == pytest.approx(wanted[-1], abs=(1e-8 if double else 1e-14) * size)


@pytest.mark.parametrize("seed", range(20))
def test_bound_of_the_largest_eigenvalue(seed):
    """Never below it (rounding, 1e-14 of the norm), and equal to it where the other two are equal."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(3, 3))
    M = A + A.T
    assert tensor.largest_eigenvalue_bound(six(M)) >= np.linalg.eigvalsh(M)[-1] - 1e-14 * np.linalg.norm(M)
    Q = np.linalg.qr(A)[0]
    M = Q @ np.diag([2.0, -1.0, -1.0]) @ Q.T
    assert tensor.largest_eigenvalue_bound(six(M)) == pytest.approx(2.0, abs=1e-14 * np.linalg.norm(M))


def test_cosine_of_a_third():
    """Rounding: 4e-16, what it promises."""
    r = np.concatenate([np.linspace(-1.0, 1.0, 1001), 1.0 - np.logspace(-16, -1, 100), np.logspace(-16, -1, 100) - 1.0])
    wanted = np.cos(np.arccos(r.astype(np.longdouble)) / 3)
    assert np.abs(np.array([tensor.cosine_of_a_third(float(v)) for v in r]) - wanted).max() < 4e-16
