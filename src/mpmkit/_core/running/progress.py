"""What a person sees of a run: a moving line on a terminal, whole lines now and then in a file, a summary at the end."""

from __future__ import annotations

import math
import sys
import time as clock
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

TERMINAL_SECONDS = 0.2
"""Wall time between two updates of the line on a terminal."""
FILE_SECONDS = 10.0
"""Wall time between two lines where the output is no terminal."""


class Reporter:
    """Progress of one run. Between two shown lines, `update` costs one clock call.

    Parameters
    ----------
    until : float
        End of the run [s, simulated].
    n_particles : int
        Particles at the start; set the attribute again when it changes.
    quiet : bool
        Show nothing at all.
    stream : text stream, optional
        Where to; standard error if none is given.
    start_time, start_step : float, int
        Where a resumed run begins.
    """

    def __init__(
        self,
        until: float,
        n_particles: int,
        *,
        quiet: bool = False,
        stream: TextIO | None = None,
        start_time: float = 0.0,
        start_step: int = 0,
    ) -> None:
        self.until, self.n_particles, self.quiet = until, n_particles, quiet
        self.stream = sys.stderr if stream is None else stream
        self.compile_seconds = 0.0
        self._live = not quiet and bool(getattr(self.stream, "isatty", lambda: False)())
        self._bar: Any = None
        self._start_time, self._start_step = start_time, start_step
        self._step, self._time, self._dt, self._balance = start_step, start_time, 0.0, float("nan")
        self._particle_steps = 0
        self._writing = 0.0
        self._began = clock.perf_counter()
        self._interval = TERMINAL_SECONDS if self._live else FILE_SECONDS
        self._next = self._began + self._interval
        self._mark = (self._began, start_time, 0)  # when, where and after how many particle-steps the last line was shown
        self._rate = self._speed = 0.0

    @contextmanager
    def compiling(self, what: str = "the step") -> Iterator[None]:
        """Say that code is being compiled, and keep the time out of the speed."""
        self._say(f"compiling {what} (first time for this composition) ...")
        began = clock.perf_counter()
        try:
            yield
        finally:
            took = clock.perf_counter() - began
            self.compile_seconds += took
            self._mark = (clock.perf_counter(), self._time, self._particle_steps)
            self._next = self._mark[0] + self._interval
            self._say(f"compiled {what} in {took:.1f} s")

    def update(self, step: int, time: float, dt: float, balance: float = float("nan"), writing: float = 0.0) -> None:
        """Tell of a finished step.

        Parameters
        ----------
        step : int
            Its number.
        time, dt : float
            Simulated time after it and its length [s].
        balance : float
            Energy that appeared or vanished so far, relative to the largest energy of the run [1]; nan if not known.
        writing : float
            Wall time so far for which writing results has held up the run [s].
        """
        self._particle_steps += (step - self._step) * self.n_particles
        self._step, self._time, self._dt, self._balance, self._writing = step, time, dt, balance, writing
        now = clock.perf_counter()
        if now >= self._next and not self.quiet:
            self._show(now)

    def go_back(self, step: int, time: float) -> None:
        """Steps are done again from here; what was done in vain counts as work, not as progress."""
        self._step, self._time = step, time
        self._start_step = min(self._start_step, step)
        before = self._mark
        self._mark = (before[0], min(before[1], time), before[2])

    def finish(
        self,
        phases: Mapping[str, float] | None = None,
        *,
        balance: float | None = None,
        momentum_error: float | None = None,
        files: Sequence[str | Path] = (),
        writing: float | None = None,
        notes: Mapping[str, str] | None = None,
        status: str = "finished",
    ) -> None:
        """Close the line and print the summary.

        Parameters
        ----------
        phases : mapping of str to float
            Seconds spent in each phase of the step.
        balance : float, optional
            Energy balance [1]; the one last given to `update` if none is given.
        momentum_error : float, optional
            Momentum that appeared or vanished, relative to the momentum exchanged [1].
        files : sequence of path
            What the run leaves.
        writing : float, optional
            Wall time for which writing results has held up the run [s]; that last given to `update` if none is given.
        notes : mapping of str to str
            What else happened, such as steps that were repeated.
        status : str
            "finished", or how it ended otherwise, such as "interrupted".
        """
        now = clock.perf_counter()
        if self._bar is not None:
            self._show(now)
            self._bar.stop()
            self._bar = None
        if self.quiet:
            return
        from mpmkit._core.running.summary import summary_table

        wall = now - self._began
        stepping = max(wall - self.compile_seconds, 1e-9)
        facts = {
            "status": f"{status} at t = {self._time:.6g} s",
            "wall time": _duration(wall),
            "compiling": _duration(self.compile_seconds) if self.compile_seconds else "none (from the cache)",
            "steps": f"{self._step - self._start_step:,}",
            "speed": f"{si(self._particle_steps / stepping)}particle-steps/s",
        }
        writing = self._writing if writing is None else writing
        if writing:
            facts["writing"] = f"{writing:.3g} s ({writing / stepping:.1%})"
        balance = self._balance if balance is None else balance
        if not math.isnan(balance):
            facts["energy balance"] = f"{balance:+.1e}"
        if momentum_error is not None:
            facts["momentum error"] = f"{momentum_error:.1e}"
        facts |= notes or {}
        console = self._console()
        mark = "▇" if console.encoding.startswith("utf") else "#"
        console.print(summary_table(facts, phases or {}, mark))
        for file in files:
            self._say(f" {file}")  # not through rich, which would cut or wrap a long path

    def stop(self) -> None:
        """Close the moving line without a summary, so that an error message stands on its own line."""
        if self._bar is not None:
            self._bar.stop()
            self._bar = None

    def _show(self, now: float) -> None:
        """Measure the speed since the last line and print a new one."""
        before, time_before, done_before = self._mark
        elapsed = max(now - before, 1e-9)
        rate, speed = (self._time - time_before) / elapsed, (self._particle_steps - done_before) / elapsed
        # smoothed, since a single short interval may hold an output or none
        keep = 0.7 if self._rate else 0.0
        self._rate, self._speed = keep * self._rate + (1 - keep) * rate, keep * self._speed + (1 - keep) * speed
        self._mark, self._next = (now, self._time, self._particle_steps), now + self._interval
        if self._live:
            self._draw()
        else:
            self._say("  ".join(self._parts()))

    def _parts(self) -> list[str]:
        eta = _duration((self.until - self._time) / self._rate) if self._rate > 0 else "unknown"
        parts = [
            f"step {self._step}", f"t {self._time:.4g} s ({self._fraction:.1%})", f"dt {self._dt:.2e} s",
            f"{si(self._speed)}particle-steps/s", f"ETA {eta}",
        ]  # fmt: skip
        if self._writing:
            stepping = max(self._mark[0] - self._began - self.compile_seconds, 1e-9)
            parts.append(f"writing {self._writing / stepping:.1%}")
        if not math.isnan(self._balance):
            parts.append(f"energy balance {self._balance:+.1e}")
        return parts

    @property
    def _fraction(self) -> float:
        return min(1.0, self._time / self.until) if self.until > 0 else 1.0

    def _draw(self) -> None:
        from rich.progress import BarColumn, Progress, TextColumn

        if self._bar is None:
            columns = (BarColumn(bar_width=20), TextColumn("{task.description}", markup=False))
            # without a thread of its own: the run's thread draws, at its own pace
            self._bar = Progress(*columns, console=self._console(), auto_refresh=False, transient=False)
            self._bar.start()
            self._bar.add_task("", total=1.0)
        parts = self._parts()
        wide = len("  ".join(parts)) + 21 <= self._bar.console.width
        text = "  ".join(parts) if wide else "  ".join(parts[:3]) + "\n" + "  ".join(parts[3:])
        self._bar.update(self._bar.task_ids[0], completed=self._fraction, description=text, refresh=True)

    def _say(self, text: str) -> None:
        if self.quiet:
            return
        if self._bar is not None:
            self._bar.console.print(text, markup=False, highlight=False)
        else:
            print(text, file=self.stream, flush=True)

    def _console(self) -> Any:
        from rich.console import Console

        # a file has no width: give it one that no path is cut at
        return Console(file=self.stream, width=None if self._live else 120)


def si(value: float) -> str:
    """A number of three digits with its prefix and a space, such as "3.41 M"."""
    for limit, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if abs(value) >= limit:
            return f"{value / limit:.3g} {prefix}"
    return f"{value:.3g} "


def _duration(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"
