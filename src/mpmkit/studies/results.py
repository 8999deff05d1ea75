"""`StudyResults`: the rows of a study, one for each run, with errors, wall times and, for those that did not end well, the reason."""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpmkit.errors import ResultsError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STATUS = ("done", "refused", "failed", "unstable", "over budget")
"""How a run ended: every row has one of these."""

FORMAT = 1
"""Of the file that `save` writes."""

REPORTS = (".html", ".md", ".csv", ".json", ".png", ".svg")
"""Kinds of report, by the ending of the file."""

FILE = "study.json"
"""Name of that file in the folder of a study."""

Row = dict[str, Any]

EMPTY: Row = {
    "label": "",
    "composition": "",
    "choices": {},
    "labels": {},
    "problem": "",
    "status": "done",
    "reason": "",
    "errors": {},
    "resolution": None,
    "seconds": None,
    "seconds_low": None,
    "seconds_high": None,
    "repeats": 0,
    "steps": None,
    "particles": None,
    "ns_per_particle_step": None,
    "peak_bytes": None,
    "travel": None,
    "reference_seconds": None,
    "notes": [],
}
"""All keys of a row, with what they hold where nothing is known."""


class StudyResults:
    """Rows of a study and facts about it; plain data throughout.

    Parameters
    ----------
    rows : iterable of mapping
        One for each run; keys that are missing are filled from `EMPTY`.
    meta : mapping
        "name"; "errors", a list of {"label", "unit"} of the measures; "resolution", {"name", "unit"}; "axes"; "machine";
        "versions"; "scene", text; "compositions", {name: {"problem", "components"}}
        as in `mpmkit.studies.problem`; "reference", {"label", "seconds": [...]} of the run that was repeated beside all others;
        "complete", whether all planned runs are there.

    Notes
    -----
    Keys of a row:

    - "label": choices of all axes in short; "composition": the same without the resolution, so that runs of one composition
      share it;
    - "problem": those choices that make another problem, in short; runs are only compared with those of the same;
    - "choices": {axis: plain value}, "labels": {axis: short text};
    - "status": one of `STATUS`; "reason": why, if it is not "done"; "notes": what else should be known;
    - "errors": {measure label: number}; empty if the run did not end well;
    - "resolution": number, smaller is finer: the cell size [m], unless another axis refines;
    - "seconds": median wall time [s] of stepping, "seconds_low" and "seconds_high" fastest and slowest of the "repeats"; None if not timed;
    - "reference_seconds": median wall time of the reference run measured beside it;
    - "steps", "particles", "ns_per_particle_step", "peak_bytes" (of a process that does nothing else);
    - "travel": how many cells a particle is away from its start, at most, at the instants that errors are taken at.

    Examples
    --------
    >>> row = {
    ...     "label": "Linear, 0.1", "composition": "Linear", "choices": {"shape": "Linear", "grid.spacing": 0.1},
    ...     "labels": {"shape": "Linear", "grid.spacing": "0.1"}, "errors": {"stress.xx, L1 [Pa]": 0.25}, "resolution": 0.1,
    ...     "seconds": 0.012, "seconds_low": 0.011, "seconds_high": 0.014, "repeats": 3, "steps": 175, "particles": 10,
    ...     "ns_per_particle_step": 6857.0, "peak_bytes": 130_000_000,
    ... }
    >>> results = StudyResults([row], {"name": "bar", "errors": [{"label": "stress.xx, L1 [Pa]", "unit": "Pa"}]})
    >>> results.measures
    ('stress.xx, L1 [Pa]',)
    >>> [r["seconds"] for r in results.done("stress.xx, L1 [Pa]")]
    [0.012]
    """  # fmt: skip

    def __init__(self, rows: Iterable[Mapping[str, Any]], meta: Mapping[str, Any] | None = None) -> None:
        self.rows: list[Row] = [{**_fresh(), **row} for row in rows]
        self.meta: dict[str, Any] = dict(meta or {})
        for row in self.rows:
            if row["status"] not in STATUS:
                raise ResultsError(f"row {row['label']!r}: status must be one of {', '.join(STATUS)}, got {row['status']!r}")

    @property
    def name(self) -> str:
        """Name of the study."""
        return str(self.meta.get("name", "study"))

    @property
    def measures(self) -> tuple[str, ...]:
        """Labels of the error measures, with norm and unit."""
        told = [str(m["label"]) for m in self.meta.get("errors", ())]
        return tuple(dict.fromkeys([*told, *(label for row in self.rows for label in row["errors"])]))

    def table(self) -> list[Row]:
        """All rows as plain dicts; see the class for their keys."""
        return [dict(row) for row in self.rows]

    def done(self, measure: str | None = None) -> list[Row]:
        """Rows of runs that ended well; with a measure, those that have a finite error above zero of it."""
        rows = [row for row in self.rows if row["status"] == "done"]
        return rows if measure is None else [row for row in rows if 0.0 < (row["errors"].get(measure) or 0.0) < math.inf]

    def compositions(self) -> tuple[str, ...]:
        """Their labels, in the order of the rows."""
        return tuple(dict.fromkeys(row["composition"] for row in self.rows))

    def series(self, measure: str) -> dict[str, list[Row]]:
        """Rows with an error of `measure` by composition, from coarse to fine."""
        found: dict[str, list[Row]] = {}
        for row in self.done(measure):
            found.setdefault(row["composition"], []).append(row)
        return {name: sorted(rows, key=lambda r: -(r["resolution"] or 0.0)) for name, rows in found.items()}

    def parts(self) -> dict[str, StudyResults]:
        """The study by problem, with compositions named without it: what can be compared. Itself alone if there is one problem."""
        problems = list(dict.fromkeys(row["problem"] for row in self.rows))
        if len(problems) < 2:
            return {"": self}
        found = {}
        for problem in problems:
            rows = [row for row in self.rows if row["problem"] == problem]
            found[problem] = StudyResults([row | {"composition": _without(row["composition"], problem)} for row in rows], self.meta)
        return found

    # --- files --------------------------------------------------------------------------------------------------
    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write everything as JSON, for `load`; a folder gets a file `study.json`."""
        path = Path(path)
        path = path / FILE if path.is_dir() else path
        text = json.dumps({"format": FORMAT, "meta": self.meta, "rows": self.rows}, indent=1, ensure_ascii=False, default=str)
        return write(path, text + "\n")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> StudyResults:
        """Read what `save` has written: the file, or the folder of a study.

        Raises
        ------
        ResultsError
            If there is none, or the file is something else.
        """
        path = Path(path)
        path = path / FILE if path.is_dir() else path
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            raise ResultsError(f"there are no results of a study at {path}; mpmkit study FILE --folder {path.parent} makes them") from None
        except (OSError, UnicodeDecodeError) as error:
            raise ResultsError(f"cannot read the results of a study at {path}: {error}") from None
        except json.JSONDecodeError as error:
            raise ResultsError(f"{path} is no result of a study: not valid JSON ({error})") from None
        if not isinstance(data, dict) or "rows" not in data:
            raise ResultsError(f"{path} is no result of a study: it has no rows")
        if data.get("format") != FORMAT:
            raise ResultsError(f"{path} has the format {data.get('format')!r}, this mpmkit reads {FORMAT}; do the study again")
        return cls(data["rows"], data.get("meta"))

    def to_csv(self, path: str | os.PathLike[str] | None = None) -> str:
        """Rows as CSV, a column for each axis and each error; written to `path` if one is given."""
        heads, rows = self._columns()
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows([["" if v is None else v for v in row] for row in rows])
        return self._text(out.getvalue(), path)

    def to_markdown(self, path: str | os.PathLike[str] | None = None) -> str:
        """Rows as a Markdown table, numbers with three digits; written to `path` if one is given."""
        heads, rows = self._columns(short=True)
        lines = [heads, ["---"] * len(heads), *[[_short(v) for v in row] for row in rows]]
        return self._text("\n".join("| " + " | ".join(c.replace("|", "\\|") for c in line) + " |" for line in lines) + "\n", path)

    def to_pandas(self) -> Any:
        """Rows as a pandas DataFrame, a column for each axis and each error."""
        try:
            import pandas as pd
        except ImportError:
            raise ResultsError("to_pandas needs pandas: pip install 'mpmkit[frames]'") from None
        heads, rows = self._columns()
        return pd.DataFrame(rows, columns=heads)

    def _columns(self, short: bool = False) -> tuple[list[str], list[list[Any]]]:
        """Column heads, and a line for each row."""
        axes = list(dict.fromkeys(axis for row in self.rows for axis in row["labels"]))
        heads = ["label", *axes, "status", *self.measures]
        facts = ["seconds", "seconds_low", "seconds_high", "steps", "particles", "ns_per_particle_step", "peak_bytes"]
        facts = [*facts, "reason"] if short else ["resolution", *facts, "travel", "repeats", "reference_seconds", "reason"]
        heads = heads[1:] if short and axes else heads
        lines = []
        for row in self.rows:
            line = [row["label"], *(row["labels"].get(a) for a in axes), row["status"], *(row["errors"].get(m) for m in self.measures)]
            lines.append((line[1:] if short and axes else line) + [row[f] for f in facts])
        return heads + facts, lines

    @staticmethod
    def _text(text: str, path: str | os.PathLike[str] | None) -> str:
        if path is not None:
            write(Path(path), text)
        return text

    # --- for people ---------------------------------------------------------------------------------------------
    def sentences(self, asked: Iterable[str | float] = ()) -> list[str]:
        """What a practitioner should know: the cheapest composition for an error, the price of the next digit, what never gets there.

        Parameters
        ----------
        asked : iterable of float or str
            Errors that are needed, in the unit of the measures (0.01, "1%"); powers of ten if none are given.
        """
        from mpmkit.studies.sentences import sections

        return [line for lines in sections(self, asked).values() for line in lines]

    def plot(self, path: str | os.PathLike[str] | None = None, measure: str | None = None, kind: str | None = None) -> Figure:
        """Draw errors against wall time (with the Pareto front) and against the resolution (with fitted orders).

        Parameters
        ----------
        path : path, optional
            Picture file to write, .png or .svg.
        measure : str, optional
            Label of one error; all if not given.
        kind : str, optional
            "work-precision" or "convergence"; both if not given.

        Returns
        -------
        matplotlib.figure.Figure
            To add to or to save.

        Raises
        ------
        ResultsError
            If there is nothing to draw, or the file cannot be written.
        """
        from mpmkit.studies import pictures

        return pictures.draw(self, measure, kind) if path is None else pictures.save(self, path, measure, kind)

    def report(self, path: str | os.PathLike[str], asked: Iterable[str | float] = ()) -> Path:
        """Write a report, by its ending one of `REPORTS`: a page, a table with sentences (.md), rows (.csv), everything (.json), pictures.

        Raises
        ------
        ResultsError
            For another ending, or if the file cannot be written.
        """
        path = Path(path)
        check_ending(path)
        if path.suffix == ".html":
            from mpmkit.studies import html

            html.save(self, path, asked)
        elif path.suffix == ".md":
            from mpmkit.studies.sentences import sections

            said = "".join(f"## {title}\n\n" + "".join(f"- {x}\n" for x in lines) + "\n" for title, lines in sections(self, asked).items())
            write(path, f"# {self.name}\n\n{said}## All runs\n\n{self.to_markdown()}")
        elif path.suffix == ".csv":
            self.to_csv(path)
        elif path.suffix == ".json":
            self.save(path)
        else:
            self.plot(path)
        return path

    def _repr_html_(self) -> str:
        from mpmkit.studies.html import fragment

        return fragment(self)

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    def __repr__(self) -> str:
        ends = {s: sum(row["status"] == s for row in self.rows) for s in STATUS}
        told = ", ".join(f"{n} {s}" for s, n in ends.items() if n)
        return f"<StudyResults {self.name!r}: {len(self)} runs ({told or 'none'}), errors: {', '.join(self.measures) or 'none'}>"


def write(path: Path, text: str) -> Path:
    """Write a text file whole or not at all.

    Raises
    ------
    ResultsError
        If it cannot be written; says where and why.
    """
    temporary = path.with_name(path.name + ".tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    except OSError as error:
        raise ResultsError(f"cannot write {path}: {error.strerror or error}; choose another place") from None
    return path


def check_ending(path: str | os.PathLike[str]) -> None:
    """Refuse a report whose kind is not known.

    Raises
    ------
    ResultsError
        If the ending is none of `REPORTS`.
    """
    if Path(path).suffix not in REPORTS:
        raise ResultsError(f"cannot write a report to {path}: it must end in {', '.join(REPORTS)}")


def check_writable(path: str | os.PathLike[str]) -> None:
    """Find out before long work whether a file can be written to a place.

    Raises
    ------
    ResultsError
        If it cannot.
    """
    path = Path(path)
    if path.is_dir():
        raise ResultsError(f"cannot write {path}: it is a folder; give the name of a file")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(path, "ab"):
            pass
        if path.stat().st_size == 0:
            path.unlink()
    except OSError as error:
        raise ResultsError(f"cannot write {path}: {error.strerror or error}; choose another place") from None


def _without(composition: str, problem: str) -> str:
    """The name of a composition without its problem."""
    for part in problem.split(", "):
        composition = ", ".join(p for p in composition.split(", ") if p != part)
    return composition or problem


def _fresh() -> Row:
    return {key: value.copy() if isinstance(value, (dict, list)) else value for key, value in EMPTY.items()}


def _short(value: Any) -> str:
    if value is None:
        return ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)
