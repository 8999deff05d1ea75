"""The largest value for which something holds, found by trying: a ladder to the first failure, then bisection."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import attrs


@attrs.frozen
class Bracket:
    """Where something ceases to hold.

    Attributes
    ----------
    holds : float or None
        Largest value tried below the first failure; None if not even the lowest holds.
    fails : float or None
        Smallest value tried that fails; None if everything holds up to the highest.
    tried : int
        Number of values tried.
    """

    holds: float | None
    fails: float | None
    tried: int


def first_failure(holds: Callable[[float], bool], ladder: Sequence[float], width: float = 0.02) -> Bracket:
    """Find the first value at which `holds` is false.

    Climbs the ladder from its lowest rung, so that both ends of the interval that is then bisected have been tried, and a range that fails
    below one that holds again is not stepped over unless it is narrower than the rungs' distance. The search is of numbers alone: it
    depends on nothing but `holds`, which must give the same answer each time it is asked.

    Parameters
    ----------
    holds : callable
        Whether a value holds.
    ladder : sequence of float
        Values to try first, above zero and rising.
    width : float
        Ends when the smallest failure is at most this much above the largest value that holds, relative to it.

    Raises
    ------
    ValueError
        If the ladder is empty, not above zero or not rising, or the width is not above zero.
    """
    rungs = list(ladder)
    if not rungs or rungs[0] <= 0.0 or any(b <= a for a, b in pairwise(rungs)) or not width > 0.0:
        raise ValueError(f"a ladder of rising values above zero and a width above zero are needed, got {rungs} and {width}")
    low: float | None = None
    tried = 0
    for high in rungs:
        tried += 1
        if holds(high):
            low = high
            continue
        if low is None:
            return Bracket(None, high, tried)
        while high > low * (1.0 + width):
            middle = math.sqrt(low * high)
            tried += 1
            if holds(middle):
                low = middle
            else:
                high = middle
        return Bracket(low, high, tried)
    return Bracket(low, None, tried)


def ladder(low: float, high: float, rungs: int) -> list[float]:
    """`rungs` values from `low` to `high`, each the same multiple of the one before."""
    return [low * (high / low) ** (k / (rungs - 1)) for k in range(rungs)]
