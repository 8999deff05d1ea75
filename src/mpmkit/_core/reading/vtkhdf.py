"""Read particles over time from our VTKHDF files, also while they grow.

The file is opened anew for each look, so a reader never holds what the writer changes; a look that
falls into the middle of a flush is repeated.
"""

from __future__ import annotations

import json
import os
import time as clock
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import attrs
import numpy as np

from mpmkit._core.running import vtkhdf_sums as sums
from mpmkit._core.running.vtkhdf_check import DAMAGED, check_ours, damaged
from mpmkit.errors import ResultsError

T = TypeVar("T")
_TRIES = 5


@attrs.frozen
class Index:
    """Where each frame lies.

    Attributes
    ----------
    times : float64[T]
        Simulated times [s].
    steps : int64[T]
        Step numbers.
    first, count : int64[T]
        First row in ``Points`` and number of particles.
    """

    times: np.ndarray
    steps: np.ndarray
    first: np.ndarray
    count: np.ndarray


class Reader:
    """A result file that is read frame by frame.

    Raises
    ------
    ResultsError
        If the file is missing, truncated, or not one of ours; the message says which.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        check_ours(self.path)
        self.layout: dict[str, Any] = self._look(sums.read_layout)
        self.meta: dict[str, Any] = self._look(lambda f: json.loads(sums.read_text(f["mpmkit"], "meta")))
        self.scene: str | None = self._look(lambda f: sums.read_text(f["mpmkit"], "scene") if "scene" in f["mpmkit"] else None)
        self.names: tuple[str, ...] = ("x", *self.layout["fields"], *self.layout["static"])

    def index(self) -> Index:
        """The frames that are whole now."""

        def read(file: Any) -> Index:
            root, steps = file["VTKHDF"], file["VTKHDF/Steps"]
            # the counter grows first, then the times: between the two the last frame is not yet ours to show
            n = min(int(steps.attrs["NSteps"]), steps["Values"].shape[0])
            sums.check_tables(file, self.layout, n)
            counts = root["NumberOfPoints"][:]
            columns = [
                steps["Values"][:n],
                root["FieldData/step"][:n],
                steps["PointOffsets"][:n],
                counts[steps["PartOffsets"][:n]] if n else counts[:0],
            ]
            if any(len(c) != n for c in columns):
                raise OSError("the tables of the steps are shorter than their counter")
            return Index(*columns)

        return self._look(read)

    def array(self, frame: int, name: str, index: Index) -> np.ndarray:
        """One array of one frame, (n,) or (n, ncomp), as stored."""

        def read(file: Any) -> np.ndarray:
            root = file["VTKHDF"]
            stored = root["Points"] if name == "x" else root["PointData"][name]
            fixed = root["Steps/PointDataOffsets"]
            first = int(fixed[name][frame]) if name in fixed else int(index.first[frame])
            rows: np.ndarray = stored[first : first + int(index.count[frame])]
            if len(rows) != index.count[frame]:
                raise OSError(f"{name} of frame {frame} is shorter than it should be")
            if sums.of_array(rows) != file["mpmkit/sums"][frame, sums.names(self.layout).index(name)]:
                raise OSError(f"{name} of frame {frame} does not fit its checksum")
            return rows

        return self._look(read)

    def scalars(self, frame: int) -> dict[str, float]:
        """The numbers given with one frame."""
        return self._look(lambda f: {k: f["VTKHDF/FieldData"][k][frame].item() for k in self.layout["scalars"]})

    def _look(self, read: Callable[[Any], T]) -> T:
        import h5py

        for attempt in range(_TRIES):
            try:
                with h5py.File(self.path, "r", locking=False) as file:
                    return read(file)
            except DAMAGED as error:
                reason = error
                clock.sleep(0.02 * attempt)
        if not self.path.exists():
            raise ResultsError(f"{self.path} is gone: it was moved or deleted while it was being read")
        raise damaged(self.path, reason)
