"""Write particles over time into one VTKHDF file (temporal PolyData) that VTK reads while it grows.

Layout, for T frames and P *parts*; a part is one particle count, used again by every frame that has this count::

    /VTKHDF                      @Version = (2, 0), @Type = "PolyData" (fixed-length ASCII: VTK 9.3 refuses anything else)
      NumberOfPoints (P,)        Points (rows, 3)            frame after frame, three columns in every dimension
      Vertices/...               one vertex cell per particle; Lines, Polygons, Strips are required and empty
      PointData/NAME             (rows,) or (rows, ncomp); fixed arrays (body, id) are written again only when they change
      FieldData/NAME (T,)        step and scalars of the run
      Steps                      @NSteps = T: written when the frame is whole, and then its time
        Values, PartOffsets, NumberOfParts, PointOffsets (T,), CellOffsets, ConnectivityIdOffsets (T, 4)
        PointDataOffsets/NAME    of fixed arrays; the others follow PointOffsets
    /mpmkit                      scene text and facts about the run (readers of VTKHDF ignore it)
      sums (T, arrays)           checksums, see `vtkhdf_sums`

The file is written with old HDF5 objects (`libver` "earliest" to "v110") and without locks: newer objects or SWMR would
keep VTK from reading it before the run has ended. Data are flushed before ``NSteps`` grows, so a killed run leaves all
earlier frames readable; ``Values`` grows after it, because VTK (9.3 to 9.7) reads all of ``Values`` into room
for ``NSteps`` numbers and crashes where there are more. Where frames are compressed, each starts on a chunk boundary: a
chunk that is written twice could be lost together with the earlier frame it holds.

References
----------
VTK file formats, "VTKHDF", https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html
"""

from __future__ import annotations

import json
import os
import time as clock
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Self

import numpy as np

from mpmkit._core.running import vtkhdf_sums as sums
from mpmkit._core.running.disk import abandon, close_trimmed, reserve
from mpmkit._core.running.paths import claim
from mpmkit._core.running.vtkhdf_arrays import check_names, columns, plain
from mpmkit._core.running.vtkhdf_check import DAMAGED, FORMAT, check_ours, damaged
from mpmkit._core.running.vtkhdf_tables import AT_ONCE, add_part, append_rows, create_tables, dataset, shrink_tables
from mpmkit.errors import ResultsError

SYNC_SECONDS = 60.0
"""Seconds between two fsync calls; a killed process loses nothing, a power cut at most this much."""
_HDF5 = {"libver": ("earliest", "v110"), "locking": False}


class Pieces(Mapping[str, Any]):
    """Fields of a frame, positions too, that are made when they are asked for and given some rows at a time.

    Attributes
    ----------
    n : int
        Rows of all fields.
    """

    n: int

    @abstractmethod
    def pieces(self, name: str) -> Iterator[Any]:
        """The rows of a field from first to last."""


