"""What a person sees of a study: a bar with the time that is left on a terminal, a line for each run elsewhere."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any, Self


class Progress:
    """Progress of one phase of a study.

    Parameters
    ----------
    what : str
        The phase.
    total : float
        Sum of the weights that `advance` is going to be given.
    quiet : bool
        Show nothing.
    """

    def __init__(self, what: str, total: float, quiet: bool) -> None:
        self.what, self.total, self.quiet = what, total, quiet
        self.done = 0.0
        self._live = not quiet and sys.stderr.isatty()
        self._bar: Any = None
        self._began = time.monotonic()

    def __enter__(self) -> Self:
        if self._live and self.total > 0.0:
            from rich.console import Console
            from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            columns = ("{task.description}", BarColumn(), TaskProgressColumn(), TimeElapsedColumn(), "left", TimeRemainingColumn())
            self._bar = Bar(*columns, TextColumn("{task.fields[last]}"), console=Console(stderr=True))
            self._task = self._bar.add_task(self.what, total=self.total, last="")
            self._bar.start()
        return self

    def advance(self, weight: float, last: str) -> None:
        """Tell of something that was done."""
        self.done += weight
        if self._bar is not None:
            self._bar.update(self._task, advance=weight, last=last)
        elif not self.quiet:
            spent = time.monotonic() - self._began
            left = spent * (self.total / self.done - 1.0) if self.done > 0.0 else 0.0
            print(f"{self.what}: {last} ({self.done / self.total:.0%}, about {left:.0f} s left)", file=sys.stderr, flush=True)

    def say(self, text: str) -> None:
        """A remark, which stays."""
        if self._bar is not None:
            self._bar.console.print(text, highlight=False, markup=False)
        elif not self.quiet:
            print(text, file=sys.stderr, flush=True)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        if self._bar is not None:
            self._bar.stop()
