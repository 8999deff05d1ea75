"""Child processes that judge cells: a crash or a time limit is a verdict, and the rest goes on."""

from __future__ import annotations

import os
import pickle
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from typing import IO, Any

from mpmkit.errors import ParameterError
from mpmkit.stability.case import Case, Composition, Verdict
from mpmkit.stability.judge import judge

Cell = tuple[Case, Composition, bool]
"""A case, a composition as the case sees it, and whether the run is a quick one."""
RENEWED = 40
"""Cells after which a process is replaced: of each composition that it compiles some 30 MB are never given back."""


def judged(cells: Sequence[Cell], jobs: int, timeout: float) -> Iterator[tuple[int, Verdict, float]]:
    """Verdicts of all cells in the order in which they are ready, with the cell's number and the seconds it took.

    Parameters
    ----------
    cells : sequence of Cell
        What to judge.
    jobs : int
        Processes; 0 judges in this process, where neither a crash nor a time limit can be survived.
    timeout : float
        Wall time for one cell [s], after which its process is ended.
    """
    if jobs == 0:
        for number, cell in enumerate(cells):
            began = time.perf_counter()
            yield number, judge(*cell), time.perf_counter() - began
        return
    todo: queue.SimpleQueue[int] = queue.SimpleQueue()
    done: queue.SimpleQueue[tuple[int, Verdict, float] | BaseException] = queue.SimpleQueue()
    for number in range(len(cells)):
        todo.put(number)
    children = [_Child() for _ in range(min(jobs, len(cells)))]
    for child in children:
        threading.Thread(target=_work, args=(child, cells, todo, done, timeout), daemon=True).start()
    try:
        for _ in cells:
            one = done.get()
            if isinstance(one, BaseException):
                raise one
            yield one
    finally:
        for child in children:
            child.stop()


def _work(child: _Child, cells: Sequence[Cell], todo: Any, done: Any, timeout: float) -> None:
    while not child.stopped:
        try:
            number = todo.get_nowait()
        except queue.Empty:
            child.stop()
            return
        began = time.perf_counter()
        try:
            verdict = child.judge(cells[number], timeout)
        except BaseException as error:  # noqa: BLE001  raised again where the verdicts are waited for
            done.put(error)
            return
        done.put((number, verdict, time.perf_counter() - began))


class _Child:
    """A process that judges one cell after the other; a new one is started after it has ended."""

    def __init__(self) -> None:
        self.process: subprocess.Popen[bytes] | None = None
        self.stderr: IO[bytes] | None = None
        self.stopped = False
        self.cells = 0

    def judge(self, cell: Cell, timeout: float) -> Verdict:
        from mpmkit.stability.cases import cases
        from mpmkit.stability.worker import receive, send

        case, composition, quick = cell
        name = case.name if cases().get(case.name) is case else None
        process = self._alive()
        assert process.stdin is not None
        assert process.stdout is not None
        late = threading.Event()

        def end() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(timeout, end)
        timer.start()
        try:
            send(process.stdin, (name or case, composition, quick))  # type: ignore[arg-type]
            found: Verdict = receive(process.stdout)  # type: ignore[arg-type]
            self.cells += 1
            if self.cells % RENEWED == 0:
                self._end()
            return found
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise ParameterError(
                f"the case {case.name!r} under {composition.label} cannot be sent to a child process: {error}. To fix: define its "
                "functions in a module, or run with jobs=0"
            ) from error
        except (EOFError, BrokenPipeError):
            status = process.wait()
            words = self._last_words()
            self._forget()
        finally:
            timer.cancel()
        if late.is_set():
            return Verdict("fails", reason=f"the run took longer than {timeout:g} s and was ended")
        how = f"was killed by {_signal(-status)}" if status < 0 else f"ended with status {status}"
        return Verdict("fails", reason=f"the process of the run {how}{words}")

    def _alive(self) -> subprocess.Popen[bytes]:
        from mpmkit.stability.worker import send

        if self.process is None:
            self.stderr = tempfile.TemporaryFile()  # noqa: SIM115  lives as long as the process
            # one thread each: there is a process for every core
            environment = {"MPMKIT_THREADS": "1"} | dict(os.environ)
            self.process = subprocess.Popen(
                [sys.executable, "-m", "mpmkit.stability.worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self.stderr,
                env=environment,
                start_new_session=True,  # Ctrl-C is for the parent, which ends its children
            )
            send(self.process.stdin, sys.path)  # type: ignore[arg-type]
        return self.process

    def _last_words(self) -> str:
        """The last line that the process wrote to standard error."""
        if self.stderr is None:
            return ""
        self.stderr.seek(0)
        lines = self.stderr.read().decode(errors="replace").strip().splitlines()
        return f": {lines[-1].strip()}" if lines else ""

    def _forget(self) -> None:
        process, self.process = self.process, None
        for stream in (process.stdin, process.stdout) if process is not None else ():
            if stream is not None:
                try:
                    stream.close()
                except OSError:
                    continue  # what was still to be sent has no reader
        if self.stderr is not None:
            self.stderr.close()
            self.stderr = None

    def stop(self) -> None:
        """End the process; there will be no other."""
        self.stopped = True
        self._end()

    def _end(self) -> None:
        process = self.process
        if process is not None:
            process.kill()
            process.wait()
            self._forget()


def _signal(number: int) -> str:
    try:
        return f"signal {number} ({signal.Signals(number).name})"
    except ValueError:
        return f"signal {number}"
