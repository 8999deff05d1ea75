"""Checksums of what a result file holds: a flipped bit must not become a number in somebody's plot.

HDF5 could add checksums of its own only to data in filtered chunks, which an interrupted frame may not share with the one before. So
each frame has a row of CRC-32 in ``/mpmkit/sums``: of its time, step, place and scalars, of its positions, and of each of its arrays.
Texts have theirs as an attribute.
"""

from __future__ import annotations

import json
import zlib
from typing import Any

import numpy as np

FRAME = "frame"
"""Column of what the tables say about a frame; the others have the names of the arrays."""


def names(layout: dict[str, Any]) -> list[str]:
    """The columns of ``/mpmkit/sums``."""
    return [FRAME, "x", *layout["fields"], *layout["static"]]


def of_array(array: np.ndarray, before: int = 0) -> int:
    """Of the bytes of an array as stored, and of what came before them."""
    return zlib.crc32(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data, before)


def of_frame(floats: Any, whole: Any) -> int:
    """Of what the tables say about one frame: (time, scalars ...) and (step, first row, rows, first rows of static arrays ...)."""
    return zlib.crc32(np.asarray(floats, np.float64).tobytes() + np.asarray(whole, np.int64).tobytes())


def check_tables(file: Any, layout: dict[str, Any], n_frames: int) -> None:
    """Compare what the tables say about all frames with their sums.

    Raises
    ------
    OSError
        If a table is too short, or a frame does not fit.
    """
    root, steps = file["VTKHDF"], file["VTKHDF/Steps"]
    counts, offsets, numbers = root["NumberOfPoints"][:], steps["PointDataOffsets"], root["FieldData"]
    rows = slice(0, n_frames)
    floats = [steps["Values"][rows], *(numbers[name][rows] for name in layout["scalars"])]
    whole = [numbers["step"][rows], steps["PointOffsets"][rows], counts[steps["PartOffsets"][rows]] if n_frames else counts[:0]]
    whole += [offsets[name][rows] for name in layout["static"]]
    stored = file["mpmkit/sums"][rows, 0]
    if any(len(c) != n_frames for c in (*floats, *whole, stored)):
        raise OSError("the tables of the steps are shorter than their counter")
    for k, wanted in enumerate(stored):
        if of_frame([c[k] for c in floats], [c[k] for c in whole]) != wanted:
            raise OSError(f"what it says about frame {k} does not fit its checksum")


def add_text(group: Any, name: str, text: str) -> None:
    """Keep a text and its sum; data sets, since an attribute holds no more than 64 kB."""
    import h5py

    raw = text.encode() or b"\0"
    group.create_dataset(name, data=raw, dtype=h5py.string_dtype("utf-8", len(raw))).attrs["sum"] = np.uint32(zlib.crc32(raw))


def read_text(group: Any, name: str) -> str:
    """A text that fits its sum.

    Raises
    ------
    OSError
        If it does not.
    """
    stored = group[name]
    raw = bytes(stored[()])
    if zlib.crc32(raw) != int(stored.attrs["sum"]) and zlib.crc32(raw.ljust(stored.dtype.itemsize, b"\0")) != int(stored.attrs["sum"]):
        raise OSError(f"its {name} does not fit its checksum")
    return raw.decode().rstrip("\0")


def read_layout(file: Any) -> dict[str, Any]:
    """Fields, static arrays and scalars of a file."""
    layout: dict[str, Any] = json.loads(read_text(file["mpmkit"], "layout"))
    return layout
