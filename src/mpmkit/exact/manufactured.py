"""Manufactured solutions of large-deformation elastodynamics: a motion is chosen, the body force that it needs follows.

rho0 a = Div P + rho0 b gives the body force b per unit of mass, in closed form. Both solutions come with a scalar
function for it that Numba can compile, so that it can be applied to every particle in every step.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from mpmkit.errors import ParameterError
from mpmkit.exact.body_force import BodyForce, axis_aligned_body_force, vortex_body_force
from mpmkit.exact.hyperelastic import FORMS, cauchy, embed, first_piola, lame, volume_coefficients
from mpmkit.exact.solution import Array, Solution
from mpmkit.parameters import Vector, define, parameter


class Manufactured(Solution, ABC):
    """Base of both: a motion with its stress. Methods take X, reference positions float64[n, dim] [m], and a time t [s]."""

    E: float
    nu: float
    rho: float
    form: str
    dim: int

    @property
    def lame(self) -> tuple[float, float]:
        """Lame's constants (lambda, mu) [Pa]."""
        return lame(self.E, self.nu)

    def _points(self, X: ArrayLike) -> Array:
        points = np.asarray(X, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != self.dim:
            raise ParameterError(f"{type(self).__name__}: X must have the shape (n, {self.dim}), got {points.shape}")
        return points

    @abstractmethod
    def displacement(self, X: ArrayLike, t: float) -> Array:
        """Displacement u, float64[n, dim] [m]."""

    @abstractmethod
    def velocity(self, X: ArrayLike, t: float) -> Array:
        """Velocity du/dt, float64[n, dim] [m/s]."""

    @abstractmethod
    def acceleration(self, X: ArrayLike, t: float) -> Array:
        """Acceleration, float64[n, dim] [m/s^2]."""

    @abstractmethod
    def F(self, X: ArrayLike, t: float) -> Array:
        """Deformation gradient, float64[n, 3, 3] [1]."""

    @abstractmethod
    def body_force(self, X: ArrayLike, t: float) -> Array:
        """Body force per mass b, float64[n, dim] [m/s^2]."""

    @abstractmethod
    def body_force_kernel(self) -> BodyForce:
        """The body force as a scalar function f(X, t): X is a tuple of dim floats, the result one of three; Numba can compile it."""

    def position(self, X: ArrayLike, t: float) -> Array:
        """Current position x = X + u, float64[n, dim] [m]."""
        return np.asarray(self._points(X) + self.displacement(X, t))

    def first_piola(self, X: ArrayLike, t: float) -> Array:
        """First Piola-Kirchhoff stress, float64[n, 3, 3] [Pa]."""
        return first_piola(self.F(X, t), *self.lame, self.form)

    def stress(self, X: ArrayLike, t: float) -> Array:
        """Cauchy stress, float64[n, 3, 3] [Pa]."""
        return cauchy(self.F(X, t), *self.lame, self.form)


@define
class AxisAligned(Manufactured):
    r"""u_i = A sin(k pi X_i) sin(w t + phi_i) on the unit interval, square (plane strain) or cube, neo-Hookean.

    w = pi sqrt(E / rho). Each displacement depends on its own coordinate, so F is diagonal; normal displacement and
    shear traction vanish on all faces, as rollers ask for. The phases are (0), (0, pi) and (0, 2 pi/3, 4 pi/3). With the
    stretches f_i and c(J) of the energy, b_i = a_i - ((J c' - c + mu) / f_i^2 + mu) df_i/dX_i / rho.
    Valid while all f_i > 0: A k pi < 1.

    References
    ----------
    Sadeghirad, Brannon and Burghardt (2011), Int. J. Numerical Methods Eng. 86, 1435 (2D);
    Wallstedt and Guilkey (2008), J. Comput. Phys. 227, 9628.
    """

    dim: int = parameter("space dimensions", ge=1, le=3, default=2)
    A: float = parameter("amplitude", unit="m", gt=0, default=0.05)
    k: int = parameter("half waves per side", ge=1, default=1)
    E: float = parameter("Young's modulus", unit="Pa", gt=0, default=1e7)
    nu: float = parameter("Poisson's ratio", gt=-1, lt=0.5, default=0.3)
    rho: float = parameter("density", unit="kg/m^3", gt=0, default=1000.0)
    form: str = parameter("form of the neo-Hookean energy", choices=FORMS, default="log")

    def check(self) -> None:
        """Raise `ParameterError` if the motion would turn matter inside out."""
        if self.A * self.k * math.pi >= 1.0:
            raise ParameterError(f"AxisAligned.A must be < 1 / (k pi) = {1.0 / (self.k * math.pi):g}, got {self.A:g}: J would reach 0")

    @property
    def omega(self) -> float:
        """Angular frequency w [rad/s]."""
        return math.pi * math.sqrt(self.E / self.rho)

    @property
    def period(self) -> float:
        """Period of the motion [s]."""
        return 2.0 * math.pi / self.omega

    @property
    def phases(self) -> tuple[float, ...]:
        """phi_i [rad]."""
        return {1: (0.0,), 2: (0.0, math.pi), 3: (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)}[self.dim]

    def displacement(self, X: ArrayLike, t: float) -> Array:
        """Displacement u, float64[n, dim] [m]."""
        return np.asarray(self.A * np.sin(self.k * np.pi * self._points(X)) * np.sin(self.omega * t + np.array(self.phases)))

    def velocity(self, X: ArrayLike, t: float) -> Array:
        """Velocity, float64[n, dim] [m/s]."""
        rate = self.A * self.omega * np.cos(self.omega * t + np.array(self.phases))
        return np.asarray(np.sin(self.k * np.pi * self._points(X)) * rate)

    def acceleration(self, X: ArrayLike, t: float) -> Array:
        """Acceleration, float64[n, dim] [m/s^2]."""
        return np.asarray(-(self.omega**2) * self.displacement(X, t))

    def stretches(self, X: ArrayLike, t: float) -> Array:
        """Diagonal of F, float64[n, dim] [1]."""
        q = self.k * np.pi
        return np.asarray(1.0 + self.A * q * np.cos(q * self._points(X)) * np.sin(self.omega * t + np.array(self.phases)))

    def F(self, X: ArrayLike, t: float) -> Array:
        """Deformation gradient, float64[n, 3, 3] [1]."""
        return embed(self.stretches(X, t)[:, :, None] * np.eye(self.dim))

    def body_force(self, X: ArrayLike, t: float) -> Array:
        """Body force per mass b, float64[n, dim] [m/s^2]."""
        lam, mu = self.lame
        a, q = volume_coefficients(lam, self.form)
        f = self.stretches(X, t)
        J = f.prod(axis=1, keepdims=True)
        slope = -((self.k * np.pi) ** 2) * self.displacement(X, t)
        tangent = (a + q * J**2 - a * np.log(J) - 0.5 * q * (J**2 - 1.0) + mu) / f**2 + mu
        return np.asarray(self.acceleration(X, t) - tangent * slope / self.rho)

    def body_force_kernel(self) -> BodyForce:
        """The body force as a scalar function f(X, t): X is a tuple of dim floats, the result one of three; Numba can compile it."""
        lam, mu = self.lame
        return axis_aligned_body_force(
            self.A, self.k * math.pi, self.omega, self.phases, *volume_coefficients(lam, self.form), mu, self.rho
        )


@define
class Vortex(Manufactured):
    """Generalized vortex: the ring 0.75 <= R <= 1.25 turns by alpha(R, t) = g(t) (1 - 16 (R - 1)^2)^2, in plane strain.

    g = A sin(pi t / T) (start "sin", moves at t = 0) or A (1 - cos(2 pi t / T)) / 2 (start "smooth", at rest at t = 0). The
    motion keeps volumes (J = 1), so both neo-Hookean energies give the same stress; the edges of the ring do not move
    and bear no traction. In polar components b_theta = R alpha_tt - mu/rho (3 alpha_R + R alpha_RR) and
    b_r = -R alpha_t^2 + mu/rho R alpha_R^2. Outside the ring everything is zero. A = 1 turns the middle by a radian.

    References
    ----------
    Kamojjala, Brannon, Sadeghirad and Guilkey (2015), Eng. with Computers 31, 193, doi:10.1007/s00366-013-0342-x.
    """

    A: float = parameter("largest angle", unit="rad", gt=0, default=1.0)
    T: float = parameter("time scale: the motion returns after T", unit="s", gt=0, default=1.0)
    E: float = parameter("Young's modulus", unit="Pa", gt=0, default=1000.0)
    nu: float = parameter("Poisson's ratio", gt=-1, lt=0.5, default=0.3)
    rho: float = parameter("density", unit="kg/m^3", gt=0, default=1000.0)
    start: str = parameter("how the motion begins", choices=("sin", "smooth"), default="sin")
    form: str = parameter("form of the neo-Hookean energy", choices=FORMS, default="log")
    center: Vector = parameter("centre of the ring", unit="m", default=(0.0, 0.0))

    dim = 2
    inner: ClassVar[float] = 0.75
    outer: ClassVar[float] = 1.25

    def check(self) -> None:
        """Raise `ParameterError` if the centre is not a point of the plane."""
        if len(self.center) != 2:
            raise ParameterError(f"Vortex.center must have 2 numbers, got {self.center}")

    @property
    def frequency(self) -> float:
        """Angular frequency of g [rad/s]."""
        return (1.0 if self.start == "sin" else 2.0) * math.pi / self.T

    def _turn(self, t: float) -> tuple[float, float, float]:
        """Angle factor g and its first two derivatives in time."""
        w = self.frequency
        if self.start == "sin":
            return self.A * math.sin(w * t), self.A * w * math.cos(w * t), -self.A * w * w * math.sin(w * t)
        half = 0.5 * self.A
        return half * (1.0 - math.cos(w * t)), half * w * math.sin(w * t), half * w * w * math.cos(w * t)

    def _profile(self, R: Array) -> tuple[Array, Array, Array]:
        """Profile (1 - 16 (R - 1)^2)^2 and its first two derivatives, zero outside the ring."""
        q = R - 1.0
        h = 1.0 - 16.0 * q**2
        ring = np.abs(q) <= 0.25
        return np.where(ring, h**2, 0.0), np.where(ring, -64.0 * q * h, 0.0), np.where(ring, -64.0 * h + 2048.0 * q**2, 0.0)

    def _frame(self, X: ArrayLike, t: float) -> tuple[Array, Array, Array]:
        """Radius, and the turned radial and tangential vectors, both of length R."""
        offset = self._points(X) - np.array(self.center)
        R = np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2)
        alpha = self._turn(t)[0] * self._profile(R)[0]
        c, s = np.cos(alpha), np.sin(alpha)
        radial = np.stack([c * offset[:, 0] - s * offset[:, 1], s * offset[:, 0] + c * offset[:, 1]], axis=1)
        return R, radial, np.stack([-radial[:, 1], radial[:, 0]], axis=1)

    def displacement(self, X: ArrayLike, t: float) -> Array:
        """Displacement u, float64[n, 2] [m]."""
        return np.asarray(self._frame(X, t)[1] - (self._points(X) - np.array(self.center)))

    def velocity(self, X: ArrayLike, t: float) -> Array:
        """Velocity, float64[n, 2] [m/s]."""
        R, _, tangential = self._frame(X, t)
        return np.asarray((self._turn(t)[1] * self._profile(R)[0])[:, None] * tangential)

    def acceleration(self, X: ArrayLike, t: float) -> Array:
        """Acceleration, float64[n, 2] [m/s^2]."""
        R, radial, tangential = self._frame(X, t)
        _, rate, second = self._turn(t)
        h = self._profile(R)[0]
        return np.asarray((second * h)[:, None] * tangential - ((rate * h) ** 2)[:, None] * radial)

    def F(self, X: ArrayLike, t: float) -> Array:
        """Deformation gradient, float64[n, 3, 3] [1]: the turn Q(alpha) plus R alpha_R e_theta E_R^T."""
        offset = self._points(X) - np.array(self.center)
        R, _, tangential = self._frame(X, t)
        h, slope, _ = self._profile(R)
        g = self._turn(t)[0]
        c, s = np.cos(g * h), np.sin(g * h)
        Q = np.stack([np.stack([c, -s], axis=1), np.stack([s, c], axis=1)], axis=1)
        # Both vectors have length R, so one division by R leaves R alpha_R; the slope is zero where R could be.
        factor = g * slope / np.maximum(R, 0.5 * self.inner)
        return embed(Q + factor[:, None, None] * tangential[:, :, None] * offset[:, None, :])

    def body_force(self, X: ArrayLike, t: float) -> Array:
        """Body force per mass b, float64[n, 2] [m/s^2]."""
        R, radial, tangential = self._frame(X, t)
        g, rate, second = self._turn(t)
        h, slope, curvature = self._profile(R)
        m = self.lame[1] / self.rho
        along = second * h - m * g * (3.0 * slope / np.maximum(R, 0.5 * self.inner) + curvature)
        inward = m * (g * slope) ** 2 - (rate * h) ** 2
        return np.asarray(along[:, None] * tangential + inward[:, None] * radial)

    def body_force_kernel(self) -> BodyForce:
        """The body force as a scalar function f(X, t): X is a tuple of two floats, the result one of three; Numba can compile it."""
        smooth = 0.0 if self.start == "sin" else 1.0
        return vortex_body_force(self.A, self.frequency, smooth, self.lame[1] / self.rho, self.center[0], self.center[1])
