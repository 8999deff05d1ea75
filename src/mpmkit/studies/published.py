"""What published studies know: for each composition its errors over the cells that a body has."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from mpmkit.errors import ResultsError
from mpmkit.studies import fit

if TYPE_CHECKING:
    from mpmkit.studies.results import StudyResults

FOLDER = Path(__file__).parent / "published"
"""Studies that come with mpmkit, as `StudyResults.save` writes them."""
FARTHEST = 4.0
"""How many times finer than the finest run an order is still trusted."""
WORTH = 0.25
"""Smallest order that is."""
INSIDE, COARSER, BEYOND = "measured", "coarser than any run", "by the observed order"
"""Where a number comes from."""


@attrs.frozen
class Known:
    """One composition in one study, with one error.

    Attributes
    ----------
    study, composition, measure : str
        Where it is from.
    components, problem : dict
        As in `mpmkit.studies.problem`.
    cells, errors : tuple of float
        Cells along the largest body, from few to many, and the errors there.
    travel : float, optional
        How many cells particles move at most.
    order : Order, optional
        Observed order.
    stalls : bool
        Whether more cells have stopped helping.
    nanoseconds : float, optional
        Of a particle-step, where it was measured.
    """

    study: str
    composition: str
    measure: str
    components: dict[str, Any]
    problem: dict[str, Any]
    cells: tuple[float, ...]
    errors: tuple[float, ...]
    travel: float | None
    order: fit.Order | None
    stalls: bool
    nanoseconds: float | None

    def error_at(self, cells: float) -> tuple[float, str] | None:
        """Error with so many cells, and where it is from; None too far beyond what was measured."""
        first, last = self.cells[0], self.cells[-1]
        if first * (1.0 - 1e-9) <= cells <= last * (1.0 + 1e-9):
            return _between(self.cells, self.errors, cells), INSIDE
        if cells < first:
            return self.errors[0], COARSER
        if self.order is None or self.order.slope < WORTH or self.stalls or cells > FARTHEST * last:
            return None
        return float(self.errors[-1] * (cells / last) ** -self.order.slope), BEYOND

    def cells_for(self, error: float) -> tuple[float, str] | None:
        """Fewest cells with at most this error, and where the number is from; None if it is not reached."""
        for k, e in enumerate(self.errors):
            if e <= error:
                if k == 0:
                    return self.cells[0], INSIDE
                share = math.log(self.errors[k - 1] / error) / math.log(self.errors[k - 1] / e) if e < self.errors[k - 1] else 1.0
                return float(self.cells[k - 1] * (self.cells[k] / self.cells[k - 1]) ** share), INSIDE
        if self.order is None or self.order.slope < WORTH or self.stalls:
            return None
        cells = self.cells[-1] * (self.errors[-1] / error) ** (1.0 / self.order.slope)
        return (float(cells), BEYOND) if cells <= FARTHEST * self.cells[-1] else None


def _between(x: tuple[float, ...], y: tuple[float, ...], at: float) -> float:
    import numpy as np

    return float(np.exp(np.interp(math.log(at), np.log(x), np.log(y))))


def load(paths: Iterable[str | os.PathLike[str]] = ()) -> list[StudyResults]:
    """Studies that come with mpmkit, and those in further files or folders.

    Raises
    ------
    ResultsError
        If a file is no result of a study, or a folder has none.
    """
    from mpmkit.studies.results import FILE, StudyResults

    files = sorted(FOLDER.glob("*.json"))
    for path in map(Path, paths):
        if path.is_dir() and not (path / FILE).is_file():
            inside = sorted(path.glob("*.json"))
            if not inside:
                raise ResultsError(f"there are no results of studies in {path}; mpmkit study FILE --report NAME.json writes them")
            files += inside
        else:
            files.append(path)
    return [StudyResults.load(path) for path in files]


def known(studies: Iterable[StudyResults]) -> list[Known]:
    """Everything that can be carried over to other scenes: errors without a unit, over two cell sizes or more."""
    found = []
    for results in studies:
        units = {m["label"]: m.get("unit", "1") for m in results.meta.get("errors", ())}
        facts = results.meta.get("compositions") or {}
        for measure in results.measures:
            if units.get(measure, "1") != "1" or (results.meta.get("resolution") or {}).get("unit") != "m":
                continue
            for name, rows in results.series(measure).items():
                one = _known(results.name, measure, name, rows, facts.get(name) or {})
                if one is not None:
                    found.append(one)
    return found


def _known(study: str, measure: str, name: str, rows: list[dict[str, Any]], facts: dict[str, Any]) -> Known | None:
    if not facts.get("problem") or not facts.get("components"):
        return None
    points = {
        facts["problem"]["length"] / r["resolution"]: r["errors"][measure] for r in rows if r["resolution"] and r["errors"][measure] > 0.0
    }
    if len(points) < 2:
        return None
    cells = tuple(sorted(points))
    travels = [r["travel"] for r in rows if r.get("travel") is not None]
    costs = [r["ns_per_particle_step"] for r in rows if r["ns_per_particle_step"]]
    return Known(
        study=study,
        composition=name,
        measure=measure,
        components=facts["components"],
        problem=facts["problem"],
        cells=cells,
        errors=tuple(points[n] for n in cells),
        travel=max(travels, default=None),
        order=fit.order(rows, measure),
        stalls=fit.stall(rows, measure) is not None,
        nanoseconds=costs[-1] if costs else None,
    )
