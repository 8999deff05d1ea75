"""What a person sees while the suite runs: a moving line on a terminal, a line now and then in a file, and what does not hold at once."""

from __future__ import annotations

import sys
import time
from typing import Any, TextIO

from mpmkit._core.running.progress import FILE_SECONDS, _duration
from mpmkit.stability.case import Case, Composition, Verdict


class Progress:
    """Progress of one run of the suite, as a context.

    Parameters
    ----------
    total, taken : int
        Cells, and how many of them were taken from earlier results.
    quiet : bool
        Show nothing.
    stream : text stream, optional
        Where to; standard error if none is given.
    """

    def __init__(self, total: int, taken: int, *, quiet: bool = False, stream: TextIO | None = None) -> None:
        self.total, self.done, self.quiet = total, taken, quiet
        self.stream = sys.stderr if stream is None else stream
        self._taken = taken
        self._live = not quiet and bool(getattr(self.stream, "isatty", lambda: False)())
        self._bar: Any = None
        self._began = time.perf_counter()
        self._next = self._began + FILE_SECONDS
        self._count: dict[str, int] = {}

    def __enter__(self) -> Progress:
        if self._taken:
            self._say(f"{self._taken} of {self.total} cells are known from earlier runs")
        if self._live:
            from rich.console import Console
            from rich.progress import BarColumn, TextColumn
            from rich.progress import Progress as Bar

            columns = (BarColumn(bar_width=20), TextColumn("{task.description}", markup=False))
            self._bar = Bar(*columns, console=Console(file=self.stream), auto_refresh=False)
            self._bar.start()
            self._bar.add_task("starting", total=self.total, completed=self._taken)
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def tell(self, case: Case, composition: Composition, verdict: Verdict, seconds: float) -> None:
        """A cell is finished."""
        if self.quiet:
            return
        self.done += 1
        self._count[verdict.status] = self._count.get(verdict.status, 0) + 1
        if verdict.status in ("bounded", "fails"):
            first = verdict.reason.splitlines()[0] if verdict.reason else ""
            self._say(f"{verdict.status:<8}{case.name} under {composition.label} ({seconds:.1f} s): {first}")
        now = time.perf_counter()
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], completed=self.done, description=self._line(now), refresh=True)
        elif now >= self._next or self.done == self.total:
            self._next = now + FILE_SECONDS
            self._say(self._line(now))

    def _line(self, now: float) -> str:
        measured = self.done - self._taken
        left = (now - self._began) / measured * (self.total - self.done)
        counts = "  ".join(f"{number} {status}" for status, number in sorted(self._count.items()))
        return f"{self.done} of {self.total} cells  {counts}  ETA {_duration(left)}"

    def _say(self, text: str) -> None:
        if self.quiet:
            return
        if self._bar is not None:
            self._bar.console.print(text, markup=False, highlight=False)
        else:
            print(text, file=self.stream, flush=True)
