"""Where results come from: a file, or the memory of the run itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from mpmkit._core.reading.frame import History
from mpmkit._core.reading.vtkhdf import Reader
from mpmkit._core.running.history import read_history
from mpmkit._core.running.leaving import COLUMNS as LEFT
from mpmkit._core.running.paths import history_path, left_path
from mpmkit.fields import PARTICLE_FIELDS


class Source(Protocol):
    """What `Results` needs to know."""

    where: str
    meta: Mapping[str, Any]
    scene: str | None
    times: np.ndarray
    steps: np.ndarray

    def names(self, frame: int) -> Sequence[str]:
        """Fields of a frame."""

    def array(self, frame: int, name: str) -> np.ndarray:
        """One array of a frame."""

    def history(self) -> History:
        """The rows so far."""

    def left(self) -> History:
        """Particles that were taken out of the domain."""


class FileSource:
    """A result file and the history beside it."""

    def __init__(self, path: Any) -> None:
        self._reader = Reader(path)
        self.where = str(path)
        self.meta: Mapping[str, Any] = self._reader.meta
        self.scene = self._reader.scene
        self.refresh()

    def refresh(self) -> None:
        """Look again for frames that were written since."""
        self._index = self._reader.index()
        self.times, self.steps = self._index.times, self._index.steps

    def names(self, frame: int) -> Sequence[str]:
        """Fields of a frame: all frames have the same."""
        return self._reader.names

    def array(self, frame: int, name: str) -> np.ndarray:
        """One array of a frame; vectors with as many columns as the run has dimensions."""
        stored = self._reader.array(frame, name, self._index)
        dim = self.meta.get("dim", 3)
        return stored[:, :dim] if stored.ndim == 2 and stored.shape[1] == 3 and dim < 3 and self._is_vector(name) else stored

    def _is_vector(self, name: str) -> bool:
        shapes = self.meta.get("shapes", {})
        return bool(shapes.get(name, PARTICLE_FIELDS[name].shape if name in PARTICLE_FIELDS else "vector") == "vector")

    def history(self) -> History:
        """The rows so far."""
        return History(read_history(history_path(self._reader.path)))

    def left(self) -> History:
        """Particles that were taken out of the domain; none if there is no list."""
        path = left_path(self._reader.path)
        return History(read_history(path)) if path.exists() else table([])


class MemorySource:
    """What a run without a record hands over."""

    where = "this run in memory"

    def __init__(
        self,
        frames: Sequence[tuple[float, int, Mapping[str, np.ndarray]]],
        history: Mapping[str, Any],
        meta: Mapping[str, Any],
        scene: str | None,
        left: Sequence[Mapping[str, float]] = (),
    ) -> None:
        self._frames = [data for _, _, data in frames]
        self._history = History({name: np.asarray(column) for name, column in history.items()})
        self._left = left
        self.meta, self.scene = meta, scene
        self.times = np.array([time for time, _, _ in frames], dtype=float)
        self.steps = np.array([step for _, step, _ in frames], dtype=np.int64)

    def names(self, frame: int) -> Sequence[str]:
        """Fields of a frame."""
        return tuple(self._frames[frame])

    def array(self, frame: int, name: str) -> np.ndarray:
        """One array of a frame."""
        return np.asarray(self._frames[frame][name])

    def history(self) -> History:
        """The rows."""
        return self._history

    def left(self) -> History:
        """Particles that were taken out of the domain."""
        return table(self._left)


def table(rows: Sequence[Mapping[str, float]]) -> History:
    """Rows of the list of particles that were taken out, as columns."""
    whole = ("step", "id", "body")
    return History({name: np.array([row[name] for row in rows], dtype=np.int64 if name in whole else float) for name in LEFT})
