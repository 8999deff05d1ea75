"""Memory of a process: the peak of one run, and a limit on it."""

from __future__ import annotations

import contextlib
import ctypes
import gc
from typing import Any

from mpmkit._core.running.memory import text

__all__ = ["Memory", "text"]


class Memory:
    """Peak of the resident memory from `start` on, and a limit from there to `lift`.

    Parameters
    ----------
    budget : int, optional
        Largest resident memory [B]. What is still free of it when stepping begins is set as a limit on the address space, so that
        a run that grows beyond ends by itself.
    """

    def __init__(self, budget: int | None) -> None:
        self.budget = budget
        self._before: Any = None

    def start(self) -> None:
        """Begin to watch the peak, and set the limit.

        Raises
        ------
        MemoryError
            If composing alone has taken more.
        """
        gc.collect()
        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).malloc_trim(0)  # what earlier runs have freed is not this one's
        with contextlib.suppress(OSError), open("/proc/self/clear_refs", "w") as file:
            file.write("5")  # the peak starts again from the present size, without what the compiler took: proc(5)
        if self.budget is None:
            return
        now, size = _status("VmRSS"), _status("VmSize")
        if now is None or size is None:
            return
        if now > self.budget:
            raise MemoryError
        import resource

        self._before = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (size + self.budget - now, self._before[1]))

    def lift(self) -> None:
        """Take the limit away."""
        if self._before is not None:
            import resource

            resource.setrlimit(resource.RLIMIT_AS, self._before)
            self._before = None

    def peak(self) -> int | None:
        """Largest resident memory since `start` [B]; of the process where the system cannot tell."""
        found = _status("VmHWM")
        if found is not None:
            return found
        try:
            import resource
            import sys
        except ImportError:
            return None
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _status(key: str) -> int | None:
    try:
        with open("/proc/self/status") as file:
            for line in file:
                if line.startswith(f"{key}:"):
                    return int(line.split()[1]) * 1024
    except OSError:
        pass
    return None
