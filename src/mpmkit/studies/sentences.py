"""What a practitioner should know of a study, in sentences with numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from mpmkit.errors import ParameterError
from mpmkit.studies import fit
from mpmkit.studies.numbers import exponent, joined, number, plain, seconds, times
from mpmkit.studies.problem import CROSSING

if TYPE_CHECKING:
    from mpmkit.studies.results import Row, StudyResults

RUNS = "Runs and times"
NOISY = 0.25
"""Spread of the times of one run, as a share of their median, from which on it is told."""
ENOUGH, MOST = 3, 8
"""Errors that are asked for if nobody says which."""
CERTAIN = 20.0
"""Factor to the end of the confidence interval beyond which a price is called uncertain."""
HOW = {"unstable": "blew up", "over budget": "went over budget", "failed": "failed"}


def accuracy(text: str | float) -> float:
    """An asked error: 0.01, "0.01" or "1%".

    Raises
    ------
    ParameterError
        If it is no number above zero.
    """
    share = isinstance(text, str) and text.strip().endswith("%")
    try:
        value = float(text.strip().removesuffix("%")) / (100.0 if share else 1.0) if isinstance(text, str) else float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < math.inf:
        raise ParameterError(f"an asked error must be a number above zero or a percentage such as '1%', got {text!r}")
    return value


def sections(results: StudyResults, asked: Iterable[str | float] = ()) -> dict[str, list[str]]:
    """Sentences by title: one title for each error (and problem), then the runs that did not end well.

    Parameters
    ----------
    results : StudyResults
        The study.
    asked : iterable of float or str
        Errors that somebody needs ("1%", 0.01), in the unit of the measures; every power of ten that was reached if none are given.

    Raises
    ------
    ParameterError
        If an asked error is no number above zero.
    """
    wanted = sorted({accuracy(a) for a in asked}, reverse=True)
    units = {m["label"]: m.get("unit", "1") for m in results.meta.get("errors", ())}
    found = {}
    for measure in results.measures:
        for problem, part in results.parts().items():
            said = _Said(part, measure, units.get(measure, "1"), wanted)
            lines = [*said.cheapest(), *said.digits(), *said.never(), *said.stalls(), *said.particles()]
            found[titled(measure, problem)] = lines
    found[RUNS] = [*_ends(results), *_doubts(results)]
    return {title: lines for title, lines in found.items() if lines}


def titled(measure: str, problem: str) -> str:
    """Heading of what belongs to one error in one problem."""
    return f"{measure}, {problem}" if problem else measure


class _Said:
    """Sentences about one error."""

    def __init__(self, results: StudyResults, measure: str, unit: str, wanted: Sequence[float]) -> None:
        self.measure, self.unit = measure, unit
        self.rows = results.done(measure)
        self.series = results.series(measure)
        self.axis = results.meta.get("resolution") or {"name": "resolution", "unit": "1"}
        self.levels = list(wanted) or self._decades()

    def _decades(self) -> list[float]:
        """Powers of ten between the worst row and the best; steps of 1, 2, 5 where these are too few."""
        sizes = [r["errors"][self.measure] for r in self.rows if r["errors"][self.measure] > 0.0]
        if not sizes:
            return []
        low, high = min(sizes) * (1.0 - 1e-9), max(sizes)
        for steps in ((1.0,), (1.0, 2.0, 5.0)):
            powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 2)
            ladder = [float(f"{s}e{k}") for k in powers for s in steps]
            top = next(level for level in ladder if level >= high * (1.0 - 1e-9))
            found = [level for level in reversed(ladder) if low <= level <= top]
            if len(found) >= ENOUGH:
                break
        return found[:MOST]

    def error(self, value: float) -> str:
        return plain(value, self.unit)

    def at(self, resolution: float) -> str:
        name, unit = self.axis["name"], self.axis.get("unit", "1")
        return f"{name.rsplit('.', 1)[-1]} {plain(resolution, unit, 3)}"

    def cheapest(self) -> list[str]:
        """For each asked error what reaches it first; levels with the same answer together."""
        answers: dict[str, tuple[list[float], list[Row]]] = {}
        nothing = []
        for level in self.levels:
            found = fit.cheapest(self.rows, self.measure, level)
            if found:
                answers.setdefault(found[0]["label"], ([], found))[0].append(level)
            elif any(r["seconds"] is not None for r in self.rows):
                nothing.append(level)
        out = []
        for levels, found in answers.values():
            best = found[0]
            told = f"{'errors' if len(levels) > 1 else 'an error'} of {joined([self.error(level) for level in levels])}"
            line = f"For {told} the cheapest is {self._where(best)}"
            line += f": {self.error(best['errors'][self.measure])} in {seconds(best['seconds'])}"
            tight = fit.cheapest(self.rows, self.measure, levels[-1])  # what else reaches the smallest of these
            out.append(line + (self._next(best, tight[1]) if len(tight) > 1 else "; no other composition reaches it."))
        if nothing:
            out.append(f"No run has an error of {joined([self.error(level) for level in nothing])} or less.")
        return out

    def _where(self, row: Row) -> str:
        return f"{row['composition']} at {self.at(row['resolution'])}" if row["resolution"] else str(row["label"])

    def _next(self, best: Row, other: Row) -> str:
        where = self._where(other)
        if other["seconds_low"] is not None and best["seconds_high"] is not None and other["seconds_low"] <= best["seconds_high"]:
            return f"; {where} takes the same within the spread of the times ({seconds(other['seconds'])})."
        factor = other["seconds"] / best["seconds"]
        return f"; the next, {where}, takes {f'{times(factor)} as long' if factor >= 1.05 else 'hardly longer'}."

    def digits(self) -> list[str]:
        """What a tenth of the error costs in each composition, and the order behind it."""
        out = []
        for name, rows in self.series.items():
            order, price = fit.order(rows, self.measure), fit.next_digit(rows, self.measure)
            if order is None:
                continue
            between = f"{fit.CONFIDENCE:.0%} between {exponent(order.low)} and {exponent(order.high)}"
            line = f"{name}: observed order {exponent(order.slope)} ({between}, {order.count} resolutions)"
            if price is not None:
                certain = price.high < CERTAIN * price.factor
                spread = f"{number(price.low)} to {number(price.high)}" if certain else "uncertain: few resolutions"
                line += f"; the next digit costs {times(price.factor)} the time ({spread})"
            out.append(line + ".")
        return out

    def never(self) -> list[str]:
        """Compositions without a row that reaches an asked error, and why."""
        out = []
        for name, rows in self.series.items():
            best = min(rows, key=lambda r: r["errors"][self.measure])
            missed = [level for level in self.levels if best["errors"][self.measure] > level * (1.0 + 1e-9)]
            if not missed:
                continue
            halt = fit.stall(rows, self.measure)
            good = halt is not None and halt.for_good
            line = f"{name} {'never reaches' if good else 'does not reach'} {self.error(missed[0])}"
            if not good and len(rows) > 1:
                line += " with the resolutions of this study"
            out.append(f"{line}; its smallest error is {self.error(best['errors'][self.measure])}.")
        return out

    def stalls(self) -> list[str]:
        """Where finer cells stop helping, and who goes on there."""
        out = []
        orders = {name: fit.order(rows, self.measure) for name, rows in self.series.items()}
        for name, rows in self.series.items():
            halt = fit.stall(rows, self.measure)
            if halt is None:
                continue
            grows = halt.error_there > halt.error
            line = f"{name}: finer than {self.at(halt.resolution)} "
            line += "makes it worse" if grows else "hardly helps"
            finest = plain(halt.finest, self.axis.get("unit", "1"), 3)
            before = f" after {exponent(halt.before)}" if halt.before == halt.before else ""
            there = f"{self.error(halt.error)} there, {self.error(halt.error_there)} at {finest}"
            line += f" (error {there}, order {exponent(halt.after)}{before})"
            if halt.travel is not None and halt.travel >= CROSSING:
                on = [n for n, o in orders.items() if o is not None and fit.stall(self.series[n], self.measure) is None]
                best = max(on, key=lambda n: orders[n].slope, default=None)  # type: ignore[union-attr]
                line += f"; particles move up to {number(halt.travel)} cells there, so they cross cells"
                line += f", which {best} does not mind (order {exponent(orders[best].slope)})" if best else ""  # type: ignore[union-attr]
            elif halt.travel is not None:
                line += "; particles stayed in their cells whenever errors were taken, so crossing cells is hardly the reason"
            out.append(line + ".")
        return out

    def particles(self) -> list[str]:
        """What more particles in a cell gain and cost, where an axis varies them and everything else is equal."""
        out = []
        axes = [a for a in dict.fromkeys(a for r in self.rows for a in r["choices"]) if _per_cell(a) and a != self.axis["name"]]
        for axis in axes:
            groups: dict[str, list[Row]] = {}
            for row in self.rows:
                if isinstance(row["choices"].get(axis), (int, float)):
                    groups.setdefault(", ".join(v for a, v in row["labels"].items() if a != axis), []).append(row)
            for name, rows in groups.items():
                rows = sorted(rows, key=lambda r: r["choices"][axis])
                if len(rows) > 1:
                    out.append(self._gain(name, axis, rows))
        return out

    def _gain(self, name: str, axis: str, rows: list[Row]) -> str:
        errors = [r["errors"][self.measure] for r in rows]
        enough = next(k for k in range(len(rows)) if all(e > 0.8 * errors[k] for e in errors[k:]))
        row, last = rows[enough], rows[-1]
        where = f"{name}: " if name else ""
        if enough == len(rows) - 1:
            before = f"{self.error(errors[enough - 1])} with {rows[enough - 1]['choices'][axis]}"
            here = f"{where}more particles in a cell still help at {row['choices'][axis]}"
            return f"{here} (error {before}, {self.error(errors[enough])} with that)."
        line = f"{where}more than {row['choices'][axis]} particles in a cell do not help (error {self.error(errors[enough])}, "
        line += f"{self.error(errors[-1])} with {last['choices'][axis]}"
        if row["seconds"] and last["seconds"]:
            line += f", which takes {times(last['seconds'] / row['seconds'])} as long"
        return line + ")."


def _per_cell(axis: str) -> bool:
    return axis.endswith("particles_per_cell") or axis in ("ppc", "per_cell")


def _ends(results: StudyResults) -> list[str]:
    """Runs that were refused, failed, blew up or took too much, with the reason; those with the same reason together."""
    groups: dict[tuple[str, str], list[str]] = {}
    for row in results:
        if row["status"] != "done":
            groups.setdefault((row["status"], row["reason"].split("\n")[0]), []).append(row["label"])
    out = []
    for (status, reason), labels in groups.items():
        told = joined(labels[:4]) if len(labels) <= 4 else f"{'; '.join(labels[:3])} and {len(labels) - 3} more"
        how = HOW.get(status) or ("was refused" if len(labels) == 1 else "were refused")
        out.append(f"{told} {how}: {reason.rstrip('.')}.")
    return out


def _doubts(results: StudyResults) -> list[str]:
    """What makes the times uncertain, and whether anything is missing."""
    out = []
    spread = sorted((r["seconds_high"] - r["seconds_low"]) / r["seconds"] for r in results if r["seconds"])
    usual = spread[len(spread) // 2] if spread else 0.0
    if usual > NOISY:
        out.append(f"The times of half of the runs spread by more than {usual:.0%}: the machine was busy, small differences mean nothing.")
    if results.meta.get("complete") is False:
        out.append("The study was interrupted; runs are missing.")
    return out
