"""The history of a run: one row of numbers every few steps, as CSV that anything can read.

The last column, ``check``, is the CRC-32 of the first line and the row before it: a digit that has changed on the way is noticed.
"""

from __future__ import annotations

import csv
import io
import os
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any, Self

import numpy as np

from mpmkit._core.running.paths import claim
from mpmkit.errors import ResultsError

CHECK = "check"
"""Name of the column with the checksums."""


class HistoryFile:
    """A CSV file to which rows are appended. Made by `create` or `reopen`.

    Each row is flushed when it is written, so a killed run leaves all of them; numbers are written in the shortest
    form that reads back to the same bits.
    """

    def __init__(self, path: Path, columns: tuple[str, ...], stream: IO[str]) -> None:
        self.path, self.columns, self._stream = path, columns, stream
        self._head = _line((*columns, CHECK))

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
        if "step" not in columns or len({*columns, CHECK}) <= len(columns):
            raise ResultsError(
                f"{path}: the columns of a history must be different names, one of them 'step' and none {CHECK!r}; got {list(columns)}"
            )
        path = claim(path, overwrite=overwrite, what="the history")
        try:
            stream = path.open("w", encoding="utf-8", newline="")
        except OSError as error:
            raise ResultsError(f"{path}: cannot write the history ({error.strerror}); choose a path that can be written") from error
        made = cls(path, columns, stream)
        made._write(made._head)
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
        line = _line([_text(value) for value in row])
        self._write(f"{line},{_check(self._head, line)}")

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

    def _write(self, line: str) -> None:
        try:
            if self._stream.closed:
                self._stream = self.path.open("a", encoding="utf-8", newline="")
            self._stream.write(line + "\n")
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
        head, *lines = whole.split("\n")[:-1]
        rows = [_row(path, head, line, len(columns), number) for number, line in enumerate(lines, start=2)]
    except (OSError, UnicodeDecodeError) as error:
        raise _damaged(path, str(error)) from error
    return {name: _array([row[k] for row in rows]) for k, name in enumerate(columns)}


def _line(texts: Sequence[str]) -> str:
    """One line of the file, without its end."""
    stream = io.StringIO()
    csv.writer(stream, lineterminator="").writerow(texts)
    return stream.getvalue()


def _check(head: str, line: str) -> str:
    return f"{zlib.crc32(line.encode(), zlib.crc32(head.encode())):08x}"


def _row(path: Path, head: str, line: str, width: int, number: int) -> list[str]:
    """The entries of a whole line that fits its checksum."""
    body, _, check = line.rpartition(",")
    if check != _check(head, body):
        raise _damaged(path, f"line {number} does not fit its checksum")
    row: list[str] = next(csv.reader([body]))
    if len(row) != width:
        raise _damaged(path, f"line {number} has {len(row)} entries for {width} columns")
    return row


def _damaged(path: Path, reason: str) -> ResultsError:
    return ResultsError(f"{path} is damaged: {reason}; copy it again from where it was written, or run the scene again")


def _header(path: Path) -> tuple[str, ...]:
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            first = stream.readline()
    except FileNotFoundError:
        raise ResultsError(f"{path}: no such history; it is written beside the result file and must stay there") from None
    except (OSError, UnicodeDecodeError) as error:
        raise ResultsError(f"{path} is not a history: {error}") from error
    columns = tuple(next(csv.reader([first]), []))
    if not first.endswith("\n") or "step" not in columns or columns[-1] != CHECK:
        raise ResultsError(
            f"{path} is not a history: its first line must name the columns, one of them 'step' and the last {CHECK!r}; "
            f"found {first[:60]!r}"
        )
    return columns[:-1]


def _truncate(path: Path, column: int, step: int | None) -> None:
    """Cut the file after the last whole row up to `step`; rows before it are not touched."""
    columns = _header(path)
    with path.open("rb+") as file:
        head = file.readline().decode().rstrip("\n")
        end = file.tell()
        for number, line in enumerate(iter(file.readline, b""), start=2):
            if not line.endswith(b"\n"):
                break
            row = _row(path, head, line[:-1].decode(errors="replace"), len(columns), number)
            if step is not None and int(row[column]) > step:
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
