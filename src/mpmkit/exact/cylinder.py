"""Thick-walled cylinder under pressure in plane strain: elastic (Lame) and elastic-perfectly plastic."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from mpmkit.errors import ParameterError
from mpmkit.exact.solution import Array, Solution, inside
from mpmkit.parameters import define, parameter


@define
class ThickCylinder(Solution):
    """Lame's elastic cylinder a <= r <= b, plane strain, small strain, with pressures inside and outside.

    s_r = A - B / r^2, s_theta = A + B / r^2, s_z = 2 nu A and u = (1 + nu) / E ((1 - 2 nu) A r + B / r), with
    A = (p a^2 - q b^2) / (b^2 - a^2) and B = (p - q) a^2 b^2 / (b^2 - a^2).

    References
    ----------
    Timoshenko and Goodier (1970), Theory of Elasticity, section 28.
    """

    a: float = parameter("inner radius", unit="m", gt=0, example=1.0)
    b: float = parameter("outer radius", unit="m", gt=0, example=2.0)
    pressure: float = parameter("pressure inside", unit="Pa", example=1.0)
    E: float = parameter("Young's modulus", unit="Pa", gt=0, example=1000.0)
    nu: float = parameter("Poisson's ratio", gt=-1, lt=0.5, example=0.3)
    outer_pressure: float = parameter("pressure outside", unit="Pa", default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` if the wall has no thickness."""
        _wall(self, self.a, self.b)

    @property
    def _A(self) -> float:
        return (self.pressure * self.a**2 - self.outer_pressure * self.b**2) / (self.b**2 - self.a**2)

    @property
    def _B(self) -> float:
        return (self.pressure - self.outer_pressure) * self.a**2 * self.b**2 / (self.b**2 - self.a**2)

    def displacement(self, r: ArrayLike) -> Array:
        """Radial displacement [m] at radii r [m], any shape."""
        r = inside(r, self.a, self.b, "ThickCylinder: r")
        return np.asarray((1.0 + self.nu) / self.E * ((1.0 - 2.0 * self.nu) * self._A * r + self._B / r))

    def stress_r(self, r: ArrayLike) -> Array:
        """Radial stress [Pa] at radii r [m], any shape."""
        return np.asarray(self._A - self._B / inside(r, self.a, self.b, "ThickCylinder: r") ** 2)

    def stress_theta(self, r: ArrayLike) -> Array:
        """Hoop stress [Pa] at radii r [m], any shape."""
        return np.asarray(self._A + self._B / inside(r, self.a, self.b, "ThickCylinder: r") ** 2)

    @property
    def stress_z(self) -> float:
        """Axial stress [Pa], the same everywhere."""
        return 2.0 * self.nu * self._A


@define
class PlasticCylinder(Solution):
    """Cylinder a <= r <= b of a von Mises material without hardening, plane strain, small strain, pressure inside.

    The material is taken as incompressible (nu = 1/2), which makes the axial stress the mean of the others and the
    solution closed: with k = Y / sqrt(3) the wall is plastic for r < c, where p = 2 k ln(c / a) + k (1 - c^2 / b^2). The
    wall first yields at p = k (1 - a^2 / b^2) and collapses at 2 k ln(b / a). Below first yield it is elastic.

    References
    ----------
    Hill (1950), The Mathematical Theory of Plasticity, chapter V.2.
    """

    a: float = parameter("inner radius", unit="m", gt=0, example=1.0)
    b: float = parameter("outer radius", unit="m", gt=0, example=2.0)
    pressure: float = parameter("pressure inside, below collapse", unit="Pa", ge=0, example=0.7)
    Y: float = parameter("yield stress in tension", unit="Pa", gt=0, example=1.0)
    E: float = parameter("Young's modulus", unit="Pa", gt=0, example=1000.0)

    def check(self) -> None:
        """Raise `ParameterError` if the wall has no thickness or cannot bear the pressure."""
        _wall(self, self.a, self.b)
        if not self.pressure <= self.collapse_pressure:
            raise ParameterError(
                f"PlasticCylinder.pressure must be <= {self.collapse_pressure:g} (collapse), got {self.pressure:g}: no equilibrium"
            )

    @property
    def k(self) -> float:
        """Yield stress in shear [Pa]."""
        return self.Y / math.sqrt(3.0)

    @property
    def first_yield_pressure(self) -> float:
        """Pressure at which the inner surface yields [Pa]."""
        return self.k * (1.0 - (self.a / self.b) ** 2)

    @property
    def collapse_pressure(self) -> float:
        """Pressure at which the whole wall is plastic [Pa]."""
        return 2.0 * self.k * math.log(self.b / self.a)

    def pressure_at(self, c: float) -> float:
        """Pressure [Pa] at which the wall is plastic up to the radius c [m], a <= c <= b."""
        c = float(inside(c, self.a, self.b, "PlasticCylinder: c"))
        return self.k * (2.0 * math.log(c / self.a) + 1.0 - (c / self.b) ** 2)

    @property
    def plastic_radius(self) -> float:
        """Outer radius c of the plastic part [m]; a if all is elastic."""
        if self.pressure <= self.first_yield_pressure:
            return self.a
        if self.pressure >= self.pressure_at(self.b):
            return self.b
        from scipy.optimize import brentq

        return float(brentq(lambda c: self.pressure_at(c) - self.pressure, self.a, self.b, xtol=1e-15 * self.b, rtol=1e-14))

    @property
    def _B(self) -> float:
        """B of Lame's solution in the elastic part [N]."""
        c = self.plastic_radius
        return self.k * c**2 if c > self.a else self.pressure / (1.0 / self.a**2 - 1.0 / self.b**2)

    def stress_r(self, r: ArrayLike) -> Array:
        """Radial stress [Pa] at radii r [m], any shape."""
        r = inside(r, self.a, self.b, "PlasticCylinder: r")
        return np.where(r < self.plastic_radius, 2.0 * self.k * np.log(r / self.a) - self.pressure, self._B * (self.b**-2 - r**-2))

    def stress_theta(self, r: ArrayLike) -> Array:
        """Hoop stress [Pa] at radii r [m], any shape."""
        r = inside(r, self.a, self.b, "PlasticCylinder: r")
        return np.where(r < self.plastic_radius, self.stress_r(r) + 2.0 * self.k, self._B * (self.b**-2 + r**-2))

    def stress_z(self, r: ArrayLike) -> Array:
        """Axial stress [Pa] at radii r [m], any shape."""
        return np.asarray(0.5 * (self.stress_r(r) + self.stress_theta(r)))

    def displacement(self, r: ArrayLike) -> Array:
        """Radial displacement [m] at radii r [m], any shape: u r is constant in an incompressible wall."""
        return np.asarray(1.5 / self.E * self._B / inside(r, self.a, self.b, "PlasticCylinder: r"))


def _wall(owner: Solution, a: float, b: float) -> None:
    if not a < b:
        raise ParameterError(f"{type(owner).__name__}.b must be > a = {a:g}, got {b:g}")
