"""Tractions in time, for the ends of exact bars: a step, a rectangular pulse, a smooth pulse."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mpmkit.exact.solution import Array, Solution
from mpmkit.parameters import define, parameter


class Traction(Solution):
    """A normal traction p(t) [Pa], tension positive, zero for t <= 0."""

    def value(self, t: ArrayLike) -> Array:
        """p(t) [Pa], the shape of `t` [s]."""
        raise NotImplementedError(f"{type(self).__name__} must define value(t)")

    def impulse(self, t: ArrayLike) -> Array:
        """Integral of p from 0 to t [Pa s], the shape of `t` [s]."""
        raise NotImplementedError(f"{type(self).__name__} must define impulse(t)")


@define
class Step(Traction):
    """p = magnitude for t > 0."""

    magnitude: float = parameter("traction after the start, tension positive", unit="Pa", example=1.0)

    def value(self, t: ArrayLike) -> Array:
        """p(t) [Pa]."""
        return np.where(np.asarray(t, float) > 0.0, self.magnitude, 0.0)

    def impulse(self, t: ArrayLike) -> Array:
        """Integral of p [Pa s]."""
        return np.asarray(self.magnitude * np.maximum(np.asarray(t, float), 0.0))


@define
class Pulse(Traction):
    """p = magnitude for 0 < t <= duration."""

    magnitude: float = parameter("traction during the pulse, tension positive", unit="Pa", example=-1.0)
    duration: float = parameter("length of the pulse", unit="s", gt=0, example=0.01)

    def value(self, t: ArrayLike) -> Array:
        """p(t) [Pa]."""
        time = np.asarray(t, float)
        return np.where((time > 0.0) & (time <= self.duration), self.magnitude, 0.0)

    def impulse(self, t: ArrayLike) -> Array:
        """Integral of p [Pa s]."""
        return np.asarray(self.magnitude * np.clip(np.asarray(t, float), 0.0, self.duration))


@define
class SmoothPulse(Traction):
    """p = magnitude sin^2(pi t / duration) for 0 < t < duration: continuous with its slope, for studies of convergence."""

    magnitude: float = parameter("largest traction, tension positive", unit="Pa", example=1.0)
    duration: float = parameter("length of the pulse", unit="s", gt=0, example=0.01)

    def value(self, t: ArrayLike) -> Array:
        """p(t) [Pa]."""
        time = np.asarray(t, float)
        during = (time > 0.0) & (time < self.duration)
        return np.where(during, self.magnitude * np.sin(np.pi * time / self.duration) ** 2, 0.0)

    def impulse(self, t: ArrayLike) -> Array:
        """Integral of p [Pa s]."""
        time: Array = np.clip(np.asarray(t, float), 0.0, self.duration)
        return np.asarray(self.magnitude * (time / 2 - self.duration / (4 * np.pi) * np.sin(2 * np.pi * time / self.duration)))
