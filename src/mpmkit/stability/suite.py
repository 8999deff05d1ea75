"""What a run of the suite found: verdicts by case and composition, what explains them, and the same as plain data."""

from __future__ import annotations

import math
from typing import Any

import attrs

from mpmkit.stability.case import Case, Composition, Figure, Verdict

Plain = dict[str, Any]
CASE_FACTS = ("name", "title", "failure", "criterion", "source", "dim", "waits_for")


@attrs.frozen
class Judged:
    """One cell.

    Attributes
    ----------
    case : Case
        The hard case.
    column : int
        Number of its composition in `Suite.compositions`.
    composition : Composition
        As the case saw it: without contact if its bodies never meet.
    verdict : Verdict
        What became of it.
    seconds : float
        Wall time; 0 if it was taken from earlier results.
    """

    case: Case
    column: int
    composition: Composition
    verdict: Verdict
    seconds: float = 0.0


@attrs.frozen
class Suite:
    """Verdicts of cases under compositions.

    Attributes
    ----------
    cases : tuple of Case
        Rows.
    compositions : tuple of Composition
        Columns.
    cells : tuple of Judged
        Verdicts, by case and then composition; a case that says nothing about a composition has no cell.
    quick : bool
        Whether runs were shorter or coarser.
    about : dict
        Date, machine and versions.
    """

    cases: tuple[Case, ...]
    compositions: tuple[Composition, ...]
    cells: tuple[Judged, ...]
    quick: bool = False
    about: Plain = attrs.field(factory=dict)

    def verdict(self, case: str, composition: Composition) -> Verdict | None:
        """Verdict of one cell; None if the case says nothing about the composition."""
        return next((c.verdict for c in self.cells if c.case.name == case and self.compositions[c.column] == composition), None)

    @property
    def unexplained(self) -> list[str]:
        """Cells that do not hold and that nothing explains."""
        from mpmkit.stability.expected import explain

        return [
            f"{c.case.name} under {c.composition.label}: {c.verdict.status}, {c.verdict.reason}"
            for c in self.cells
            if c.verdict.status in ("bounded", "fails") and explain(c.case.name, c.composition, c.verdict) is None
        ]

    @property
    def contradicted(self) -> list[str]:
        """Cells that hold although an explanation says they do not."""
        from mpmkit.stability.expected import contradicted

        found = ((c, contradicted(c.case.name, c.composition, c.verdict, self.quick)) for c in self.cells)
        return [f"{c.case.name} under {c.composition.label}: {text}" for c, text in found if text]

    @property
    def passed(self) -> bool:
        """Everything that does not hold is explained, and every explanation is true."""
        return not self.unexplained and not self.contradicted

    def data(self) -> Plain:
        """All of it as plain data, for JSON, tables and pictures."""
        from mpmkit.stability.compositions import heading
        from mpmkit.stability.expected import explain

        columns = []
        for c in self.compositions:
            group, label = heading(c)
            columns.append({"group": group, "label": label, "name": c.label})
        cells = []
        for one in self.cells:
            found = explain(one.case.name, one.composition, one.verdict) if one.verdict.status in ("bounded", "fails") else None
            cells.append(
                {"case": one.case.name, "composition": one.column}
                | verdict_data(one.verdict)
                | {"seconds": round(one.seconds, 2), "explanation": attrs.asdict(found) if found is not None else None}
            )
        return {
            "about": self.about,
            "quick": self.quick,
            "cases": [{name: getattr(case, name) for name in CASE_FACTS} for case in self.cases],
            "compositions": columns,
            "cells": cells,
            "unexplained": self.unexplained,
            "contradicted": self.contradicted,
        }


def verdict_data(verdict: Verdict) -> Plain:
    """A verdict as plain data; numbers that JSON does not have are text: "inf", "nan"."""
    return {
        "status": verdict.status,
        "reason": verdict.reason,
        "figures": [{"name": f.name, "value": _number(f.value), "limit": _number(f.limit)} for f in verdict.figures],
        "margin": _number(verdict.margin),
        "energy": _number(verdict.energy),
        "momentum": _number(verdict.momentum),
        "cautions": list(verdict.cautions),
    }


def verdict_of(data: Plain) -> Verdict:
    """The verdict that `verdict_data` has written."""
    energy, momentum = (None if data[name] is None else float(data[name]) for name in ("energy", "momentum"))
    figures = tuple(Figure(f["name"], float(f["value"]), float(f["limit"])) for f in data["figures"])
    return Verdict(data["status"], figures, data["reason"], energy, momentum, tuple(data["cautions"]))


def _number(value: float | None) -> float | str | None:
    if value is None:
        return None
    value = float(value)
    return value if math.isfinite(value) else str(value)