class ParticleFile:
    """An open result file to which frames are appended. Made by `create` or `reopen`.

    Attributes
    ----------
    path : Path
        The file.
    n_frames : int
        Frames that are whole.
    dtype : numpy.dtype
        Of positions and fields; arrays of this type are written as they are, without a copy.
    """

    def __init__(self, path: Path, file: Any) -> None:
        self.path, self._file = path, file
        self._layout = sums.read_layout(file)
        self.fields: dict[str, int] = self._layout["fields"]
        self.static: tuple[str, ...] = tuple(self._layout["static"])
        self.scalars: tuple[str, ...] = tuple(self._layout["scalars"])
        self._compress: bool = self._layout["compress"]
        self.dtype = np.dtype(self._layout["dtype"])
        self._root, self._steps = file["VTKHDF"], file["VTKHDF/Steps"]
        self.n_frames = min(int(self._steps.attrs["NSteps"]), self._steps["Values"].shape[0])
        self._parts: dict[int, tuple[int, int]] = {}
        self._last_static: dict[str, tuple[int, int, int]] = {}  # first row, number of rows, checksum
        self._synced = clock.monotonic()

    @classmethod
    def create(
        cls,
        path: str | os.PathLike[str],
        fields: Mapping[str, int],
        static: Mapping[str, np.ndarray] | None = None,
        scalars: tuple[str, ...] = (),
        meta: Mapping[str, Any] | None = None,
        compress: bool = False,
        overwrite: bool = False,
        dtype: str = "float32",
    ) -> ParticleFile:
        """Start a result file.

        Parameters
        ----------
        path : path
            Where; an existing file is replaced only if `overwrite` is true.
        fields : mapping of str to int
            Fields of every frame and their numbers of components; positions ``x`` are always there.
        static : mapping of str to array (n,) or (n, ncomp)
            Arrays that rarely change, such as the body number of each particle.
        scalars : tuple of str
            Numbers given with each frame, such as the kinetic energy.
        meta : mapping
            Facts about the run as plain data. Known keys: ``scene`` (text or None), ``bodies`` (names), ``ledger`` (columns),
            ``versions``, ``dim``, ``space``, ``units`` (of fields and ledger columns), ``grid``.
        compress : bool
            gzip the frames.
        dtype : str
            Type of positions and fields in the file.

        Raises
        ------
        ResultsError
            If the file exists, cannot be written, or a name contains "/" or "." (which the format forbids).
        """
        import h5py

        static = {k: plain(v, dtype) for k, v in (static or {}).items()}
        fields = {k: int(n) for k, n in fields.items() if k != "x"}
        check_names(path, [*fields, *static, *scalars])
        path = claim(path, overwrite=overwrite)
        meta = dict(meta or {})
        scene = meta.pop("scene", None)
        try:
            file = h5py.File(path, "w", **_HDF5)
        except OSError as error:
            raise ResultsError(f"{path}: cannot write results ({error}); choose a path that can be written") from error
        layout = {"fields": fields, "static": list(static), "scalars": list(scalars), "compress": compress, "dtype": dtype}
        texts = {
            name: text for name, text in (("layout", json.dumps(layout)), ("meta", json.dumps(meta)), ("scene", scene)) if text is not None
        }
        try:
            return cls._fill(path, file, layout, texts, static)
        except (OSError, RuntimeError, ValueError) as error:
            abandon(file)
            path.unlink(missing_ok=True)  # nothing is in it
            raise ResultsError(f"{path}: cannot write results ({error}); choose a path that can be written") from error

    @classmethod
    def _fill(cls, path: Path, file: Any, layout: dict[str, Any], texts: dict[str, str], static: dict[str, np.ndarray]) -> ParticleFile:
        """Everything that comes before the first frame."""
        # data sets of static arrays begin with a whole chunk
        reserve(file, sum(len(text.encode()) for text in texts.values()) + sum(2 * array.nbytes for array in static.values()))
        ours = file.create_group("mpmkit")
        ours.attrs["format"] = np.int64(FORMAT)
        for name, text in texts.items():
            sums.add_text(ours, name, text)
        dataset(ours, "sums", (len(sums.names(layout)),), "u4", 128)
        create_tables(file, static, layout["scalars"])
        file.flush()
        made = cls(path, file)
        for name, array in static.items():
            made._append_static(name, array)
        return made

    @classmethod
    def reopen(cls, path: str | os.PathLike[str]) -> ParticleFile:
        """Open a result file to append more frames, as `resume` does; what an interrupted write left behind is cut off.

        Raises
        ------
        ResultsError
            If it is missing, damaged, or was not written by mpmkit.
        """
        import h5py

        path = Path(path)
        check_ours(path)
        try:
            file = h5py.File(path, "r+", **_HDF5)
        except OSError as error:
            raise ResultsError(f"{path}: cannot append to these results ({error}); change its permissions or copy it") from error
        try:
            made = cls(path, file)
            sums.check_tables(file, made._layout, made.n_frames)
            made.truncate(made.n_frames)
        except DAMAGED as error:
            abandon(file)
            raise damaged(path, error) from error
        return made

    @property
    def times(self) -> np.ndarray:
        """Times of the frames so far, float64[n_frames] [s]."""
        return np.asarray(self._steps["Values"][: self.n_frames])

    def append(
        self,
        time: float,
        step: int,
        x: np.ndarray | None,
        data: Mapping[str, np.ndarray],
        scalars: Mapping[str, float] | None = None,
    ) -> None:
        """Add one frame; when this returns, readers see it and a killed process keeps it.

        Parameters
        ----------
        time : float
            Simulated time [s].
        step : int
            Number of the step.
        x : array (n, 1 to 3)
            Positions [m]; n may differ from frame to frame. None if `data` are `Pieces`, which have them too.
        data : mapping of str to array (n,), (n, ncomp) or (n, 3, 3)
            Every field named at `create`; vectors of fewer than three columns are filled with zeros. A fixed array
            that changed (particles were lost, or came in another order) is given here too. Each is looked up when it is written and
            not kept.
        scalars : mapping of str to float
            Every scalar named at `create`.

        Raises
        ------
        ResultsError
            If an array is missing or has a wrong shape, or writing fails (a full disk); earlier frames stay readable.
        """
        if self._file is None:
            raise ResultsError(f"{self.path}: this result file is closed; open it again with ParticleFile.reopen")
        if isinstance(data, Pieces):
            n = data.n
        else:  # refused before anything is written
            n, data = len(np.asarray(x)), {**data, "x": np.asarray(x)}
            data |= {k: one for k, ncomp in (("x", 3), *self.fields.items()) for one in self._pieces_of(k, ncomp, data, n)}
        rows = {"Points": partial(self._pieces_of, "x", 3, data, n)}
        rows |= {f"PointData/{k}": partial(self._pieces_of, k, ncomp, data, n) for k, ncomp in self.fields.items()}
        fixed = {k: array for k in self.static if (array := self._fixed(k, data, n)) is not None}
        unknown = sorted(set(data) - {"x", *self.fields, *self.static})
        if unknown:
            raise ResultsError(
                f"{self.path}: this file was not made for {', '.join(unknown)}; it holds {', '.join(('x', *self.fields, *self.static))}"
            )
        if set(self.scalars) != set(scalars or {}):
            raise ResultsError(f"{self.path}: a frame needs the scalars {list(self.scalars)}, got {list(scalars or {})}")
        numbers = {"step": step, **{k: float((scalars or {})[k]) for k in self.scalars}}
        try:
            self._write(float(time), n, rows, fixed, numbers)
        except (OSError, RuntimeError, ValueError) as error:
            file, self._file = self._file, None
            abandon(file)
            raise ResultsError(
                f"{self.path}: cannot write frame {self.n_frames} at t = {time:g} s ({error}); "
                f"the {self.n_frames} frames before it are kept"
            ) from error

    def _write(
        self,
        time: float,
        n: int,
        rows: Mapping[str, Callable[[], Iterable[np.ndarray]]],
        fixed: dict[str, np.ndarray],
        numbers: Mapping[str, float],
    ) -> None:
        root, steps = self._root, self._steps
        if "Points" not in root:
            self._create_arrays(n)
        self._reserve(n, fixed)
        if n not in self._parts:
            self._parts[n] = add_part(root, n)
        part, first_cell = self._parts[n]
        written = [self._append_frame(root[name], n, make()) for name, make in rows.items()]
        offsets, of_arrays = {first for first, _ in written}, [one for _, one in written]
        assert len(offsets) == 1, "all arrays of a frame begin at the same row"
        for name in self.static:
            if name in fixed:
                self._append_static(name, fixed[name])
            append_rows(steps["PointDataOffsets"][name], [self._last_static[name][0]])
        for name, value in numbers.items():
            append_rows(steps["FieldDataOffsets"][name], [append_rows(root["FieldData"][name], [value])])
        cells = [[first_cell, 0, 0, 0]]
        first = offsets.pop()
        table: dict[str, Any] = {"PartOffsets": [part], "NumberOfParts": [1], "PointOffsets": [first]}
        for name, row in {**table, "CellOffsets": cells, "ConnectivityIdOffsets": cells}.items():
            append_rows(steps[name], row)
        static = [self._last_static[name] for name in self.static]
        of_tables = sums.of_frame(
            [time, *(numbers[name] for name in self.scalars)], [numbers["step"], first, n, *(start for start, _, _ in static)]
        )
        append_rows(self._file["mpmkit/sums"], [[of_tables, *of_arrays, *(one for _, _, one in static)]])
        self._file.flush()  # the frame is in the file ...
        steps.attrs.modify("NSteps", np.int64(self.n_frames + 1))
        self._file.flush()  # ... before the counter shows it ...
        append_rows(steps["Values"], [time])
        self._file.flush()  # ... and never are there more times than the counter says
        self.n_frames += 1
        if clock.monotonic() - self._synced > SYNC_SECONDS:
            self._sync()

    def truncate(self, n_frames: int) -> None:
        """Forget all frames from number `n_frames` on: those that a resumed run is going to write again."""
        if not 0 <= n_frames <= self.n_frames:
            raise ResultsError(f"{self.path}: cannot go back to {n_frames} frames, the file has {self.n_frames}")
        self._steps["Values"].resize(n_frames, axis=0)
        self._file.flush()  # first, since there may never be more times than the counter says
        self._steps.attrs.modify("NSteps", np.int64(n_frames))
        self._file.flush()
        self.n_frames = n_frames
        self._parts = shrink_tables(self._root, n_frames)
        kept = self._file["mpmkit/sums"]
        kept.resize(n_frames, axis=0)
        arrays = [self._root["Points"], *(self._root["PointData"][k] for k in self.fields)] if "Points" in self._root else []
        end = 0
        if n_frames:
            counts = self._root["NumberOfPoints"][:]
            end = int(self._steps["PointOffsets"][n_frames - 1] + counts[self._steps["PartOffsets"][n_frames - 1]])
        for array in arrays:
            array.resize(end, axis=0)
        self._last_static = {}
        for name in self.static:
            stored, column = self._root["PointData"][name], sums.names(self._layout).index(name)
            first = int(self._steps["PointDataOffsets"][name][n_frames - 1]) if n_frames else 0
            # with the last frame's particle count, except before the first frame: then all there is
            count = int(counts[self._steps["PartOffsets"][n_frames - 1]]) if n_frames else stored.shape[0]
            stored.resize(first + count, axis=0)
            self._last_static[name] = (first, count, int(kept[n_frames - 1, column]) if n_frames else sums.of_array(stored[:]))
        self._file.flush()

    def close(self) -> None:
        """Flush, sync and close; does nothing the second time."""
        if self._file is not None:
            self._sync()
            file, self._file = self._file, None
            close_trimmed(file)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *args: object) -> None:
        self.close()

    def _create_arrays(self, n: int) -> None:
        # with constant n, compressed frames fill whole chunks and leave no gaps
        chunk = max(1, -(-n // max(1, -(-n // 65536)))) if self._compress else min(max(n, 1024), 65536)
        # gzip with shuffle is all that VTK decodes
        filters = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if self._compress else {}
        dataset(self._root, "Points", (3,), self.dtype, chunk, **filters)
        for name, ncomp in self.fields.items():
            dataset(self._root["PointData"], name, (ncomp,) if ncomp > 1 else (), self.dtype, chunk, **filters)

    def _reserve(self, n: int, fixed: dict[str, np.ndarray]) -> None:
        chunk = self._root["Points"].chunks[0]
        # data sets grow by whole chunks; a new part has its table of vertices
        room = (n + chunk) * self.dtype.itemsize * (3 + sum(self.fields.values()))
        room += sum(a.nbytes + chunk * a.itemsize * (a.shape[1] if a.ndim > 1 else 1) for a in fixed.values())
        reserve(self._file, room + (0 if n in self._parts else 8 * n + (1 << 18)))

    def _append_static(self, name: str, array: np.ndarray) -> None:
        """Write a static array and remember where it is; in pieces, since equal rows of a large one take no memory before."""
        first, of_rows = int(self._root["PointData"][name].shape[0]), 0
        for k in range(0, len(array), AT_ONCE):
            append_rows(self._root["PointData"][name], array[k : k + AT_ONCE])
            of_rows = sums.of_array(array[k : k + AT_ONCE], of_rows)
        self._last_static[name] = (first, len(array), of_rows)

    def _append_frame(self, array: Any, n: int, pieces: Iterable[np.ndarray]) -> tuple[int, int]:
        """Write n rows; where they begin, and their checksum."""
        chunk = array.chunks[0] if self._compress else 1
        first = -(-array.shape[0] // chunk) * chunk  # the gap is never read
        array.resize(first + n, axis=0)
        row, of_rows = first, 0
        for piece in pieces:
            array[row : row + len(piece)] = piece
            row, of_rows = row + len(piece), sums.of_array(piece, of_rows)
        return first, of_rows

    def _pieces_of(self, name: str, ncomp: int, data: Mapping[str, np.ndarray], n: int) -> Iterator[np.ndarray]:
        """The rows of a field as the file holds them."""
        if name not in data:
            raise ResultsError(f"{self.path}: the frame lacks the field {name!r}, which this file was made for")
        count = 0
        for piece in data.pieces(name) if isinstance(data, Pieces) else [data[name]]:
            rows = columns(self.path, name, piece, ncomp, self.dtype)
            count += len(rows)
            yield rows
        if count != n:
            raise ResultsError(f"{self.path}: field {name!r} has {count} rows for {n} particles")

    def _fixed(self, name: str, data: Mapping[str, np.ndarray], n: int) -> np.ndarray | None:
        """A fixed array that must be written with this frame; None if the last one in the file still holds."""
        stored = self._root["PointData"][name]
        first, rows, _ = self._last_static[name]
        shape, array = (rows, *stored.shape[1:]), None
        if name in data:
            array = np.asarray(data[name]).astype(stored.dtype)
            shape = array.shape
        if shape != (n, *stored.shape[1:]):
            raise ResultsError(
                f"{self.path}: {name!r} has shape {shape} for {n} particles; give it with the frame when the particles change"
            )
        return None if array is None or (rows == n and np.array_equal(stored[first : first + rows], array)) else array

    def _sync(self) -> None:
        self._file.flush()
        handle = os.open(self.path, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
        self._synced = clock.monotonic()
