"""Body forces of the manufactured solutions as scalar functions of one point, made for compilation.

Each factory returns a function that has captured nothing but floats, so Numba compiles it as it stands and a fingerprint of
its code and values identifies it.
"""

from __future__ import annotations

from collections.abc import Callable

from mpmkit.math import cos, fabs, log, sin, sqrt

Point = tuple[float, ...]
Force = tuple[float, float, float]
BodyForce = Callable[[Point, float], Force]


def axis_aligned_body_force(
    A: float, wave: float, omega: float, phases: tuple[float, ...], a: float, q: float, mu: float, rho: float
) -> BodyForce:
    """Body force of `AxisAligned`: the one-, two- or three-dimensional function, as `phases` has entries.

    Parameters
    ----------
    A, wave, omega : float
        Amplitude [m], wave number k pi [1/m], angular frequency [rad/s].
    phases : tuple of float
        One phase per dimension [rad].
    a, q : float
        Coefficients of c(J) = a ln J + q/2 (J^2 - 1) [Pa].
    mu, rho : float
        Shear modulus [Pa] and density [kg/m^3].

    Returns
    -------
    callable
        f(X, t) -> (b_x, b_y, b_z) [m/s^2]; X is a tuple with one float per dimension.
    """
    phase_x, phase_y, phase_z = (*phases, 0.0, 0.0)[:3]

    # For a stretch f of one direction: b = -w^2 u + (m / f^2 + mu) wave^2 u / rho, with m = J c'(J) - c(J) + mu.
    def body_force_1d(X: Point, t: float) -> Force:
        s = A * sin(omega * t + phase_x)
        f = 1.0 + wave * s * cos(wave * X[0])
        m = a + q * f * f - a * log(f) - 0.5 * q * (f * f - 1.0) + mu
        u = s * sin(wave * X[0])
        return ((m / (f * f) + mu) * wave * wave * u / rho - omega * omega * u, 0.0, 0.0)

    def body_force_2d(X: Point, t: float) -> Force:
        sx, sy = A * sin(omega * t + phase_x), A * sin(omega * t + phase_y)
        fx, fy = 1.0 + wave * sx * cos(wave * X[0]), 1.0 + wave * sy * cos(wave * X[1])
        J = fx * fy
        m = a + q * J * J - a * log(J) - 0.5 * q * (J * J - 1.0) + mu
        ux, uy = sx * sin(wave * X[0]), sy * sin(wave * X[1])
        k = wave * wave / rho
        return ((m / (fx * fx) + mu) * k * ux - omega * omega * ux, (m / (fy * fy) + mu) * k * uy - omega * omega * uy, 0.0)

    def body_force_3d(X: Point, t: float) -> Force:
        sx, sy, sz = A * sin(omega * t + phase_x), A * sin(omega * t + phase_y), A * sin(omega * t + phase_z)
        fx, fy, fz = 1.0 + wave * sx * cos(wave * X[0]), 1.0 + wave * sy * cos(wave * X[1]), 1.0 + wave * sz * cos(wave * X[2])
        J = fx * fy * fz
        m = a + q * J * J - a * log(J) - 0.5 * q * (J * J - 1.0) + mu
        ux, uy, uz = sx * sin(wave * X[0]), sy * sin(wave * X[1]), sz * sin(wave * X[2])
        k = wave * wave / rho
        w2 = omega * omega
        return (
            (m / (fx * fx) + mu) * k * ux - w2 * ux,
            (m / (fy * fy) + mu) * k * uy - w2 * uy,
            (m / (fz * fz) + mu) * k * uz - w2 * uz,
        )

    return (body_force_1d, body_force_2d, body_force_3d)[len(phases) - 1]


def vortex_body_force(A: float, w: float, smooth: float, m: float, center_x: float, center_y: float) -> BodyForce:
    """Body force of `Vortex`.

    Parameters
    ----------
    A, w : float
        Largest angle [rad] and angular frequency of g [rad/s].
    smooth : float
        0 for g = A sin(w t), 1 for g = A (1 - cos(w t)) / 2.
    m : float
        Shear modulus over density [m^2/s^2].
    center_x, center_y : float
        Centre of the ring [m].

    Returns
    -------
    callable
        f(X, t) -> (b_x, b_y, 0) [m/s^2]; X is a tuple of two floats.
    """

    def body_force(X: Point, t: float) -> Force:
        x, y = X[0] - center_x, X[1] - center_y
        R = sqrt(x * x + y * y)
        if fabs(R - 1.0) > 0.25:
            return (0.0, 0.0, 0.0)
        if smooth == 0.0:
            g, rate, second = A * sin(w * t), A * w * cos(w * t), -A * w * w * sin(w * t)
        else:
            g, rate, second = 0.5 * A * (1.0 - cos(w * t)), 0.5 * A * w * sin(w * t), 0.5 * A * w * w * cos(w * t)
        p = R - 1.0
        s = 1.0 - 16.0 * p * p
        h, slope, curvature = s * s, -64.0 * p * s, -64.0 * s + 2048.0 * p * p
        along = second * h - m * g * (3.0 * slope / R + curvature)
        inward = m * (g * slope) * (g * slope) - (rate * h) * (rate * h)
        ca, sa = cos(g * h), sin(g * h)
        rx, ry = ca * x - sa * y, sa * x + ca * y
        return (inward * rx - along * ry, inward * ry + along * rx, 0.0)

    return body_force
