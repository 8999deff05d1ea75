"""The bookkeeping tables of a temporal VTKHDF file of points: parts, vertex cells and steps."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

TOPOLOGIES = ("Vertices", "Lines", "Polygons", "Strips")
"""Kinds of cell of a PolyData; all four groups are required."""
_STEP_TABLES = {"Values": ((), "f8"), "PartOffsets": ((), "i8"), "NumberOfParts": ((), "i8"), "PointOffsets": ((), "i8")}
_CELL_TABLES = {"CellOffsets": ((4,), "i8"), "ConnectivityIdOffsets": ((4,), "i8")}


def dataset(group: Any, name: str, columns: tuple[int, ...], dtype: Any, chunk: int, **filters: Any) -> Any:
    """An empty data set that grows by rows."""
    return group.create_dataset(name, (0, *columns), maxshape=(None, *columns), dtype=dtype, chunks=(chunk, *columns), **filters)


AT_ONCE = 1 << 15
"""Rows of large arrays that are written at a time."""


def append_rows(array: Any, rows: Any) -> int:
    """Append rows to a data set; return the number of the first."""
    first = array.shape[0]
    array.resize(first + len(rows), axis=0)
    array[first:] = rows
    return int(first)


def create_tables(file: Any, static: Mapping[str, np.ndarray], scalars: Iterable[str]) -> None:
    """Make the group ``/VTKHDF`` with everything but the particle arrays, whose chunks depend on the first frame."""
    import h5py

    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array([2, 0], "i8")
    root.attrs.create("Type", np.bytes_("PolyData"), dtype=h5py.string_dtype("ascii", 8))
    dataset(root, "NumberOfPoints", (), "i8", 128)
    for kind in TOPOLOGIES:
        group, chunk = root.create_group(kind), 16384 if kind == "Vertices" else 128
        dataset(group, "NumberOfCells", (), "i8", 128)
        dataset(group, "NumberOfConnectivityIds", (), "i8", 128)
        dataset(group, "Connectivity", (), "i4", chunk)
        dataset(group, "Offsets", (), "i4", chunk)
    steps, point_data, field_data = (root.create_group(name) for name in ("Steps", "PointData", "FieldData"))
    steps.attrs["NSteps"] = np.int64(0)
    for name, (columns, dtype) in {**_STEP_TABLES, **_CELL_TABLES}.items():
        dataset(steps, name, columns, dtype, 128)
    point_offsets, field_offsets = steps.create_group("PointDataOffsets"), steps.create_group("FieldDataOffsets")
    for name, array in static.items():
        dataset(point_data, name, array.shape[1:], array.dtype, max(1, min(len(array), 65536)))
        dataset(point_offsets, name, (), "i8", 128)
    for name in ("step", *scalars):
        dataset(field_data, name, (), "i8" if name == "step" else "f8", 128)
        dataset(field_offsets, name, (), "i8", 128)


def add_part(root: Any, n: int) -> tuple[int, int]:
    """Describe frames of `n` particles, one vertex each.

    Returns
    -------
    part, first_cell : int
        Number of the part, and cells of all parts before it. The reader adds `part` itself to find the row in
        ``Offsets`` (which has n + 1 rows for n cells), hence these tables may have no gaps.
    """
    part, first_cell = root["NumberOfPoints"].shape[0], root["Vertices/Connectivity"].shape[0]
    for kind in TOPOLOGIES:
        cells = n if kind == "Vertices" else 0
        append_rows(root[kind]["NumberOfCells"], [cells])
        append_rows(root[kind]["NumberOfConnectivityIds"], [cells])
        _append_count(root[kind]["Offsets"], cells + 1)
    _append_count(root["Vertices/Connectivity"], n)
    append_rows(root["NumberOfPoints"], [n])
    return int(part), int(first_cell)


def _append_count(array: Any, n: int) -> None:
    """Append 0 to n - 1, some at a time: all together may take more memory than the positions."""
    for first in range(0, n, AT_ONCE):
        append_rows(array, np.arange(first, min(n, first + AT_ONCE)))


def shrink_tables(root: Any, n_frames: int) -> dict[int, tuple[int, int]]:
    """Cut the tables to `n_frames` whole frames; return particle count -> (part, first cell) of the parts in use."""
    steps = root["Steps"]
    used = steps["PartOffsets"][:n_frames]
    n_parts = int(used.max()) + 1 if n_frames else 0
    counts = [int(n) for n in root["NumberOfPoints"][:n_parts]]
    for name in (*_STEP_TABLES, *_CELL_TABLES):
        steps[name].resize(n_frames, axis=0)
    for group in (steps["PointDataOffsets"], steps["FieldDataOffsets"], root["FieldData"]):
        for array in group.values():
            array.resize(n_frames, axis=0)
    root["NumberOfPoints"].resize(n_parts, axis=0)
    for kind in TOPOLOGIES:
        cells = sum(counts) if kind == "Vertices" else 0
        root[kind]["NumberOfCells"].resize(n_parts, axis=0)
        root[kind]["NumberOfConnectivityIds"].resize(n_parts, axis=0)
        root[kind]["Connectivity"].resize(cells, axis=0)
        root[kind]["Offsets"].resize(cells + n_parts, axis=0)
    firsts = np.concatenate([[0], np.cumsum(counts)]).astype(int)
    return {n: (part, int(firsts[part])) for part, n in enumerate(counts)}
