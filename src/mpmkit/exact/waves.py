"""One-dimensional elastic waves at an interface of two materials, and impact of two of them."""

from __future__ import annotations

import math

from mpmkit.errors import ParameterError
from mpmkit.exact.solution import Solution
from mpmkit.parameters import define, parameter


def impedance(modulus: float, rho: float) -> float:
    """Impedance sqrt(modulus rho) [Pa s/m].

    Parameters
    ----------
    modulus : float
        Young's modulus for a slender bar, lambda + 2 mu for a plane wave [Pa], > 0.
    rho : float
        Density [kg/m^3], > 0.

    Raises
    ------
    ParameterError
        If one of them is not positive.
    """
    for name, value in (("modulus", modulus), ("rho", rho)):
        if not value > 0.0:
            raise ParameterError(f"impedance: {name} must be > 0, got {value:g}")
    return math.sqrt(modulus * rho)


@define
class Interface(Solution):
    """A bonded interface between impedance Z1, where the wave comes from, and Z2; normal incidence, small strain.

    Stress and velocity are continuous across it. An incident stress s gives R s reflected and T s transmitted, with
    R = (Z2 - Z1) / (Z2 + Z1) and T = 1 + R = 2 Z2 / (Z2 + Z1); Z2 = 0 is a free end. A compressive wave also needs no
    bond as long as the stress at the interface stays compressive.

    References
    ----------
    Graff (1975), Wave Motion in Elastic Solids, chapter 2.
    """

    Z1: float = parameter("impedance on the side of the incident wave", unit="Pa*s/m", gt=0, example=100.0)
    Z2: float = parameter("impedance on the other side", unit="Pa*s/m", ge=0, example=50.0)

    @property
    def reflection(self) -> float:
        """R: reflected over incident stress [1]; the velocity is reflected with -R."""
        return (self.Z2 - self.Z1) / (self.Z2 + self.Z1)

    @property
    def transmission(self) -> float:
        """T: transmitted over incident stress [1]; for the velocity it is T Z1 / Z2."""
        return 2.0 * self.Z2 / (self.Z2 + self.Z1)

    @property
    def reflected_energy(self) -> float:
        """Share of the incident energy that is reflected, R^2 [1]; the rest is transmitted."""
        return self.reflection**2

    def impact_stress(self, v1: float, v2: float) -> float:
        """Stress [Pa] at the contact of two stress-free bodies that meet with v1 (left) and v2 (right) [m/s], positive to the right.

        Tension positive: -Z1 Z2 (v1 - v2) / (Z1 + Z2) while no wave has come back to the contact; zero if they part.
        """
        return -self.Z1 * self.Z2 * max(v1 - v2, 0.0) / (self.Z1 + self.Z2)

    def impact_velocity(self, v1: float, v2: float) -> float:
        """Common velocity [m/s] of the contact of two bodies that meet with v1 >= v2 [m/s]: (Z1 v1 + Z2 v2) / (Z1 + Z2).

        Raises
        ------
        ParameterError
            If v1 < v2: they part and have no common velocity.
        """
        if v1 < v2:
            raise ParameterError(f"Interface.impact_velocity: v1 must be >= v2, got {v1:g} < {v2:g}: the bodies part")
        return (self.Z1 * v1 + self.Z2 * v2) / (self.Z1 + self.Z2)
