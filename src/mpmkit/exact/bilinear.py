"""Waves in a bilinear elastic-plastic bar: the fan that leaves one state, and the Riemann problem of two.

Isotropic linear hardening with tangent modulus Et, or perfect plasticity for Et = 0; small strain, uniaxial stress.
Every front is a jump: elastic ones travel at sqrt(E / rho), plastic loading at sqrt(Et / rho), and in a jump that
moves with speed c the momentum condition is [v] = -[stress] / (rho c).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import attrs


class State(NamedTuple):
    """State of a stretch of the bar between two fronts; the stress never exceeds the yield stress in size."""

    stress: float
    """[Pa], tension positive."""
    velocity: float
    """[m/s]."""
    yield_stress: float
    """Present yield stress [Pa] > 0, the same in tension and compression."""
    plastic_strain: float
    """[1], signed."""


Waves = tuple[list[State], list[float]]
"""States from left to right and, between each two of them, the speed of the front [m/s]: one state more than speeds."""


@attrs.frozen
class BilinearBar:
    """The law of the bar and the size below which a jump counts as rounding.

    Parameters
    ----------
    E, Et, rho : float
        Modulus and tangent modulus [Pa], 0 <= Et < E; density [kg/m^3].
    tiny : float
        Stress [Pa] below which a jump of stress (or of velocity times impedance) is dropped.
    """

    E: float
    Et: float
    rho: float
    tiny: float

    @property
    def perfect(self) -> bool:
        """Whether there is no hardening; plastic strain then gathers in hinges of no length."""
        return self.Et == 0.0

    @property
    def Z(self) -> float:
        """Elastic impedance sqrt(E rho) [Pa s/m]."""
        return math.sqrt(self.E * self.rho)

    @property
    def Zp(self) -> float:
        """Plastic impedance sqrt(Et rho) [Pa s/m]."""
        return math.sqrt(self.Et * self.rho)

    def velocity_change(self, state: State, stress: float) -> float:
        """Integral of d stress / (rho c) along the loading from `state` to `stress` [m/s].

        A wave towards -x changes the velocity by plus, a wave towards +x by minus this.
        """
        elastic = min(max(stress, -state.yield_stress), state.yield_stress)
        change = (elastic - state.stress) / self.Z
        return change if stress == elastic else change + (stress - elastic) / self.Zp

    def fan(self, state: State, stress: float, direction: int) -> Waves:
        """Waves that take `state` to `stress`: the states behind each front, in the order of its arrival, and the speeds."""
        states: list[State] = []
        speeds: list[float] = []
        elastic = min(max(stress, -state.yield_stress), state.yield_stress)
        if abs(elastic - state.stress) > self.tiny:
            state = state._replace(stress=elastic, velocity=state.velocity - direction * (elastic - state.stress) / self.Z)
            states.append(state)
            speeds.append(direction * math.sqrt(self.E / self.rho))
        if abs(stress - elastic) > self.tiny:
            excess = stress - elastic
            state = State(
                stress,
                state.velocity - direction * excess / self.Zp,
                abs(stress),
                state.plastic_strain + excess * (1.0 / self.Et - 1.0 / self.E),
            )
            states.append(state)
            speeds.append(direction * math.sqrt(self.Et / self.rho))
        return states, speeds

    def interior(self, left: State, right: State) -> Waves:
        """Solve the Riemann problem of two neighbours.

        The stress is common; the velocity too, but in perfect plasticity, where a hinge may take up a jump of it. A
        standing front (speed 0) stays where the states behind the waves differ, in history or across a hinge.
        """

        def mismatch(stress: float) -> float:
            return left.velocity + self.velocity_change(left, stress) - right.velocity + self.velocity_change(right, stress)

        stress = self._root(mismatch, (left.yield_stress, right.yield_stress))
        behind, speeds = self.fan(left, stress, -1)
        states = [left, *behind]
        ahead, more = self.to_right(right, stress)
        if self._same(states[-1], ahead[0]):
            return states + ahead[1:], speeds + more
        return states + ahead, [*speeds, 0.0, *more]

    def to_right(self, state: State, stress: float) -> Waves:
        """Waves towards +x that leave a left end held at `stress`."""
        states, speeds = self.fan(state, stress, +1)
        return [*states[::-1], state], speeds[::-1]

    def to_left(self, state: State, stress: float) -> Waves:
        """Waves towards -x that leave a right end held at `stress`."""
        states, speeds = self.fan(state, stress, -1)
        return [state, *states], speeds

    def wall_stress(self, state: State) -> float:
        """Stress that a wall at rest at the left needs to stop `state` [Pa]; limited by yield in perfect plasticity."""
        return self._root(lambda stress: self.velocity_change(state, stress) - state.velocity, (state.yield_stress,))

    def _same(self, a: State, b: State) -> bool:
        return (
            abs(a.velocity - b.velocity) * self.Z <= 4.0 * self.tiny
            and abs(a.yield_stress - b.yield_stress) <= 4.0 * self.tiny
            and abs(a.plastic_strain - b.plastic_strain) * self.E <= 4.0 * self.tiny
        )

    def _root(self, f: Callable[[float], float], yields: Sequence[float]) -> float:
        """Root of an increasing function that is linear between plus and minus the yield stresses.

        In perfect plasticity no stress exceeds the smallest yield stress: the end value is returned if `f` has no root.
        """
        if self.perfect:
            points = [-min(yields), min(yields)]
        else:
            points = sorted({s for y in yields for s in (-y, y)})
        values = [f(p) for p in points]
        if values[0] >= 0.0 or values[-1] <= 0.0:
            end = 0 if values[0] >= 0.0 else -1
            # Outside all yield stresses every side of the front loads plastically.
            return points[end] if self.perfect else points[end] - values[end] * self.Zp / len(yields)
        k = next(k for k, value in enumerate(values) if value > 0.0)
        return points[k - 1] - values[k - 1] * (points[k] - points[k - 1]) / (values[k] - values[k - 1])
