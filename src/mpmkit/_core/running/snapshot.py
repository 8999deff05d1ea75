"""Copies of the state: the last good one of a run that may fail, and that from before a trial step.

A copy in memory is kept only while the state is small; a run of millions of particles shall not need twice their memory.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from mpmkit._core.running.engine import Engine

IN_MEMORY = 64 << 20
"""Largest state in bytes of which a copy is kept in memory."""
SPILLED = 1 << 20
"""Smallest array in bytes that is worth a temporary file."""
SECONDS = 0.5
"""Least wall time between two copies."""
SHARE = 0.01
"""Largest share of the wall time that copies may take."""


def small(engine: Engine) -> bool:
    """Whether a copy of the state is kept in memory."""
    return size(engine) <= IN_MEMORY


def size(engine: Engine) -> int:
    """Bytes of the state."""
    return sum(int(array.nbytes) for array in engine.state().values())


class Snapshot:
    """The last good state, in memory that is allocated once; of a large state nothing is kept."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self._copy: dict[str, Any] = {}
        self._at = (0.0, 0)
        self._next = -1.0

    @property
    def kept(self) -> bool:
        """Whether there is a copy."""
        return bool(self._copy)

    def take(self) -> None:
        """Copy the state, if it is small and the last copy is old enough."""
        began = time.perf_counter()
        if began < self._next:
            return
        if not small(self.engine):
            self._copy = {}
            self._next = began + SECONDS
            return
        self._copy = {name: _copied(array, self._copy.get(name)) for name, array in self.engine.state().items()}
        self._at = (self.engine.t, self.engine.step_number)
        now = time.perf_counter()
        self._next = now + max(SECONDS, (now - began) / SHARE)

    def restore(self) -> None:
        """Put the engine back to the copied state."""
        self.engine.restore(self._copy, *self._at)
        self.engine.flags[:] = False


@contextmanager
def unchanged(engine: Engine) -> Iterator[None]:
    """Whatever is done inside, the state afterwards is that of before, to the bit; a large one lies in a temporary file meanwhile."""
    t, step = engine.t, engine.step_number
    state = engine.state()
    with ExitStack() as files:
        on_disk = {} if small(engine) else _spill(state, files)
        arrays = {name: array.copy() for name, array in state.items() if name not in on_disk}
        kinds = {name: (state[name].shape, state[name].dtype) for name in on_disk}
        del state
        yield
        state = engine.state()
        for name, file in on_disk.items():
            there = state.get(name)
            fits = there is not None and (there.shape, there.dtype) == kinds[name]
            arrays[name] = there if fits else np.empty(*kinds[name])
            _read_into(file, arrays[name])
        engine.restore(arrays, t, step)


def _copied(array: Any, old: Any) -> Any:
    """A copy, in the memory of an old one if that fits."""
    if old is None or (old.shape, old.dtype) != (array.shape, array.dtype):
        return array.copy()
    old[...] = array
    return old


def _bytes_of(array: Any) -> Any:
    return array.reshape(-1).view(np.uint8)


def _read_into(file: Any, array: Any) -> None:
    file.seek(0)
    rest = _bytes_of(array)
    while rest.size:
        rest = rest[file.readinto(rest) :]


def _spill(state: dict[str, Any], files: ExitStack) -> dict[str, Any]:
    """Write the larger arrays into temporary files that nobody else sees; none if there is no room for them on the disk."""
    spilled: dict[str, Any] = {}
    try:
        for name, array in state.items():
            if array.nbytes < SPILLED:
                continue
            spilled[name] = files.enter_context(tempfile.TemporaryFile(buffering=0))  # noqa: SIM115  closed with the others
            rest = _bytes_of(array)
            while rest.size:
                rest = rest[spilled[name].write(rest) :]
    except OSError:
        return {}  # then the copy is in memory after all, which takes more of it and gives the same result
    return spilled
