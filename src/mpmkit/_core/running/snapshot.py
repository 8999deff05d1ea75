"""Copies of the state: the last good one of a run that may fail, and that from before a trial step.

A copy in memory is kept only while the state is small; a run of millions of particles shall not need twice their memory.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

if TYPE_CHECKING:
    from mpmkit._core.running.engine import Engine

IN_MEMORY = 64 << 20
"""Largest state in bytes of which a copy is kept in memory."""
SPILLED = 1 << 20
"""Smallest array in bytes that is worth a temporary file."""
EVERY = 200
"""Steps between two copies; a copy takes a tenth of a step, so they take less than a thousandth of the time."""


def small(engine: Engine) -> bool:
    """Whether a copy of the state is kept in memory."""
    return size(engine) <= IN_MEMORY


def size(engine: Engine) -> int:
    """Bytes of the state."""
    return sum(int(array.nbytes) for array in engine.state().values())


@attrs.define
class Copy:
    """A state with what the run knew then.

    Attributes
    ----------
    arrays : dict of str to array
        As `Engine.state`.
    t, step : float, int
        Time [s] and number of the step.
    facts : dict
        Plain data of the run.
    """

    arrays: dict[str, Any]
    t: float
    step: int
    facts: dict[str, Any]


class Snapshot:
    """The last good states, two at most, in memory that is allocated once; of a large state nothing is kept.

    Copies are made by the number of the step and never by the clock: where a run goes back to must not depend on the machine.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.copies: list[Copy] = []  # the older one first
        self._spare: list[Copy] = []

    @property
    def kept(self) -> bool:
        """Whether there is a copy."""
        return bool(self.copies)

    def due(self) -> bool:
        """Whether it is time for another copy."""
        return not self.copies or self.engine.step_number >= self.copies[-1].step + EVERY

    def take(self, facts: dict[str, Any], *, alone: bool = False) -> None:
        """Copy the state if it is small; `alone`: forget the older ones, since something is written now that shall not be undone."""
        engine = self.engine
        if self.copies and self.copies[-1].step == engine.step_number:
            self._drop(0, len(self.copies) - 1 if alone else 0)
            return
        self._drop(0, len(self.copies) if alone else len(self.copies) - 1)
        if not small(engine):
            self.copies, self._spare = [], []
            return
        old = self._spare.pop().arrays if self._spare else {}
        arrays = {name: _copied(array, old.get(name)) for name, array in engine.state().items()}
        self.copies.append(Copy(arrays, engine.t, engine.step_number, facts))

    def _drop(self, first: int, last: int) -> None:
        self._spare = (self._spare + self.copies[first:last])[:2]
        del self.copies[first : max(first, last)]

    def restore(self, away: int = 0) -> Copy:
        """Put the engine back to the youngest copy that is `away` steps old, or to the oldest; later copies are forgotten."""
        engine = self.engine
        old = [k for k, copy in enumerate(self.copies) if copy.step + away <= engine.step_number]
        k = old[-1] if old else 0
        self._drop(k + 1, len(self.copies))
        copy = self.copies[k]
        engine.restore(copy.arrays, copy.t, copy.step)
        engine.flags[:] = False
        return copy

    def save(self) -> tuple[dict[str, Any], list[dict[str, Any] | None]]:
        """Arrays and plain data of the copies for a checkpoint; None stands for the state as it is now, which the checkpoint is itself."""
        arrays: dict[str, Any] = {}
        told: list[dict[str, Any] | None] = []
        for k, copy in enumerate(self.copies):
            if copy.step == self.engine.step_number:
                told.append(None)
                continue
            arrays |= {f"copy{k}/{name}": array for name, array in copy.arrays.items()}
            told.append({"t": copy.t, "step": copy.step, "facts": copy.facts})
        return arrays, told

    def load(self, arrays: dict[str, Any], told: list[dict[str, Any] | None], facts: dict[str, Any]) -> None:
        """Take over what `save` has given; `facts` are those of the present state."""
        for k, one in enumerate(told):
            if one is None:
                self.take(facts)
            else:
                mine = {name.split("/", 1)[1]: a for name, a in arrays.items() if name.startswith(f"copy{k}/")}
                self.copies.append(Copy(mine, **one))


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
