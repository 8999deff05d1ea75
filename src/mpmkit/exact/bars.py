"""Elastic bars: waves from end tractions by d'Alembert, and the impact of two equal bars.

Small strain, one-dimensional, unit cross section, tension positive; positions are reference positions. These are the
closed forms of the elastic tests in Chen and Brannon (2002), SAND2002-0482, section 4. E is the modulus of the
one-dimensional law: Young's modulus in uniaxial stress, the P-wave modulus in uniaxial strain.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from mpmkit.errors import ParameterError
from mpmkit.exact.solution import Array, Solution, inside
from mpmkit.exact.tractions import Traction
from mpmkit.parameters import define, parameter


@define
class ForcedBar(Solution):
    """Elastic bar 0 <= x <= L, at rest for t <= 0, each end fixed, free or under a traction p(t).

    The wave equation rho u_tt = E u_xx is solved by d'Alembert's travelling waves. A wave that enters at one end
    returns with its stress multiplied by +1 at a fixed and -1 at a free (or loaded) end; in a wave that travels
    towards -x the velocity is stress / (rho C), towards +x it is -stress / (rho C), with C = sqrt(E / rho).

    Examples
    --------
    Report's test of a bar fixed at the left and pulled by a step at the right: ``ForcedBar(right=Step(1.0), L=1, E=1e4,
    rho=1)``; both ends pulled: ``ForcedBar(right=Step(1.0), left=Step(1.0), ...)``.

    References
    ----------
    SAND2002-0482, section 4, Figs 1 to 6; Graff (1975), Wave Motion in Elastic Solids, chapter 2.
    """

    L: float = parameter("length", unit="m", gt=0, example=1.0)
    E: float = parameter("modulus", unit="Pa", gt=0, example=1e4)
    rho: float = parameter("density", unit="kg/m^3", gt=0, example=1.0)
    right: str | Traction = parameter("end x = L: 'fixed', 'free' or a Traction", choices=("fixed", "free"), default="free")
    left: str | Traction = parameter("end x = 0: 'fixed', 'free' or a Traction", choices=("fixed", "free"), default="fixed")

    @property
    def C(self) -> float:
        """Wave speed [m/s]."""
        return math.sqrt(self.E / self.rho)

    @property
    def Z(self) -> float:
        """Impedance rho C [Pa s/m]."""
        return self.rho * self.C

    @property
    def period(self) -> float:
        """Time after which the free waves repeat [s]: 4 L / C if one end is fixed, else 2 L / C."""
        return (2.0 if self._sign("left") == self._sign("right") else 4.0) * self.L / self.C

    def _sign(self, end: str) -> float:
        """Factor by which an end multiplies the stress of a wave that it reflects."""
        return 1.0 if getattr(self, end) == "fixed" else -1.0

    def _waves(self, x: ArrayLike, t: ArrayLike, wave: Callable[[Traction, Array], Array]) -> tuple[Array, Array]:
        """Sums of `wave` over all arrivals: those that travel towards -x, and those that travel towards +x."""
        x = inside(x, 0.0, self.L, "ForcedBar: x")
        t = np.asarray(t, dtype=np.float64)
        down, up = np.zeros(np.broadcast(x, t).shape), np.zeros(np.broadcast(x, t).shape)
        trips = int(self.C * max(float(t.max(initial=0.0)), 0.0) / (2.0 * self.L)) + 1
        for trip in range(trips):
            factor = (self._sign("left") * self._sign("right")) ** trip
            if isinstance(self.right, Traction):
                down += factor * wave(self.right, t - ((2 * trip + 1) * self.L - x) / self.C)
                up += factor * self._sign("left") * wave(self.right, t - ((2 * trip + 1) * self.L + x) / self.C)
            if isinstance(self.left, Traction):
                up += factor * wave(self.left, t - (2 * trip * self.L + x) / self.C)
                down += factor * self._sign("right") * wave(self.left, t - (2 * (trip + 1) * self.L - x) / self.C)
        return down, up

    def stress(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Stress [Pa] at positions x [m] and times t [s], broadcast against each other."""
        down, up = self._waves(x, t, lambda p, tau: p.value(tau))
        return down + up

    def velocity(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Velocity [m/s] at positions x [m] and times t [s], broadcast against each other."""
        down, up = self._waves(x, t, lambda p, tau: p.value(tau))
        return (down - up) / self.Z

    def displacement(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Displacement [m] at positions x [m] and times t [s], broadcast against each other."""
        down, up = self._waves(x, t, lambda p, tau: p.impulse(tau))
        return (down - up) / self.Z


@define
class BarImpact(Solution):
    """Elastic impact of two equal bars: [0, L] with velocity +V0 and [L + gap, 2 L + gap] with -V0.

    From the contact on, both bars are compressed to -rho C V0 by waves that start at the contact face, come back
    from the free ends as releases and part the bars after 2 L / C, without any vibration left: restitution 1.
    Lengths are reference lengths; small strain, so V0 << C.

    References
    ----------
    SAND2002-0482, section 4, Figs 7 to 10; Graff (1975), Wave Motion in Elastic Solids, chapter 2.
    """

    V0: float = parameter("speed of each bar before contact", unit="m/s", gt=0, example=0.1)
    L: float = parameter("length of each bar", unit="m", gt=0, example=0.5)
    gap: float = parameter("distance between the bars at t = 0", unit="m", ge=0, example=0.5)
    E: float = parameter("modulus", unit="Pa", gt=0, example=1e4)
    rho: float = parameter("density", unit="kg/m^3", gt=0, example=1.0)

    @property
    def C(self) -> float:
        """Wave speed [m/s]."""
        return math.sqrt(self.E / self.rho)

    @property
    def contact_time(self) -> float:
        """When the faces meet [s]."""
        return self.gap / (2.0 * self.V0)

    @property
    def duration(self) -> float:
        """How long they touch [s]: 2 L / C."""
        return 2.0 * self.L / self.C

    @property
    def separation_time(self) -> float:
        """When they part [s]."""
        return self.contact_time + self.duration

    @property
    def contact_stress(self) -> float:
        """Stress during contact [Pa]: -rho C V0."""
        return -self.rho * self.C * self.V0

    @property
    def restitution(self) -> float:
        """Relative speed after over before."""
        x = np.array([0.0, 2.0 * self.L + self.gap])
        after, before = self.velocity(x, 2.0 * self.separation_time), self.velocity(x, 0.0)
        return float((after[1] - after[0]) / (before[0] - before[1]))

    def _distance(self, x: ArrayLike) -> tuple[Array, Array]:
        """Distance of each point from its contact face, and the sign of the velocity towards the other bar."""
        x = inside(x, 0.0, 2.0 * self.L + self.gap, "BarImpact: x")
        right = x > self.L + 0.5 * self.gap
        distance = np.where(right, x - (self.L + self.gap), self.L - x)
        if (distance < -1e-9 * self.L).any():
            bad = float(x[distance < -1e-9 * self.L].ravel()[0])
            raise ParameterError(
                f"BarImpact: x must lie in a bar, [0, {self.L:g}] or [{self.L + self.gap:g}, {2 * self.L + self.gap:g}], got {bad:g}; "
                "give reference positions, not current ones"
            )
        return distance, np.where(right, -1.0, 1.0)

    def _arrivals(self, x: ArrayLike) -> tuple[Array, Array, Array]:
        """Times when compression and release arrive at each point, and the sign of its first velocity."""
        distance, sign = self._distance(x)
        return self.contact_time + distance / self.C, self.separation_time - distance / self.C, sign

    def stress(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Stress [Pa] at reference positions x [m] and times t [s], broadcast against each other."""
        compression, release, _ = self._arrivals(x)
        t = np.asarray(t, float)
        return np.where((t > compression) & (t <= release), self.contact_stress, 0.0)

    def velocity(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Velocity [m/s] at reference positions x [m] and times t [s], broadcast against each other."""
        compression, release, sign = self._arrivals(x)
        t = np.asarray(t, float)
        return np.asarray(self.V0 * sign * ((t <= compression) * 1.0 - (t > release)))

    def displacement(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Displacement [m] at reference positions x [m] and times t [s], broadcast against each other."""
        compression, release, sign = self._arrivals(x)
        t = np.asarray(t, float)
        return np.asarray(self.V0 * sign * (np.minimum(t, compression) - np.maximum(t - release, 0.0)))

    def strain_energy(self, t: ArrayLike) -> Array:
        """Strain energy of both bars [J/m^2 of cross section]; the kinetic energy is the rest of rho L V0^2."""
        passed = self.C * (np.asarray(t, float) - self.contact_time)
        return np.asarray(self.rho * self.V0**2 * np.clip(np.minimum(passed, 2.0 * self.L - passed), 0.0, None))

    def kinetic_energy(self, t: ArrayLike) -> Array:
        """Kinetic energy of both bars [J/m^2 of cross section]."""
        return np.asarray(self.rho * self.L * self.V0**2 - self.strain_energy(t))
