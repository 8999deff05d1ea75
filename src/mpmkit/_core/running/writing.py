"""Writing beside the run: one thread for all files of a run, which steps on meanwhile.

At most one job of a kind is under way, so what they hold in memory is bounded: one frame of each record. They are done in
the order they were given. After a job has failed no further one is begun, so that no checkpoint knows of a frame that is
not in the file; its error is raised in the run, at the next step.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any


class Writer:
    """The thread and its jobs.

    Attributes
    ----------
    seconds : float
        Wall time for which writing has held up the run: preparing what is written, and waiting for earlier jobs.
    error : BaseException or None
        Of the first job that failed.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self.error: BaseException | None = None
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="mpmkit-writer")
        self._pending: dict[Any, Future[None]] = {}

    def submit(self, kind: Any, job: Callable[[], None]) -> None:
        """Have a job done; wait first if the last one of this kind is not.

        Raises
        ------
        Exception
            That of an earlier job; this one is then not begun.
        """
        self.wait(kind)
        self._pending[kind] = self._thread.submit(self._do, job)

    def check(self) -> None:
        """Raise the error of a job that has failed."""
        if self.error is not None:
            raise self.error

    def finish(self) -> None:
        """Wait until everything is written; raise the error of a job that has failed."""
        for kind in list(self._pending):
            self.wait(kind)
        self.check()

    def settle(self) -> BaseException | None:
        """Wait until no job is left; return the error of the one that failed."""
        for kind in list(self._pending):
            self._pending.pop(kind).result()
        return self.error

    def wait(self, kind: Any) -> None:
        """Wait until the last job of a kind is done; raise the error of a job that has failed."""
        job = self._pending.get(kind)
        if job is not None:
            job.result()  # kept until it is done: an interrupt while waiting must not lose it
            del self._pending[kind]
        self.check()

    @contextmanager
    def holding_up(self) -> Iterator[None]:
        """Count the time spent inside as time in which the run did not step."""
        began = time.perf_counter()
        try:
            yield
        finally:
            self.seconds += time.perf_counter() - began

    def _do(self, job: Callable[[], None]) -> None:
        if self.error is not None:
            return
        try:
            job()
        except BaseException as error:  # noqa: BLE001  any error stops the run; it is raised there
            self.error = error
