"""Arrays and names in the form that VTK reads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mpmkit._core.running.vtkhdf_tables import TOPOLOGIES
from mpmkit.errors import ResultsError


def plain(values: Any, dtype: str) -> np.ndarray:
    """Types that VTK reads: no bool, integers of 32 bits where they fit, floats as asked."""
    array: np.ndarray = np.asarray(values)
    if array.dtype == bool:
        return array.astype(np.uint8)
    if array.dtype.kind in "iu":
        small = array.size == 0 or (array.min() >= -(2**31) and array.max() < 2**31)
        return array.astype(np.int32 if small else np.int64, copy=False)
    return array.astype(dtype, copy=False)


def columns(path: Path, name: str, array: Any, ncomp: int, dtype: np.dtype) -> np.ndarray:
    """Rows of `ncomp` components; vectors of a 1D or 2D run get zeros for the missing directions."""
    array = np.asarray(array)
    rows = array.reshape(len(array), -1) if array.size else np.zeros((len(array), ncomp))
    if ncomp == 3 and rows.shape[1] < 3:
        rows = np.pad(rows, ((0, 0), (0, 3 - rows.shape[1])))
    if rows.shape[1] != ncomp:
        raise ResultsError(f"{path}: {name!r} has {rows.shape[1]} components, this file was made for {ncomp}")
    return np.ascontiguousarray(rows if ncomp > 1 else rows[:, 0], dtype=dtype)


def check_names(path: Any, names: list[str]) -> None:
    for name in names:
        if not name or "/" in name or "." in name:
            raise ResultsError(f"{path}: {name!r} cannot be the name of an array in a VTKHDF file; leave out '/' and '.'")
        if names.count(name) > 1 or name in ("x", "step", *TOPOLOGIES):
            raise ResultsError(f"{path}: the name {name!r} is used twice in this file; rename one")
