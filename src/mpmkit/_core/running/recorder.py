"""One record of a run at work: frames at their times, history rows, checkpoints."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.running import checkpoint, leaving, paths
from mpmkit._core.running.frames import joined, numbered
from mpmkit._core.running.history import HistoryFile
from mpmkit._core.running.ledger import COLUMNS
from mpmkit._core.running.store import BodyStore, components_of
from mpmkit._core.running.unpacking import LARGE_FRAME, unpack, unpack_pieces
from mpmkit._core.running.vtkhdf import ParticleFile, Pieces
from mpmkit.errors import FieldContractError, ResultsError, did_you_mean
from mpmkit.record import Record

if TYPE_CHECKING:
    from mpmkit._core.running.loop import Run

CHECKPOINT_SECONDS = 1.0  # least wall time between two checkpoints ...
CHECKPOINT_COST = 0.02  # ... whose writing takes no longer than this; longer ones are as much rarer, so that they take 2 % at most
STATE_SECONDS = 60.0  # wall time after which there is a checkpoint also between two frames
SCALARS = ("kinetic", "stored", "dissipated", "external_work", "energy", "balance")


class Recorder:
    """Writes what a `Record` asks for."""

    def __init__(self, record: Record, run: Run, *, resumed: int | None = None) -> None:
        self.record, self.run = record, run
        self.path = paths.checkpoint_path(record.path)
        stores = run._stores
        for name in record.fields:
            for s in stores:
                if name not in s.available():
                    raise FieldContractError(
                        f"Record({record.path!r}): body {s.name!r} has no field {name!r}{did_you_mean(name, s.available())}; "
                        f"it has {', '.join(s.available())}"
                    )
        self.names = tuple(f for f in record.fields if f != "x")
        self.last_checkpoint = self.cost = 0.0
        self.saved_step = -1
        self.on_disk: tuple[float, int] | None = None  # time and step of the last checkpoint that is written
        self.row_step = -1
        self.left: HistoryFile | None = None  # made when the first particle is taken out
        self.times: list[float] = []
        history = paths.history_path(record.path)
        checkpoint.remove_stale(self.path)
        if resumed is None:
            widths = {f: components_of(f, stores[0]) for f in self.names}
            static = fixed(stores, with_size="size" not in widths)
            self.file = ParticleFile.create(record.path, widths, static, SCALARS, run.meta(), record.compress, record.overwrite)
            del static  # as much as half a frame, and written
            self.history = HistoryFile.create(history, COLUMNS, overwrite=record.overwrite)
            if paths.left_path(record.path).exists():
                paths.claim(paths.left_path(record.path), overwrite=record.overwrite, what="the list of particles that left")
            self._row(run.ledger.last)
            self._frame(run.ledger.last)
            if record.checkpoint:
                self.checkpoint(always=True)
        else:
            self.file = ParticleFile.reopen(record.path)
            if self.file.n_frames < resumed:
                raise ResultsError(
                    f"{record.path}: has {self.file.n_frames} frames, the checkpoint was written after {resumed}; they do not "
                    "belong together"
                )
            self.file.truncate(resumed)
            self.times = self.file.times.tolist()
            self.history = HistoryFile.reopen(history, run.engine.step_number)
            self.history.close()  # the first row opens it again
            if paths.left_path(record.path).exists():
                self.left = HistoryFile.reopen(paths.left_path(record.path), run.engine.step_number)

    @staticmethod
    def claim(record: Record) -> None:
        """Refuse, before anything is compiled, a path that may not be written."""
        beside = (paths.history_path(record.path), paths.checkpoint_path(record.path), paths.left_path(record.path))
        for path, what in ((Path(record.path), "results"), *((p, "the files of a run") for p in beside)):
            paths.claim(path, overwrite=record.overwrite, what=what, remove=False)  # an old file goes when the new one is made, not before

    @classmethod
    def resume(cls, record: Record, run: Run, frames: int) -> Recorder:
        """Go on with existing files, cut back to what the checkpoint knew."""
        return cls(record, run, resumed=frames)

    # --- times --------------------------------------------------------------------------------------------------
    def next_time(self, t: float) -> float:
        """Next time of a frame after t; infinite if only start and end are kept."""
        if self.record.every is None:
            return math.inf
        k = math.floor(t / self.record.every * (1.0 + 1e-12) + 1e-9) + 1
        return k * self.record.every

    def due(self, t: float, until: float) -> bool:
        """Whether a frame belongs to this time."""
        if t >= until:
            return True
        if self.record.every is None:
            return False
        k = round(t / self.record.every)
        return abs(t - k * self.record.every) <= 1e-9 * self.record.every

    def after_step(self, step: int, row: dict[str, float], due: bool) -> None:
        if int(row["step"]) == step and step != self.row_step:
            self._row(row)
        if due:
            self._frame(row)
            self.checkpoint()
        elif time.perf_counter() - self.last_checkpoint > STATE_SECONDS:
            self.checkpoint()

    def _row(self, row: dict[str, float]) -> None:
        self.history.append(row)
        self.row_step = int(row["step"])

    def _frame(self, row: dict[str, float]) -> None:
        engine, writer = self.run.engine, self.run.writer
        with writer.holding_up():
            writer.wait((self, "frame"))  # first, so that there are never two frames in memory
            stores = self.run._stores
            fields = _Fields(stores, self.names, self.file.dtype)
            if any(s.kept is not None for s in stores):
                fields.changed = fixed(stores, with_size="size" not in self.names)
            numbers = {s: row[s] for s in SCALARS}
            # copies are written while the run goes on; of large ones some rows at a time are written now, without a copy of all
            large = fields.nbytes >= LARGE_FRAME
            data: Mapping[str, Any] = fields if large else dict(fields)
            append = partial(self.file.append, engine.t, engine.step_number, None if large else fields["x"], data, numbers)
            if large:
                append()
            else:
                writer.submit((self, "frame"), append)
            self.times.append(engine.t)

    def write_left(self, rows: list[dict[str, float]]) -> None:
        """List particles that were taken out."""
        if self.left is None:
            path, overwrite = paths.left_path(self.record.path), self.record.overwrite
            self.left = HistoryFile.create(path, leaving.COLUMNS, overwrite=overwrite)
            rows = self.run.left
        for row in rows:
            self.left.append(row)

    def go_back(self, step: int) -> None:
        """Drop the rows after a step that is gone back to; frames are never later."""
        for table in (self.history, self.left):
            if table is not None:
                table.truncate(step)
        self.row_step = min(self.row_step, step)
        self.saved_step = min(self.saved_step, step)

    def close(self) -> None:
        """Close the tables; a further run opens them again."""
        for table in (self.history, self.left):
            if table is not None:
                table.close()

    def forget_lost(self) -> None:
        """After a failed write: only frames that are in the file count, and nothing half-written is left."""
        del self.times[self.file.n_frames :]
        checkpoint.remove_stale(self.path)

    def frames_until(self, t: float) -> int:
        """Frames written up to this time: what a resumed run keeps."""
        return sum(one <= t for one in self.times)

    # --- checkpoints --------------------------------------------------------------------------------------------
    def checkpoint(self, always: bool = False) -> Path:
        """Write the state, unless the last checkpoint is too young (`always`: unless it is this very state)."""
        path, writer = self.path, self.run.writer
        began, engine = time.perf_counter(), self.run.engine
        if (not self.record.checkpoint and not always) or engine.step_number == self.saved_step:
            return path
        if always or began - self.last_checkpoint >= CHECKPOINT_SECONDS * max(1.0, self.cost / CHECKPOINT_COST):
            with writer.holding_up():
                writer.wait((self, "checkpoint"))
                waited = time.perf_counter()
                arrays, copies = self.run.saved_copies()
                temporary = checkpoint.begin(path, engine.state() | arrays, self._attributes() | {"copies": copies})
                spent = time.perf_counter() - waited
                writer.submit((self, "checkpoint"), partial(self._seal, path, temporary, (engine.t, engine.step_number), spent))
            self.last_checkpoint, self.saved_step = began, engine.step_number
        return path

    def _seal(self, path: Path, temporary: Path, at: tuple[float, int], spent: float) -> None:
        began = time.perf_counter()
        checkpoint.seal(path, temporary)
        self.on_disk, self.cost = at, spent + time.perf_counter() - began

    def _attributes(self) -> dict[str, Any]:
        run, engine = self.run, self.run.engine
        scene, reason = run.sim.scene_text()
        return run.identity() | {
            "t": engine.t,
            "step": engine.step_number,
            "facts": run.facts(),
            "repeats": run.repeats.facts(),
            "left": [row for row in run.left if row["step"] <= engine.step_number],
            "rows": [[row[c] for c in COLUMNS] for row in run.rows if row["step"] <= engine.step_number],
            "frames": [r.frames_until(engine.t) for r in run.recorders] if run.recorders else [1] * len(run.sim.records),
            "scene": scene,
            "scene_error": reason,
        }

    def files(self) -> list[Path]:
        """What this record leaves on disk."""
        found = [Path(self.record.path), paths.history_path(self.record.path), paths.left_path(self.record.path), self.path]
        return [p for p in found if p.exists()]


class _Fields(Pieces):
    """Fields of all bodies, each unpacked when it is looked up."""

    def __init__(self, stores: list[BodyStore], names: tuple[str, ...], dtype: Any) -> None:
        self.stores, self.names, self.dtype = stores, names, dtype
        self.n = sum(s.n for s in stores)
        self.changed: dict[str, Any] = {}  # fixed arrays that are not what they were

    def __getitem__(self, name: str) -> Any:
        if name in self.changed:
            return self.changed[name]
        if name != "x" and name not in self.names:
            raise KeyError(name)
        return unpack(self.stores, name, self.dtype)

    def pieces(self, name: str) -> Iterator[Any]:
        """The rows of a field, some at a time."""
        return unpack_pieces(self.stores, name, self.dtype)

    def __contains__(self, name: object) -> bool:
        return name == "x" or name in self.names or name in self.changed

    def __iter__(self) -> Iterator[str]:
        return iter((*self.names, *self.changed))

    def __len__(self) -> int:
        return len(self.names) + len(self.changed)

    @property
    def nbytes(self) -> int:
        """Of all together, with the positions."""
        width = 3 + sum(components_of(name, self.stores[0]) for name in self.names)
        return self.n * int(self.dtype.itemsize) * width


def fixed(stores: Any, with_size: bool) -> dict[str, Any]:
    """Arrays of a frame that change only when particles are taken out: body, id, and the size that pictures are drawn with."""
    return numbered(stores) | ({"size": joined([_sizes(s) for s in stores])} if with_size else {})


def _sizes(store: BodyStore) -> Any:
    """Half edges of a body's particles at the start, float32[n, 3]; equal ones take no memory."""
    size = store.points.size if store.kept is None else store.points.size[store.kept]
    equal = len(size) > 0 and not size.strides[0]
    three = np.zeros((1 if equal else len(size), 3), np.float32)
    three[:, : size.shape[1]] = size[:1] if equal else size
    return np.broadcast_to(three, (len(size), 3))
