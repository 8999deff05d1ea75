"""What rows say together: observed orders with confidence, where refining stops helping, the Pareto front, the price of a digit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import attrs
import numpy as np

if TYPE_CHECKING:
    from mpmkit.studies.results import Row, StudyResults

CONFIDENCE = 0.95
LEAST = 3
"""Fewest resolutions for an order: two points always lie on a line, and tell nothing of how well."""
SLOWER, STOPPED = 0.5, 0.1
"""Refining stops helping where the order falls below half of what it was over `LEAST` resolutions, or below a tenth."""


@attrs.frozen
class Line:
    """A power law y = C x^p, fitted by least squares in logarithms.

    Attributes
    ----------
    slope : float
        p.
    low, high : float
        Its confidence interval, by Student's t.
    constant : float
        C.
    count : int
        Points.
    """

    slope: float
    low: float
    high: float
    constant: float
    count: int

    def at(self, x: float) -> float:
        """The fitted y."""
        return float(self.constant * x**self.slope)


@attrs.frozen
class Order(Line):
    """Observed order of a composition: error = C h^p.

    Attributes
    ----------
    finest : float
        Smallest resolution that was used.
    """

    finest: float = 0.0


@attrs.frozen
class Stall:
    """Where finer resolutions stop helping.

    Attributes
    ----------
    resolution, error : float
        Of the last row that was still worth it.
    finest, error_there : float
        Of the finest row.
    before, after : float
        Orders up to it (nan if it is the coarsest) and from it on.
    travel : float, optional
        How many cells particles move in the finest run, if that is known.
    """

    resolution: float
    error: float
    finest: float
    error_there: float
    before: float
    after: float
    travel: float | None = None

    @property
    def for_good(self) -> bool:
        """Whether nothing at all is gained."""
        return self.after < STOPPED


@attrs.frozen
class NextDigit:
    """How much more time a tenth of the error takes: a factor, and its confidence interval."""

    factor: float
    low: float
    high: float


def line(x: Sequence[float], y: Sequence[float], confidence: float = CONFIDENCE) -> Line | None:
    """Fit y = C x^p to positive numbers; None with fewer than `LEAST` different x.

    The slope of the regression of log y on log x has the standard error sqrt(S / (n - 2) / sum((log x - mean)^2)), S the sum of the
    squares of the residuals; the interval is the t-quantile for n - 2 degrees of freedom times that, to both sides.
    """
    kept = [(math.log(a), math.log(b)) for a, b in zip(x, y, strict=True) if a > 0.0 and b > 0.0]
    if len({a for a, _ in kept}) < LEAST:
        return None
    u, v = np.array(kept).T
    centred = u - u.mean()
    spread = float(centred @ centred)
    slope = float(centred @ v) / spread
    residuals = v - v.mean() - slope * centred
    from scipy.stats import t as student

    half = float(student.ppf(0.5 + 0.5 * confidence, len(u) - 2)) * math.sqrt(float(residuals @ residuals) / (len(u) - 2) / spread)
    return Line(slope, slope - half, slope + half, math.exp(float(v.mean() - slope * u.mean())), len(u))


def order(rows: Iterable[Row], measure: str) -> Order | None:
    """Observed order of the rows of one composition, coarse to fine; of those before refining stops helping, if these are enough."""
    rows = _positive(rows, measure)
    halt = stall(rows, measure)
    useful = [r for r in rows if halt is None or r["resolution"] >= halt.resolution * (1.0 - 1e-9)]
    for chosen in (useful, rows):
        h = [r["resolution"] for r in chosen]
        found = line(h, [r["errors"][measure] for r in chosen])
        if found is not None:
            return Order(**attrs.asdict(found), finest=min(h))
    return None


def orders(results: StudyResults, measure: str) -> dict[str, Order | None]:
    """Observed order of each composition; None where there are too few resolutions."""
    return {name: order(rows, measure) for name, rows in results.series(measure).items()}


def stall(rows: Iterable[Row], measure: str) -> Stall | None:
    """Where finer resolutions of one composition stop helping: what is gained after it is far below what was gained before."""
    rows = _positive(rows, measure)
    if len({r["resolution"] for r in rows}) < 2:
        return None
    h, e = ([float(v) for v in column] for column in ([r["resolution"] for r in rows], [r["errors"][measure] for r in rows]))
    for k in range(len(h) - 1):
        before, after = _slope(h[: k + 1], e[: k + 1]), _slope(h[k:], e[k:])
        usual = before if len(set(h[: k + 1])) >= LEAST else 0.0  # a single step is no order
        if after < max(STOPPED, SLOWER * usual):
            return Stall(h[k], e[k], h[-1], e[-1], before, after, rows[-1].get("travel"))
    return None


def _slope(h: list[float], e: list[float]) -> float:
    u, v = np.log(h), np.log(e)
    u = u - u.mean()
    return float(u @ v / (u @ u)) if float(u @ u) > 0.0 else math.nan


def _positive(rows: Iterable[Row], measure: str) -> list[Row]:
    found = [r for r in rows if r["resolution"] and r["errors"].get(measure, 0.0) > 0.0]
    return sorted(found, key=lambda r: -r["resolution"])


def front(rows: Iterable[Row], measure: str) -> list[Row]:
    """Rows that no other beats in both time and error, from fast to accurate."""
    timed = sorted(
        (r for r in rows if measure in r["errors"] and r["seconds"] is not None), key=lambda r: (r["seconds"], r["errors"][measure])
    )
    best, found = math.inf, []
    for row in timed:
        if row["errors"][measure] < best:
            best = row["errors"][measure]
            found.append(row)
    return found


def next_digit(rows: Iterable[Row], measure: str) -> NextDigit | None:
    """Price of a tenth of the error for one composition, from its useful rows; None with too few, or where refining does not help.

    With time = C error^-q, fitted by `line`, it is 10^q.
    """
    rows = _positive(rows, measure)
    halt = stall(rows, measure)
    if halt is not None:
        rows = [r for r in rows if r["resolution"] >= halt.resolution * (1.0 - 1e-9)]
    timed = [r for r in rows if r["seconds"]]
    found = line([r["errors"][measure] for r in timed], [r["seconds"] for r in timed])
    if found is None or found.slope >= 0.0:
        return None
    return NextDigit(*(10.0 ** -max(s, -300.0) for s in (found.slope, found.high, found.low)))


def cheapest(rows: Iterable[Row], measure: str, error: float) -> list[Row]:
    """The fastest row of each composition with at most this error, fastest first."""
    found: dict[str, Row] = {}
    for row in rows:
        if row["seconds"] is not None and measure in row["errors"] and row["errors"][measure] <= error * (1.0 + 1e-9):
            old = found.get(row["composition"])
            if old is None or row["seconds"] < old["seconds"]:
                found[row["composition"]] = row
    return sorted(found.values(), key=lambda r: r["seconds"])
