"""The history of a run: one row of numbers every few steps, as CSV that anything can read."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Self

import numpy as np

from mpmkit._core.running.paths import claim
from mpmkit.errors import ResultsError, shown


class HistoryFile:
    """A CSV file to which rows are appended. Made by `create` or `reopen`.

    Each row is flushed when it is written, so a killed run leaves all of them; numbers are written in the shortest
    form that reads back to the same bits.
    """

    def __init__(self, path: Path, columns: tuple[str, ...], stream: IO[str]) -> None:
        self.path, self.columns, self._stream = path, columns, stream
        self._writer = csv.writer(stream, lineterminator="\n")

    @classmethod
    def create(cls, path: str | os.PathLike[str], columns: Sequence[str], overwrite: bool = False) -> HistoryFile:
        """Start a history and write its header.

        Parameters
        ----------
        path : path
            The file, by habit `paths.history_path` of the result file.
        columns : sequence of str
            Names; one is "step", by which a resumed run cuts the file.
        overwrite : bool
            Replace an existing file.

        Raises
        ------
        ResultsError
            If the file exists or cannot be written, or the columns are unfit.
        """
        columns = tuple(columns)
        if "step" not in columns or len(set(columns)) < len(columns):
            raise ResultsError(f"{path}: the columns of a history must be different names, one of them 'step'; got {list(columns)}")
        path = claim(path, overwrite=overwrite, what="the history")
        try:
            stream = path.open("w", encoding="utf-8", newline="")
        except OSError as error:
            raise ResultsError(f"{path}: cannot write the history ({error.strerror}); choose a path that can be written") from error
        made = cls(path, columns, stream)
        made._row(columns)
        return made

    @classmethod
    def reopen(cls, path: str | os.PathLike[str], step: int | None = None) -> HistoryFile:
        """Open a history to append more rows; drop those after `step`, and a last row cut short by a kill.

        Raises
        ------
        ResultsError
            If the file is missing or is no history.
        """
        path = Path(path)
        columns = _header(path)
        _truncate(path, columns.index("step"), step)
        return cls(path, columns, path.open("a", encoding="utf-8", newline=""))

    def append(self, row: Mapping[str, Any] | Sequence[Any]) -> None:
        """Add one row: a mapping with exactly the columns as keys, or a sequence in their order.

        Raises
        ------
        ResultsError
            If the row does not fit the columns, or the disk is full.
        """
        if isinstance(row, Mapping):
            if set(row) != set(self.columns):
                wrong = sorted(set(row) ^ set(self.columns))
                raise ResultsError(f"{self.path}: a row of the history must have exactly its columns; these differ: {', '.join(wrong)}")
            row = [row[name] for name in self.columns]
        if len(row) != len(self.columns):
            raise ResultsError(f"{self.path}: a row of {len(row)} numbers for {len(self.columns)} columns")
        self._row([_text(value) for value in row])

    def truncate(self, step: int) -> None:
        """Drop all rows after `step`."""
        self._stream.close()
        _truncate(self.path, self.columns.index("step"), step)

    def close(self) -> None:
        """Close the file; does nothing the second time. A later row opens it again."""
        self._stream.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *args: object) -> None:
        self.close()

    def _row(self, texts: Sequence[str]) -> None:
        try:
            if self._stream.closed:
                self._stream = self.path.open("a", encoding="utf-8", newline="")
                self._writer = csv.writer(self._stream, lineterminator="\n")
            self._writer.writerow(texts)
            self._stream.flush()
        except OSError as error:
            raise ResultsError(f"{self.path}: cannot write a row of the history ({error.strerror}); the rows before it are kept") from error


def read_history(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """Read a history, also while it is being written.

    Returns
    -------
    dict of str to array (rows,)
        int64 where all values are whole, float64 where all are numbers, else text.

    Raises
    ------
    ResultsError
        If the file is missing or damaged; names the row.
    """
    path = Path(path)
    columns = _header(path)
    try:
        text = path.read_text(encoding="utf-8")
        whole = text[: text.rfind("\n") + 1]  # a row without its end is still being written
        rows = list(csv.reader(io.StringIO(whole)))[1:]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise _damaged(path, str(error)) from error
    for number, row in enumerate(rows, start=2):
        if len(row) != len(columns):
            raise _damaged(path, f"line {number} has {len(row)} entries for {len(columns)} columns")
    found = {name: _array([row[k] for row in rows]) for k, name in enumerate(columns)}
    for k, (name, column) in enumerate(found.items()):
        numbers = [_is_number(row[k]) for row in rows] if column.dtype.kind == "U" else []
        if any(numbers):
            line = numbers.index(False) + 2
            raise _damaged(path, f"line {line} has {shown(rows[line - 2][k], 40)} for {name}, which is no number")
    return found


def _damaged(path: Path, reason: str) -> ResultsError:
    return ResultsError(f"{path} is damaged: {reason}; copy it again from where it was written, or run the scene again")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _header(path: Path) -> tuple[str, ...]:
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            first = stream.readline()
    except FileNotFoundError:
        raise ResultsError(f"{path}: no such history; it is written beside the result file and must stay there") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ResultsError(f"{path} is not a history: {error}") from error
    columns = tuple(next(csv.reader([first]), []))
    if not first.endswith("\n") or "step" not in columns:
        raise ResultsError(f"{path} is not a history: its first line must name the columns, one of them 'step'; found {first[:60]!r}")
    return columns


def _truncate(path: Path, column: int, step: int | None) -> None:
    """Cut the file after the last whole row up to `step`; rows before it are not touched."""
    with path.open("rb+") as file:
        file.readline()
        end = file.tell()
        for line in iter(file.readline, b""):
            try:
                row = next(csv.reader([line.decode()]), [])
                later = len(row) > column and step is not None and int(row[column]) > step
            except (ValueError, csv.Error) as error:
                if not line.endswith(b"\n"):
                    break
                raise _damaged(path, f"{shown(line, 60)} is no row ({error})") from error
            if not line.endswith(b"\n") or len(row) <= column or later:
                break
            end = file.tell()
        file.truncate(end)


def _text(value: Any) -> str:
    if isinstance(value, str):
        return " ".join(value.split())  # one line per row
    if isinstance(value, (bool, np.bool_)):
        return str(int(value))
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return repr(float(value))


def _array(texts: list[str]) -> np.ndarray:
    for kind in (np.int64, np.float64):
        try:
            return np.array(texts, dtype=kind) if texts else np.empty(0)
        except ValueError:
            continue
    return np.array(texts)
