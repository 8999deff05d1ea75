"""Elastic disk or ring in steady rotation."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from mpmkit.errors import ParameterError
from mpmkit.exact.solution import Array, Solution, inside
from mpmkit.parameters import define, parameter


@define
class SpinningDisk(Solution):
    """Disk of radius R (or ring inner <= r <= R) that spins steadily at omega; small strain, edges free.

    With K = rho omega^2, n = nu and E' = E in plane stress, n = nu / (1 - nu) and E' = E / (1 - nu^2) in plane strain:
    s_r = (3 + n) K/8 (R^2 + a^2 - a^2 R^2 / r^2 - r^2), s_theta = K/8 ((3 + n) (R^2 + a^2 + a^2 R^2 / r^2) - (1 + 3 n) r^2),
    u = r (s_theta - n s_r) / E', with a = inner. Rigid rotation is added to u by the observer.

    References
    ----------
    Timoshenko and Goodier (1970), Theory of Elasticity, section 32.
    """

    omega: float = parameter("angular velocity", unit="rad/s", example=2.0)
    R: float = parameter("outer radius", unit="m", gt=0, example=1.0)
    E: float = parameter("Young's modulus", unit="Pa", gt=0, example=1e6)
    nu: float = parameter("Poisson's ratio", gt=-1, lt=0.5, example=0.3)
    rho: float = parameter("density", unit="kg/m^3", gt=0, example=1000.0)
    plane: str = parameter("state in the plane of the disk", choices=("strain", "stress"), default="strain")
    inner: float = parameter("inner radius, 0 for a disk", unit="m", ge=0, default=0.0)

    def check(self) -> None:
        """Raise `ParameterError` if the ring has no width."""
        if not self.inner < self.R:
            raise ParameterError(f"SpinningDisk.inner must be < R = {self.R:g}, got {self.inner:g}")

    @property
    def _n(self) -> float:
        return self.nu / (1.0 - self.nu) if self.plane == "strain" else self.nu

    @property
    def _load(self) -> float:
        return self.rho * self.omega**2 / 8.0

    def _radii(self, r: ArrayLike) -> tuple[Array, Array]:
        """r, and a^2 R^2 / r^2, which a disk (a = 0) does not have, not even at its centre."""
        r = inside(r, self.inner, self.R, "SpinningDisk: r")
        return r, (self.inner * self.R) ** 2 / r**2 if self.inner > 0.0 else np.zeros(r.shape)

    def stress_r(self, r: ArrayLike) -> Array:
        """Radial stress [Pa] at radii r [m], any shape."""
        r, q = self._radii(r)
        return np.asarray((3.0 + self._n) * self._load * (self.R**2 + self.inner**2 - q - r**2))

    def stress_theta(self, r: ArrayLike) -> Array:
        """Hoop stress [Pa] at radii r [m], any shape."""
        r, q = self._radii(r)
        n = self._n
        return np.asarray(self._load * ((3.0 + n) * (self.R**2 + self.inner**2 + q) - (1.0 + 3.0 * n) * r**2))

    def stress_z(self, r: ArrayLike) -> Array:
        """Axial stress [Pa] at radii r [m], any shape: zero in plane stress."""
        total = self.stress_r(r) + self.stress_theta(r)
        return self.nu * total if self.plane == "strain" else 0.0 * total

    def displacement(self, r: ArrayLike) -> Array:
        """Radial displacement [m] at radii r [m], any shape."""
        modulus = self.E / (1.0 - self.nu**2) if self.plane == "strain" else self.E
        return np.asarray(np.asarray(r, float) / modulus * (self.stress_theta(r) - self._n * self.stress_r(r)))

    @property
    def angular_momentum(self) -> float:
        """Angular momentum per unit thickness [kg m/s]."""
        return 0.5 * math.pi * self.rho * (self.R**4 - self.inner**4) * self.omega

    @property
    def kinetic_energy(self) -> float:
        """Kinetic energy per unit thickness [J/m]."""
        return 0.5 * self.angular_momentum * self.omega
