"""Rigid bodies on an inclined plane with Coulomb friction: a block that slides, a disk that rolls or slips."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from mpmkit.exact.solution import Array, Solution
from mpmkit.parameters import define, parameter


@define
class BlockOnIncline(Solution):
    """Block released at rest: s = g (sin theta - mu cos theta) t^2 / 2 if tan theta > mu, else it stays.

    References
    ----------
    Bardenhagen, Brackbill and Sulsky (2000), Comput. Methods Appl. Mech. Eng. 187, 529 (as a test of contact).
    """

    theta: float = parameter("angle of the plane", unit="rad", ge=0, lt=math.pi / 2, example=math.pi / 6)
    mu: float = parameter("coefficient of friction", ge=0, example=0.3)
    g: float = parameter("acceleration of gravity", unit="m/s^2", gt=0, default=9.81)

    @property
    def slips(self) -> bool:
        """Whether the block slides."""
        return math.tan(self.theta) > self.mu

    @property
    def acceleration(self) -> float:
        """Acceleration down the plane [m/s^2]."""
        return self.g * (math.sin(self.theta) - self.mu * math.cos(self.theta)) if self.slips else 0.0

    def velocity(self, t: ArrayLike) -> Array:
        """Velocity down the plane [m/s] at times t [s], any shape."""
        return np.asarray(self.acceleration * np.asarray(t, float))

    def distance(self, t: ArrayLike) -> Array:
        """Distance down the plane [m] at times t [s], any shape."""
        return np.asarray(0.5 * self.acceleration * np.asarray(t, float) ** 2)


@define
class DiskOnIncline(Solution):
    """Solid disk or cylinder released at rest: rolls with g sin theta * 2/3 if tan theta <= 3 mu, else slips as it turns.

    Slipping: acceleration g (sin theta - mu cos theta), angular acceleration 2 mu g cos theta / R.

    References
    ----------
    Bardenhagen, Brackbill and Sulsky (2000), Comput. Methods Appl. Mech. Eng. 187, 529.
    """

    theta: float = parameter("angle of the plane", unit="rad", ge=0, lt=math.pi / 2, example=math.pi / 6)
    mu: float = parameter("coefficient of friction", ge=0, example=0.3)
    R: float = parameter("radius", unit="m", gt=0, default=1.0)
    g: float = parameter("acceleration of gravity", unit="m/s^2", gt=0, default=9.81)

    @property
    def slips(self) -> bool:
        """Whether the contact point slides."""
        return math.tan(self.theta) > 3.0 * self.mu

    @property
    def acceleration(self) -> float:
        """Acceleration of the centre down the plane [m/s^2]."""
        if self.slips:
            return self.g * (math.sin(self.theta) - self.mu * math.cos(self.theta))
        return 2.0 / 3.0 * self.g * math.sin(self.theta)

    @property
    def angular_acceleration(self) -> float:
        """Angular acceleration in the sense of rolling down [rad/s^2]."""
        return 2.0 * self.mu * self.g * math.cos(self.theta) / self.R if self.slips else self.acceleration / self.R

    def velocity(self, t: ArrayLike) -> Array:
        """Velocity of the centre down the plane [m/s] at times t [s], any shape."""
        return np.asarray(self.acceleration * np.asarray(t, float))

    def distance(self, t: ArrayLike) -> Array:
        """Distance of the centre down the plane [m] at times t [s], any shape."""
        return np.asarray(0.5 * self.acceleration * np.asarray(t, float) ** 2)

    def angle(self, t: ArrayLike) -> Array:
        """Angle turned [rad] at times t [s], any shape."""
        return np.asarray(0.5 * self.angular_acceleration * np.asarray(t, float) ** 2)
