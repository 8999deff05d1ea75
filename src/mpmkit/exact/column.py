"""A column under its own weight: at rest for four elastic laws, and suddenly loaded in linear elasticity."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from mpmkit.errors import StabilityError
from mpmkit.exact.hyperelastic import lame
from mpmkit.exact.solution import Array, Solution, inside
from mpmkit.parameters import define, parameter

LAWS = ("quadratic", "log", "hencky", "linear")


@define
class Column(Solution):
    r"""Column 0 <= Y <= H in uniaxial strain (smooth side walls, base fixed, top free), at rest under gravity.

    The nominal stress is P = -rho g (H - Y) for any law, and as the cross section does not change it is the axial Cauchy
    stress. The stretch J follows from P = dw/dJ; as dY = dP / (rho g), the displacement is
    u(Y) = [(J - 1) P - w(J)] / (rho g), taken between the base and Y.

    Laws: the neo-Hookean forms "quadratic", P = (lam/2 + mu) (J - 1/J), and "log", P = lam ln J / J + mu (J - 1/J);
    "hencky" (linear in the logarithmic strain), P = (lam + 2 mu) ln J / J; "linear" (small strain), P = (lam + 2 mu) (J - 1).
    """

    H: float = parameter("height before loading", unit="m", gt=0, example=50.0)
    E: float = parameter("Young's modulus", unit="Pa", gt=0, example=1e5)
    rho: float = parameter("density before loading", unit="kg/m^3", gt=0, example=80.0)
    nu: float = parameter("Poisson's ratio", gt=-1, lt=0.5, default=0.0)
    g: float = parameter("acceleration of gravity", unit="m/s^2", gt=0, default=9.81)
    law: str = parameter("elastic law", choices=LAWS, default="quadratic")

    @property
    def modulus(self) -> float:
        """P-wave modulus lam + 2 mu [Pa]."""
        lam, mu = lame(self.E, self.nu)
        return lam + 2.0 * mu

    def stress(self, Y: ArrayLike) -> Array:
        """Axial stress [Pa] at reference heights Y [m], any shape; tension positive."""
        return np.asarray(-self.rho * self.g * (self.H - inside(Y, 0.0, self.H, "Column: Y")))

    def stretch(self, Y: ArrayLike) -> Array:
        """J = dy/dY [1] at reference heights Y [m], any shape."""
        P = self.stress(Y)
        M = self.modulus
        if self.law == "linear":
            return 1.0 + P / M
        if self.law == "quadratic":
            return np.exp(np.arcsinh(P / M))
        # In s = ln J the nominal stress rises and is concave for s <= 0: Newton's method converges from any start.
        lam, mu = (M, 0.0) if self.law == "hencky" else lame(self.E, self.nu)
        s = np.zeros(P.shape)
        for _ in range(200):
            residual = lam * s * np.exp(-s) + 2.0 * mu * np.sinh(s) - P
            change = residual / (lam * (1.0 - s) * np.exp(-s) + 2.0 * mu * np.cosh(s))
            s = s - change
            if np.all(np.abs(change) <= 1e-15 * (1.0 + np.abs(s))):
                return np.exp(s)
        raise StabilityError(f"Column: Newton's method for the stretch did not converge, stress / modulus down to {P.min() / M:g}")

    def _energy(self, J: Array) -> Array:
        """Strain energy per reference volume w(J) [J/m^3]."""
        lam, mu = lame(self.E, self.nu)
        if self.law == "linear":
            return np.asarray(0.5 * self.modulus * (J - 1.0) ** 2)
        if self.law == "hencky":
            return np.asarray(0.5 * self.modulus * np.log(J) ** 2)
        if self.law == "log":
            return np.asarray(0.5 * lam * np.log(J) ** 2 + mu * (0.5 * (J**2 - 1.0) - np.log(J)))
        return np.asarray((0.5 * lam + mu) * (0.5 * (J**2 - 1.0) - np.log(J)))

    def displacement(self, Y: ArrayLike) -> Array:
        """Vertical displacement [m] at reference heights Y [m], any shape."""

        def primitive(height: ArrayLike) -> Array:
            J = self.stretch(height)
            return np.asarray(((J - 1.0) * self.stress(height) - self._energy(J)) / (self.rho * self.g))

        return primitive(Y) - primitive(0.0)


@define
class SuddenColumn(Solution):
    """Linear elastic column 0 <= Y <= H, at rest when gravity sets in at t = 0; base fixed, top free, uniaxial strain.

    The static displacement minus its free vibration, by d'Alembert: every point swings between zero and, at the top,
    twice the static displacement, with the period 4 H / c.
    """

    H: float = parameter("height", unit="m", gt=0, example=50.0)
    modulus: float = parameter("modulus of the one-dimensional law, such as lam + 2 mu", unit="Pa", gt=0, example=1e5)
    rho: float = parameter("density", unit="kg/m^3", gt=0, example=80.0)
    g: float = parameter("acceleration of gravity", unit="m/s^2", gt=0, default=9.81)

    @property
    def c(self) -> float:
        """Wave speed [m/s]."""
        return math.sqrt(self.modulus / self.rho)

    @property
    def period(self) -> float:
        """Period [s]: 4 H / c."""
        return 4.0 * self.H / self.c

    def _static(self, z: Array) -> tuple[Array, Array]:
        """Static displacement and its slope, continued as waves need it: odd about the base, even about the top."""
        phase = np.mod(z, 4.0 * self.H)
        sign = np.where(phase <= 2.0 * self.H, 1.0, -1.0)
        y = np.where(phase <= 2.0 * self.H, phase, phase - 2.0 * self.H)
        k = self.rho * self.g / self.modulus
        return -sign * k * y * (self.H - 0.5 * y), -sign * k * (self.H - y)

    def _waves(self, Y: ArrayLike, t: ArrayLike) -> tuple[tuple[Array, Array], tuple[Array, Array], tuple[Array, Array]]:
        Y = inside(Y, 0.0, self.H, "SuddenColumn: Y")
        ct = self.c * np.asarray(t, float)
        return self._static(Y + 0.0 * ct), self._static(Y - ct), self._static(Y + ct)

    def displacement(self, Y: ArrayLike, t: ArrayLike) -> Array:
        """Vertical displacement [m] at heights Y [m] and times t [s] >= 0, broadcast against each other."""
        static, down, up = self._waves(Y, t)
        return np.asarray(static[0] - 0.5 * (down[0] + up[0]))

    def velocity(self, Y: ArrayLike, t: ArrayLike) -> Array:
        """Vertical velocity [m/s] at heights Y [m] and times t [s] >= 0, broadcast against each other."""
        _, down, up = self._waves(Y, t)
        return np.asarray(0.5 * self.c * (down[1] - up[1]))

    def stress(self, Y: ArrayLike, t: ArrayLike) -> Array:
        """Axial stress [Pa] at heights Y [m] and times t [s] >= 0, broadcast against each other."""
        static, down, up = self._waves(Y, t)
        return np.asarray(self.modulus * (static[1] - 0.5 * (down[1] + up[1])))
