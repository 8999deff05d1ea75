"""Impact of an elastic-plastic bar on a rigid wall, exactly, by following every wave front.

This is one half of the symmetric impact of two equal bars: SAND2002-0482, section 4, Figs 13 to 16 (linear hardening,
Et = E / 4) and Figs 17 to 20 (perfect plasticity).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mpmkit.errors import ParameterError
from mpmkit.exact.bilinear import BilinearBar, State
from mpmkit.exact.fronts import Epoch, follow
from mpmkit.exact.solution import Array, Solution, inside
from mpmkit.parameters import define, parameter


@define
class PlasticBarImpact(Solution):
    """Bar 0 <= X <= L that reaches a frictionless rigid wall at X = 0 at t = 0 with velocity -V0; X = L is free.

    X is the distance from the contact face in the reference state, velocities are positive away from the wall. For the
    right bar of a symmetric impact take x = face + X, for the left one x = face - X and turn the sign of the velocity.
    Isotropic hardening; small strain, so V0 << C; valid for 0 <= t <= until. The wall cannot pull. With Et = 0 the
    plastic strain gathers in hinges of no length, mostly at the contact face: `plastic_strain` is then zero and
    `displacement` jumps there, while `plastic_shortening` counts the hinges.

    Examples
    --------
    With E = 1e4, rho = 1, L = 0.5, V0 = 0.1, Y = 4 (all SI): Et = E / 4 gives the restitution 23/45 and separation at
    t = 1/75; Et = 0 gives 1/5 and 0.020.

    References
    ----------
    SAND2002-0482, section 4; Kolsky (1963), Stress Waves in Solids, chapter 7 (plastic waves).
    """

    V0: float = parameter("speed before contact", unit="m/s", gt=0, example=0.1)
    L: float = parameter("length", unit="m", gt=0, example=0.5)
    E: float = parameter("modulus", unit="Pa", gt=0, example=1e4)
    rho: float = parameter("density", unit="kg/m^3", gt=0, example=1.0)
    Y: float = parameter("first yield stress", unit="Pa", gt=0, example=4.0)
    Et: float = parameter("tangent modulus, 0 for perfect plasticity", unit="Pa", ge=0, example=2500.0)
    until: float | None = parameter("end of the solution; 12 L / C if none is given", unit="s", gt=0, default=None)

    def check(self) -> None:
        """Raise `ParameterError` if Et is not smaller than E."""
        if not self.Et < self.E:
            raise ParameterError(f"PlasticBarImpact.Et must be < E = {self.E:g}, got {self.Et:g}; for an elastic bar use BarImpact")

    @property
    def C(self) -> float:
        """Elastic wave speed [m/s]."""
        return math.sqrt(self.E / self.rho)

    @property
    def end(self) -> float:
        """Last time of the solution [s]."""
        return 12.0 * self.L / self.C if self.until is None else self.until

    @cached_property
    def epochs(self) -> list[Epoch]:
        """The stretches of time in which no front meets anything, in order."""
        law = BilinearBar(self.E, self.Et, self.rho, 1e-12 * (self.Y + self.rho * self.C * self.V0))
        return follow(law, State(0.0, -self.V0, self.Y, 0.0), self.L, self.end)

    def _at(self, t: float) -> Epoch:
        if not 0.0 <= t <= self.end * (1.0 + 1e-12):
            raise ParameterError(f"PlasticBarImpact: t must lie in [0, {self.end:g}] s, got {t:g}; give a larger until to go on")
        return self.epochs[bisect_right(self.epochs, t, key=lambda epoch: epoch.start) - 1]

    def _sample(self, X: ArrayLike, t: float, name: str) -> Array:
        X = inside(X, 0.0, self.L, "PlasticBarImpact: X")
        epoch = self._at(t)
        values = [getattr(state, name) for state in epoch.states]
        field = np.full(X.shape, values[0])
        for front, before, after in zip(epoch.fronts, values, values[1:], strict=False):
            field = np.where(front.at(t) < X, field + (after - before), field)
        return field

    def stress(self, X: ArrayLike, t: float) -> Array:
        """Stress [Pa] at X [m], any shape, at one time t [s]."""
        return self._sample(X, t, "stress")

    def velocity(self, X: ArrayLike, t: float) -> Array:
        """Velocity away from the wall [m/s] at X [m], any shape, at one time t [s]."""
        return self._sample(X, t, "velocity")

    def plastic_strain(self, X: ArrayLike, t: float) -> Array:
        """Plastic strain [1], signed, outside hinges, at X [m], any shape, at one time t [s]."""
        return self._sample(X, t, "plastic_strain")

    def displacement(self, X: ArrayLike, t: float) -> Array:
        """Displacement away from the wall [m] at X [m], any shape, at one time t [s]; X = 0 is just outside the wall's hinge."""
        X = inside(X, 0.0, self.L, "PlasticBarImpact: X")
        self._at(t)
        u = np.zeros(X.shape)
        for epoch, end in self._spans(t):
            u += epoch.states[0].velocity * (end - epoch.start)
            for front, before, after in zip(epoch.fronts, epoch.states, epoch.states[1:], strict=False):
                u += (after.velocity - before.velocity) * front.time_left_of(X, epoch.start, end)
        return u

    def _spans(self, t: float) -> list[tuple[Epoch, float]]:
        """Epochs that begin before t, each with its end, cut at t."""
        ends = [epoch.start for epoch in self.epochs[1:]] + [self.end]
        return [(epoch, min(end, t)) for epoch, end in zip(self.epochs, ends, strict=True) if epoch.start < t]

    def contact_stress(self, t: ArrayLike) -> Array:
        """Stress at the wall [Pa] at times t [s], any shape; 0 while the bar is away from it."""
        times = inside(t, 0.0, self.end, "PlasticBarImpact: t")
        index = np.searchsorted([epoch.start for epoch in self.epochs], times, side="right") - 1
        return np.array([epoch.face_stress for epoch in self.epochs])[np.maximum(index, 0)]

    def energies(self, t: float) -> dict[str, float]:
        """Energies "kinetic", "elastic" and "plastic" (plastic work) [J/m^2 of cross section] at one time t [s]; their sum is constant."""
        epoch = self._at(t)
        w = epoch.widths(t, self.L)
        s, v, Y, _ = np.array(epoch.states).T
        hardening = 0.0 if self.Et == 0.0 else float(w @ (Y**2 - self.Y**2)) * 0.5 * (1.0 / self.Et - 1.0 / self.E)
        return {
            "kinetic": 0.5 * self.rho * float(w @ v**2),
            "elastic": 0.5 * float(w @ s**2) / self.E,
            "plastic": hardening + epoch.hinge_work + epoch.hinge_power * (t - epoch.start),
        }

    def mean_velocity(self, t: float) -> float:
        """Velocity of the centre of mass [m/s] at one time t [s]."""
        epoch = self._at(t)
        return float(epoch.widths(t, self.L) @ np.array([state.velocity for state in epoch.states])) / self.L

    def plastic_shortening(self, t: float) -> float:
        """Permanent shortening at one time t [s]: plastic strain and hinges together [m]."""
        epoch = self._at(t)
        strain = np.array([state.plastic_strain for state in epoch.states])
        hinges = epoch.hinge_shortening + epoch.hinge_rate * (t - epoch.start)
        return hinges - float(epoch.widths(t, self.L) @ strain)

    @property
    def separation_time(self) -> float:
        """When the bar leaves the wall for the last time before the end [s]; an error if it is still in contact there."""
        if self.epochs[-1].contact:
            raise ParameterError(f"PlasticBarImpact: the bar is still in contact at the end, t = {self.end:g} s; give a larger until")
        last = max(k for k, epoch in enumerate(self.epochs) if epoch.contact)
        return self.epochs[last + 1].start

    @property
    def restitution(self) -> float:
        """Velocity of the centre of mass after the separation over V0."""
        return self.mean_velocity(self.separation_time) / self.V0
