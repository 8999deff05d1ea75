"""Named quantities of interest: one number from the history and the particles of a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from mpmkit.errors import ParameterError
from mpmkit.studies.samples import Sample


@attrs.frozen
class Facts:
    """What a quantity is computed from.

    Attributes
    ----------
    history : dict
        Columns of the ledger over time, as `Simulation.history`.
    samples : list of Sample
        Particles at the start and at the times asked for; the last is the end of the run.
    bodies : tuple of str
        Bodies that are meant, in order.
    axis : int
        Direction that is meant.
    """

    history: dict[str, Any]
    samples: list[Sample]
    bodies: tuple[str, ...]
    axis: int


@attrs.frozen
class Named:
    """A quantity of the library."""

    compute: Callable[[Facts], float]
    unit: str
    doc: str
    exact: float | None = None


def _velocity(sample: Sample, body: str) -> Any:
    """Velocity of a body's centre of mass."""
    fields = sample.bodies[body]
    return (fields["m"][:, None] * fields["v"]).sum(axis=0) / fields["m"].sum()


def restitution(facts: Facts) -> float:
    """Relative speed after over before along the line of centres, or speed of one body along the axis."""
    first, last = facts.samples[0], facts.samples[-1]
    if len(facts.bodies) == 1:
        before, after = (_velocity(s, facts.bodies[0])[facts.axis] for s in (first, last))
        return float(-after / before)
    a, b = facts.bodies[:2]
    n = np.mean(first.bodies[b]["x"], axis=0) - np.mean(first.bodies[a]["x"], axis=0)
    n = n / np.linalg.norm(n)
    before, after = ((_velocity(s, b) - _velocity(s, a)) @ n for s in (first, last))
    return float(-after / before)


def _extent(x: Any) -> float:
    return float(x.max() - x.min())


def final_length(facts: Facts) -> float:
    """Length of the first body along the axis: that at the start, times how much its outermost particles' distance changed."""
    body, axis = facts.bodies[0], facts.axis
    first, last = (s.bodies[body]["x"][:, axis] for s in (facts.samples[0], facts.samples[-1]))
    places = np.unique(np.round(first / max(_extent(first), 1e-300), 9))
    if len(places) < 2:
        raise ParameterError("final length needs a body of at least two particles along the axis")
    return _extent(last) * (1.0 + 1.0 / (len(places) - 1))


def run_out(facts: Facts) -> float:
    """How far the front of the first body has moved along the axis."""
    body, axis = facts.bodies[0], facts.axis
    first, last = (s.bodies[body]["x"][:, axis] for s in (facts.samples[0], facts.samples[-1]))
    return float(last.max() - first.max())


def period(facts: Facts) -> float:
    """Twice the mean time between zeros of the momentum along the axis."""
    from scipy.interpolate import CubicSpline

    t, p = facts.history["t"], facts.history["momentum_" + "xyz"[facts.axis]]
    times, keep = np.unique(t, return_index=True)
    zeros = CubicSpline(times, p[keep]).roots(extrapolate=False) if len(times) > 3 else np.zeros(0)
    if len(zeros) < 2:
        raise ParameterError("period: the momentum changes its sign less than twice; run longer, or choose another axis")
    return float(2.0 * (zeros[-1] - zeros[0]) / (len(zeros) - 1))


def _column(name: str) -> Callable[[Facts], float]:
    return lambda facts: float(facts.history[name][-1])


LIBRARY: dict[str, Named] = {
    "restitution": Named(restitution, "1", "relative speed of two bodies after over before; of one body its speed along the axis"),
    "final length": Named(final_length, "m", "length of the first body along the axis at the end"),
    "run-out": Named(run_out, "m", "advance of the first body's front along the axis"),
    "period": Named(period, "s", "twice the mean time between zeros of the momentum along the axis"),
    "energy drift": Named(_column("balance"), "1", "energy that appeared (or vanished), over the largest energy of the run", 0.0),
    "largest energy drift": Named(lambda f: float(np.abs(f.history["balance"]).max()), "1", "the same, its largest size in the run", 0.0),
    "loss of energy": Named(
        lambda f: float(1.0 - (f.history["kinetic"] + f.history["stored"])[-1] / (f.history["kinetic"] + f.history["stored"])[0]),
        "1",
        "mechanical energy at the end that is missing, over that at the start",
        0.0,
    ),
    "kinetic energy": Named(_column("kinetic"), "J", "at the end"),
    "stored energy": Named(_column("stored"), "J", "at the end"),
    "dissipated energy": Named(_column("dissipated"), "J", "at the end"),
}
"""Quantities by name."""
