"""A child process for runs: it can be stopped, has a memory of its own, and dies with its parent."""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
import time
from typing import Any

COMPILE_SECONDS = 900.0
"""Longest wait for composing and compiling, which count in no budget."""

_all: set[Child] = set()
_mine = threading.local()


class Child:
    """One worker process, started when the first job comes and again after it was stopped."""

    def __init__(self) -> None:
        self.process: subprocess.Popen[bytes] | None = None
        self._lines: queue.Queue[bytes] = queue.Queue()
        self._errors: Any = None

    def start(self) -> None:
        """Start the process."""
        _all.add(self)
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115  lives as long as the process
        self.process = subprocess.Popen(
            [sys.executable, "-m", "mpmkit.studies.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            start_new_session=True,  # Ctrl-C is for the parent, which then stops its children
        )
        self._lines = queue.Queue()
        threading.Thread(target=_read, args=(self.process.stdout, self._lines), daemon=True).start()

    def ask(self, job: dict[str, Any], budget: float | None = None) -> dict[str, Any]:
        """Do a job, within so many seconds of wall time from the moment when it is compiled."""
        if self.process is None or self.process.poll() is not None:
            self.start()
        assert self.process is not None and self.process.stdin is not None
        try:
            self.process.stdin.write(json.dumps({**job, "sys_path": sys.path}).encode() + b"\n")
            self.process.stdin.flush()
        except OSError:
            return self._died()
        end, stepping = time.monotonic() + COMPILE_SECONDS, False
        while True:
            try:
                line = self._lines.get(timeout=max(0.0, end - time.monotonic()))
            except queue.Empty:
                self.stop()
                told = f"stopped after {budget:g} s of wall time, the budget of a run" if stepping else "composing took too long"
                return {"status": "over budget" if stepping else "failed", "reason": told}
            if not line:
                return self._died()
            answer = json.loads(line)
            if "answer" in answer:
                return dict(answer["answer"])
            end, stepping = time.monotonic() + (budget if budget is not None else threading.TIMEOUT_MAX / 4), True

    def _died(self) -> dict[str, Any]:
        """What is known of a process that ended by itself, such as for lack of memory."""
        if self.process is None:
            return {"status": "failed", "reason": "the process of the run was stopped"}
        code = self.process.wait()
        self._errors.seek(0)
        last = self._errors.read().decode(errors="replace").strip().splitlines()[-1:] or ["it said nothing"]
        self.stop()
        how = f"signal {-code}" if code < 0 else f"exit status {code}"
        lost = "; if memory ran out, give a memory budget" if code == -9 else ""
        return {"status": "failed", "reason": f"the process of the run ended with {how}: {last[0]}{lost}"}

    def stop(self) -> None:
        """End the process."""
        _all.discard(self)
        process, self.process = self.process, None
        if process is None:
            return
        if process.poll() is None:
            process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()
        if self._errors is not None:
            self._errors.close()


def _read(stream: Any, lines: queue.Queue[bytes]) -> None:
    try:
        for line in stream:
            lines.put(line)
    except (OSError, ValueError):
        pass
    lines.put(b"")


def run(job: dict[str, Any]) -> dict[str, Any]:
    """Do a job in the child of this thread; what executors are given, here or on other machines.

    Returns
    -------
    dict
        As `stepping.execute`; "fields" has the arrays that are compared with those of other runs.
    """
    import numpy as np

    child: Child | None = getattr(_mine, "child", None)
    if child is None:
        child = _mine.child = Child()
    handle, path = tempfile.mkstemp(suffix=".npz")
    os.close(handle)
    try:
        answer = child.ask({**job, "arrays": path}, job.get("time_budget"))
        if os.path.getsize(path):
            with np.load(path) as found:
                answer["fields"] = dict(found)
    finally:
        os.unlink(path)
    return answer


@atexit.register
def stop_all() -> None:
    """End all children of this process."""
    for child in list(_all):
        child.stop()
