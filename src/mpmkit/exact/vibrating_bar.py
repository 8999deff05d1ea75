"""Free vibration of an elastic bar in one of its modes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from mpmkit.exact.solution import Array, Solution, inside
from mpmkit.parameters import define, parameter


@define
class VibratingBar(Solution):
    """Bar 0 <= x <= L that starts undeformed with velocity v0 sin(b x).

    u = (v0 / w) sin(w t) sin(b x), with w = b sqrt(E / rho) and b = (2 n - 1) pi / (2 L) for a bar fixed at x = 0 and
    free at x = L, b = n pi / L for a bar fixed at both ends; n is the mode. Small strain: b v0 / w << 1. Energies are
    per unit cross section; E is the modulus of the one-dimensional law.

    References
    ----------
    Graff (1975), Wave Motion in Elastic Solids, chapter 2; Bardenhagen (2002), J. Comput. Phys. 180, 383 (as a test of
    energy conservation in the material point method).
    """

    L: float = parameter("length", unit="m", gt=0, example=25.0)
    E: float = parameter("modulus", unit="Pa", gt=0, example=100.0)
    rho: float = parameter("density", unit="kg/m^3", gt=0, example=1.0)
    v0: float = parameter("largest velocity", unit="m/s", example=0.1)
    mode: int = parameter("number of the mode", ge=1, default=1)
    ends: str = parameter("how the ends are held", choices=("fixed-free", "fixed-fixed"), default="fixed-free")

    @property
    def wave_number(self) -> float:
        """Wave number b [1/m]."""
        return (self.mode - 0.5 if self.ends == "fixed-free" else float(self.mode)) * math.pi / self.L

    @property
    def omega(self) -> float:
        """Angular frequency w [rad/s]."""
        return self.wave_number * math.sqrt(self.E / self.rho)

    @property
    def period(self) -> float:
        """Period [s]."""
        return 2.0 * math.pi / self.omega

    @property
    def energy(self) -> float:
        """Total energy, rho L v0^2 / 4 [J/m^2]."""
        return 0.25 * self.rho * self.L * self.v0**2

    def _points(self, x: ArrayLike) -> Array:
        return self.wave_number * inside(x, 0.0, self.L, "VibratingBar: x")

    def displacement(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Displacement [m] at x [m] and t [s], broadcast against each other."""
        return np.asarray(self.v0 / self.omega * np.sin(self.omega * np.asarray(t, float)) * np.sin(self._points(x)))

    def velocity(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Velocity [m/s] at x [m] and t [s], broadcast against each other."""
        return np.asarray(self.v0 * np.cos(self.omega * np.asarray(t, float)) * np.sin(self._points(x)))

    def stress(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Stress [Pa], tension positive, at x [m] and t [s], broadcast against each other."""
        amplitude = self.E * self.wave_number * self.v0 / self.omega
        return np.asarray(amplitude * np.sin(self.omega * np.asarray(t, float)) * np.cos(self._points(x)))

    def mean_velocity(self, t: ArrayLike) -> Array:
        """Velocity of the centre of mass [m/s] at t [s]."""
        bL = self.wave_number * self.L
        return np.asarray(self.v0 * (1.0 - math.cos(bL)) / bL * np.cos(self.omega * np.asarray(t, float)))

    def kinetic_energy(self, t: ArrayLike) -> Array:
        """Kinetic energy [J/m^2] at t [s]; the strain energy is the rest of `energy`."""
        return np.asarray(self.energy * np.cos(self.omega * np.asarray(t, float)) ** 2)
