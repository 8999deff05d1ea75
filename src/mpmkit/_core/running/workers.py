"""A team of threads that run compiled loops side by side; the loops release Python's lock."""

from __future__ import annotations

import os
import queue
import threading
import weakref
from collections.abc import Callable, Iterator, Sequence
from numbers import Integral
from typing import Any

from mpmkit.errors import CompositionError

Work = Callable[[int, Any], None]
"""Called with the number of the thread and a piece of work."""


def available() -> int:
    """Cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def chosen(threads: int | None, particles: int) -> int:
    """How many threads to use: as asked, else by ``MPMKIT_THREADS``, else one for every 20,000 particles, at most one for each core.

    Raises
    ------
    CompositionError
        If it is no whole number, less than one, or more than there are cores.
    """
    most, source = available(), "threads"
    if threads is not None and not _whole(threads):
        raise CompositionError(f"threads = {threads!r} is not a whole number; allowed: 1 to {most}")
    if threads is None and os.environ.get("MPMKIT_THREADS"):
        text, source = os.environ["MPMKIT_THREADS"], "MPMKIT_THREADS"
        try:
            threads = int(text)
        except ValueError:
            raise CompositionError(f"MPMKIT_THREADS = {text!r} is not a whole number; allowed: 1 to {most}") from None
    if threads is None:
        return max(1, min(most, particles // 20_000))
    if not 1 <= threads <= most:
        why = "; more threads than cores would only wait for each other" if threads > most else ""
        raise CompositionError(
            f"{source} = {threads} is not allowed: 1 to {most}, as this process may use {most} core{'s' if most > 1 else ''}{why}"
        )
    return int(threads)


def _whole(value: Any) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool)


class Team:
    """Threads that wait for work; the calling thread works too, as number 0."""

    def __init__(self, size: int) -> None:
        self.size = size
        self._process = os.getpid()
        self._asked: list[queue.SimpleQueue[Any]] = [queue.SimpleQueue() for _ in range(size - 1)]
        for k, asked in enumerate(self._asked, 1):
            threading.Thread(target=_serve, args=(k, asked), name=f"mpmkit-{k}", daemon=True).start()
        self.close = weakref.finalize(self, _dismiss, self._asked)  # lets the threads end, at the latest with the team itself

    def run(self, work: Work, items: Sequence[Any]) -> None:
        """Do all pieces of work; whoever is free takes the next."""
        if self.size == 1 or len(items) == 1 or os.getpid() != self._process:  # a forked child has no threads but its own
            for item in items:
                work(0, item)
            return
        rest, done = iter(items), queue.SimpleQueue[BaseException | None]()
        helpers = self._asked[: len(items) - 1]
        for asked in helpers:
            asked.put((work, rest, done))
        failed = [_share(0, work, rest)]
        while len(failed) <= len(helpers):
            try:
                failed.append(done.get())
            except KeyboardInterrupt as interrupt:  # not before all have let go of the arrays
                failed[0] = interrupt
        for error in failed:
            if error is not None:
                raise error


def _dismiss(team: list[queue.SimpleQueue[Any]]) -> None:
    for asked in team:
        asked.put(None)


def _share(number: int, work: Work, rest: Iterator[Any]) -> BaseException | None:
    try:
        for item in rest:  # one item at a time, under Python's lock
            work(number, item)
    except BaseException as error:  # noqa: BLE001  raised in the calling thread
        return error
    return None


def _serve(number: int, asked: queue.SimpleQueue[Any]) -> None:
    while (task := asked.get()) is not None:
        work, rest, done = task
        done.put(_share(number, work, rest))
