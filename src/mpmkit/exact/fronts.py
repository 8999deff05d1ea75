"""Follow the wave fronts of a bilinear bar at a wall from meeting to meeting.

Between two events all states are constant and all fronts straight, so the solution is exact; what is stored is one
`Epoch` per event.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import attrs
import numpy as np

from mpmkit.errors import ParameterError
from mpmkit.exact.bilinear import BilinearBar, State
from mpmkit.exact.solution import Array

MOST_EVENTS = 10_000


class Front(NamedTuple):
    """A front that passes x [m] at time t [s] with constant speed [m/s]."""

    x: float
    t: float
    speed: float

    def at(self, t: float) -> float:
        """Position [m] at time t [s]."""
        return self.x + self.speed * (t - self.t)

    def time_left_of(self, X: Array, start: float, end: float) -> Array:
        """For how much of [start, end] the front is left of the points X [s]."""
        if self.speed == 0.0:
            return np.where(self.x < X, end - start, 0.0)
        passes = np.clip(self.t + (X - self.x) / self.speed, start, end)
        return passes - start if self.speed > 0.0 else end - passes


@attrs.frozen
class Epoch:
    """A stretch of time without events: states from the wall to the free end and the fronts between them.

    Attributes
    ----------
    start : float
        Begin [s].
    states, fronts : tuple
        One state more than fronts.
    contact : bool
        Whether the bar touches the wall.
    gap : float
        Distance between the face and the wall at the start [m].
    face_stress : float
        Stress at the face [Pa].
    hinge_shortening, hinge_work : float
        Shortening [m] and plastic work [J/m^2] of all hinges up to the start.
    """

    start: float
    states: tuple[State, ...]
    fronts: tuple[Front, ...]
    contact: bool
    gap: float
    face_stress: float
    hinge_shortening: float
    hinge_work: float

    @property
    def hinges(self) -> list[tuple[float, float]]:
        """Rate of shortening [m/s] and stress [Pa] of each hinge; only perfect plasticity has any."""
        found = [
            (a.velocity - b.velocity, a.stress)
            for front, (a, b) in zip(self.fronts, pairwise(self.states), strict=True)
            if front.speed == 0.0
        ]
        return [(-self.states[0].velocity, self.face_stress), *found] if self.contact else found

    @property
    def hinge_rate(self) -> float:
        """Rate of shortening of all hinges [m/s]."""
        return sum(rate for rate, _ in self.hinges)

    @property
    def hinge_power(self) -> float:
        """Power of all hinges [W/m^2]."""
        return sum(-rate * stress for rate, stress in self.hinges)

    def widths(self, t: float, L: float) -> Array:
        """Length of each state's stretch at time t [m]."""
        return np.diff([0.0, *(front.at(t) for front in self.fronts), L])

    def next_event(self, L: float) -> float:
        """When a front meets a front or an end, or the open gap closes [s]; infinite if never."""
        now, fronts = self.start, self.fronts
        times = [now + (b.at(now) - a.at(now)) / (a.speed - b.speed) for a, b in pairwise(fronts) if a.speed > b.speed]
        if fronts and fronts[0].speed < 0.0:
            times.append(now - fronts[0].at(now) / fronts[0].speed)
        if fronts and fronts[-1].speed > 0.0:
            times.append(now + (L - fronts[-1].at(now)) / fronts[-1].speed)
        if not self.contact and self.states[0].velocity < 0.0:
            times.append(now - self.gap / self.states[0].velocity)
        return min(times, default=np.inf)


def follow(law: BilinearBar, start: State, L: float, end: float) -> list[Epoch]:
    """Follow a bar in state `start` that touches the wall at t = 0.

    Parameters
    ----------
    law : BilinearBar
        Its waves.
    start : State
        Uniform first state, moving towards the wall.
    L, end : float
        Length [m] and last time [s].

    Returns
    -------
    list of Epoch
        In order of time, the first one at t = 0.

    Raises
    ------
    ParameterError
        If there are more than ``MOST_EVENTS`` events before the end.
    """
    epochs = [_leave_wall(law, Epoch(0.0, (start,), (), True, 0.0, 0.0, 0.0, 0.0))]
    while (t := epochs[-1].next_event(L)) < end:
        epochs.append(_event(law, epochs[-1], t, L))
        if len(epochs) > MOST_EVENTS:
            raise ParameterError(f"until: more than {MOST_EVENTS} wave events before t = {end:g} s; give an until below {t:g}")
    return epochs


def _event(law: BilinearBar, old: Epoch, t: float, L: float) -> Epoch:
    """Resolve all meetings at time t: fronts with each other, with the free end, with the wall, and the closing of the gap."""
    tol = 1e-11 * L
    states, fronts = list(old.states), list(old.fronts)
    at_wall = at_end = False
    while fronts and fronts[0].speed < 0.0 and fronts[0].at(t) < tol:
        states, fronts, at_wall = states[1:], fronts[1:], True
    while fronts and fronts[-1].speed > 0.0 and fronts[-1].at(t) > L - tol:
        states, fronts, at_end = states[:-1], fronts[:-1], True
    gap = 0.0 if old.contact else old.gap + old.states[0].velocity * (t - old.start)
    closes = not old.contact and old.states[0].velocity < 0.0 and gap < tol
    new = attrs.evolve(
        old,
        start=t,
        gap=0.0 if closes else gap,
        contact=old.contact or closes,
        hinge_shortening=old.hinge_shortening + old.hinge_rate * (t - old.start),
        hinge_work=old.hinge_work + old.hinge_power * (t - old.start),
    )
    states, fronts = _meetings(law, states, fronts, t, tol)
    if at_end:
        more, speeds = law.to_left(states[-1], 0.0)
        states, fronts = states + more[1:], fronts + [Front(L, t, c) for c in speeds]
    new = attrs.evolve(new, states=tuple(states), fronts=tuple(fronts))
    return _leave_wall(law, new) if at_wall or closes else new


def _meetings(law: BilinearBar, states: list[State], fronts: list[Front], t: float, tol: float) -> tuple[list[State], list[Front]]:
    """Replace each cluster of fronts that run into each other at one point by the waves of its outer states."""
    out_states, out_fronts = [states[0]], []
    k = 0
    while k < len(fronts):
        last = k
        while last + 1 < len(fronts) and _meet(fronts[last], fronts[last + 1], t, tol):
            last += 1
        if last == k:
            out_fronts.append(fronts[k])
            out_states.append(states[k + 1])
        else:
            waves, speeds = law.interior(out_states[-1], states[last + 1])
            out_states[-1:] = waves
            out_fronts += [Front(fronts[k].at(t), t, c) for c in speeds]
        k = last + 1
    return out_states, out_fronts


def _meet(a: Front, b: Front, t: float, tol: float) -> bool:
    # Fronts that part from one point are as close at first, but run apart.
    return a.speed > b.speed and b.at(t) - a.at(t) < tol


def _leave_wall(law: BilinearBar, epoch: Epoch) -> Epoch:
    """Send off the waves of the wall end: held at rest while pressed, else stress-free."""
    stress = law.wall_stress(epoch.states[0]) if epoch.contact else 0.0
    contact = epoch.contact and stress <= law.tiny
    stress = stress if contact else 0.0
    waves, speeds = law.to_right(epoch.states[0], stress)
    fronts = tuple(Front(0.0, epoch.start, c) for c in speeds) + epoch.fronts
    return attrs.evolve(epoch, states=(*waves, *epoch.states[1:]), fronts=fronts, contact=contact, face_stress=stress)
