"""Kernels that laws in rate form share: the elastic increment, its stored energy and the wave speed."""

import mpmkit as mpm
from mpmkit.math import sqrt
from mpmkit.tensor import add, add_diagonal, ddot, dev, norm, rotate, rotation, scale, sym, trace


def elastic_increment(L, dt, lam, mu):
    """dt C : D = dt (lam tr(D) I + 2 mu D) with D = sym(L)."""
    D = sym(L)
    return add_diagonal(scale(2.0 * mu * dt, D), lam * dt * trace(D))


def jaumann_step(stress, L, dt, lam, mu):
    """One step of d(sigma)/dt = W sigma - sigma W + C : D, second order in dt.

    The old stress and half of the elastic increment turn with the spin, the other half does not (trapezoidal rule); the rotation is
    exactly orthogonal, so that a rigid rotation leaves the invariants alone.
    """
    half = scale(0.5, elastic_increment(L, dt, lam, mu))
    return add(rotate(rotation(L, dt), add(stress, half)), half)


@mpm.kernel
def rate_energy(stress, J, lam, mu):
    """W = J sigma : S : sigma / 2 = J [p^2 / (2 K) + s : s / (4 mu)], per initial volume."""
    p = (1.0 / 3.0) * trace(stress)
    s = dev(stress)
    return J * (0.5 * p * p / (lam + (2.0 / 3.0) * mu) + 0.25 * ddot(s, s) / mu)


@mpm.kernel
def rate_wave_speed(J, stress, lam, mu, rho):
    """Bound: rho0 c^2 / J = lam + 2 mu + |dev sigma| / sqrt(2)."""
    return sqrt((lam + 2.0 * mu + sqrt(0.5) * norm(dev(stress))) * J / rho)


@mpm.kernel
def bar_rate_energy(stress, J, E):
    """W = J sigma_xx^2 / (2 E)."""
    return 0.5 * J * stress[0] * stress[0] / E


@mpm.kernel
def bar_rate_wave_speed(J, E, rho):
    """c^2 = E J / rho0."""
    return sqrt(E * J / rho)
