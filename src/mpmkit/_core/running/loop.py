"""The run loop: steps, landing on the times of frames, history, checkpoints, and what is left when a run fails."""

from __future__ import annotations

import signal
import threading
import warnings
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

import mpmkit
from mpmkit._core.composing import contract, jit
from mpmkit._core.composing.composition import collect
from mpmkit._core.composing.plan import make_plan
from mpmkit._core.composing.sizes import half_sizes
from mpmkit._core.running import checkpoint, frames, guards, leaving, memory, snapshot, timestep, workers
from mpmkit._core.running.alarm import CREATED_WARN, EnergyAlarm
from mpmkit._core.running.engine import Engine
from mpmkit._core.running.ledger import COLUMNS, Ledger
from mpmkit._core.running.progress import Reporter
from mpmkit._core.running.recorder import Recorder
from mpmkit._core.running.repeats import AWAY, Repeats
from mpmkit._core.running.store import BodyStore
from mpmkit._core.running.writing import Writer
from mpmkit.errors import CompositionError, MpmkitError, ResultsError, StabilityError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping
    from os import PathLike

    from mpmkit.simulation import Simulation

COLLAPSE = 1e-6  # smallest time step relative to the first


class Run:
    """A composed simulation and where it stands."""

    def __init__(self, sim: Simulation) -> None:
        self.sim = sim
        composition = collect(sim)
        self.warnings = contract.check(composition)
        self.plan = make_plan(composition)
        memory.check(self.plan)
        points = self._sample(composition)
        contract.check_state(composition, points)
        dtype = self.plan.dtype
        stores = [
            BodyStore(composition.group_of(k), sim.body_name(b), p, b.material.rho, dtype)
            for k, (b, p) in enumerate(zip(sim.bodies, points, strict=True))
        ]
        for store, b in zip(stores, sim.bodies, strict=True):
            guards.masses(store, b.material.rho)
        if self.plan.composition.shape is not None:
            self._check_sizes(stores)
        self._stores = stores
        self._engine: Engine | None = None
        self._threads: int | None = None
        self.rows: list[dict[str, float]] = []
        self.frames: list[tuple[float, int, Mapping[str, Any]]] = []
        self.recorders: list[Recorder] = []
        self.writer = Writer()
        self._snapshot: snapshot.Snapshot | None = None  # since the first step
        self._whole = True  # no step has been begun and not come to a good end
        self.first_dt = 0.0
        self.limit: timestep.Limit | None = None
        self.alarm, self.repeats = EnergyAlarm(), Repeats()
        self.left: list[leaving.Row] = []  # particles that were taken out
        self._stop = self._warm = False

    @property
    def n_particles(self) -> int:
        """Particles that are there."""
        return sum(s.n for s in self._stores)

    # --- composing ----------------------------------------------------------------------------------------------
    def _sample(self, c: Any) -> list[Any]:
        sim = self.sim
        if c.stored_operator:
            return [c.discretization.mesh(sim.grid, b) for b in sim.bodies]
        points = [b.sample(sim.grid) for b in sim.bodies]
        from mpmkit.bodies import overlapping

        for a in range(len(points)):
            for b in range(a):
                if overlapping(points[a], points[b]).size:
                    names = f"{sim.body_name(sim.bodies[b])!r} and {sim.body_name(sim.bodies[a])!r}"
                    self.warnings.append(
                        f"bodies {names} overlap at the start: their particles stand closer than their sizes allow; mass is counted "
                        "twice there"
                    )
        return points

    def _check_sizes(self, stores: list[BodyStore]) -> None:
        """Particles larger than a cell leave gaps; larger than the shape function reaches they are refused."""
        shape, grid = self.plan.composition.shape, self.sim.grid
        assert shape is not None
        for store in stores:
            size, F = store.points.size, getattr(store.points, "F", None)
            stretched = shape.particle_size == "current" and F is not None
            largest = (half_sizes(size, F) if stretched else size).max(axis=0)
            half = float((largest / np.asarray(grid.spacing)).max())
            if shape.particle_size != "none" and half > shape.max_half * (1 + 1e-9):
                raise CompositionError(
                    f"body {store.name!r}: particles are {2 * half:.3g} cells wide, {type(shape).__name__} allows {2 * shape.max_half:g}; "
                    "use more particles per cell or a coarser grid"
                )
            if half > 0.5 * (1 + 1e-9):
                self.warnings.append(
                    f"body {store.name!r}: particles are {2 * half:.3g} cells wide, so cells between them stay empty and the body "
                    "may fall apart"
                )

    @property
    def engine(self) -> Engine:
        """The engine; made, compiled and started at first use."""
        if self._engine is None:
            self._engine = Engine(self.plan, self._stores, self._threads)
            self._engine.start()
            self.ledger = Ledger(self._engine)
            self.rows.append(self.ledger.row(0.0))
            self.alarm.start(self._engine)
        return self._engine

    def use(self, threads: int | None) -> None:
        """Step with this many threads from now on; refused before anything is compiled (see `workers.chosen`)."""
        workers.chosen(threads, self.n_particles)
        self._threads = threads
        if self._engine is not None:
            self._engine.use(threads)

    # --- running ------------------------------------------------------------------------------------------------
    def to(self, until: float, *, quiet: bool = False, threads: int | None = None) -> None:
        """Step to `until`; see `Simulation.run`."""
        self.use(threads)
        fresh = not self.recorders and bool(self.sim.records)
        if fresh:
            for record in self.sim.records:
                Recorder.claim(record)  # refuse existing results before a long compilation
        reporter = Reporter(
            until,
            self.n_particles,
            quiet=quiet,
            start_time=self._engine.t if self._engine else 0.0,
            start_step=self._engine.step_number if self._engine else 0,
        )
        self.writer.seconds = 0.0
        if not self._warm:
            with reporter.compiling():
                self.warm_up()
        engine = self.engine
        self._forget_later()
        try:
            guards.check(engine)
            if fresh:
                self.recorders = [Recorder(r, self) for r in self.sim.records]
            if not self.sim.records and not self.frames:
                self.frames.append((engine.t, engine.step_number, frames.frame(self._stores)))
            self.step_to(until, reporter)
        except BaseException as error:
            reporter.stop()
            self._leave(error)
            raise
        finally:
            for r in self.recorders:
                r.close()
        if not self.sim.records:
            self.frames.append((engine.t, engine.step_number, frames.frame(self._stores)))
        momentum = self.momentum_error()
        files = [path for r in self.recorders for path in r.files()]
        balance, writing, notes = self.ledger.last["balance"], self.writer.seconds, self._notes()
        reporter.finish(engine.clocks, balance=balance, momentum_error=momentum, files=files, writing=writing, notes=notes)

    def _notes(self) -> dict[str, str]:
        """What the summary must not keep quiet about."""
        notes = {"steps repeated": self.repeats.summary()} if self.repeats.done else {}
        if self.left:
            mass = self.ledger.last["left_mass"]
            notes["left the domain"] = f"{len(self.left)} particles, {mass:.4g} kg, the first at t = {self.left[0]['t']:.6g} s"
        return notes

    def warm_up(self) -> None:
        """Compile everything before the clock of the run starts: one very short step, then the state as it was."""
        engine = self.engine
        self._warm = True
        if not jit.enabled():
            return  # plain Python has nothing to compile
        short = 1e-6 * min((limit.dt for limit in timestep.limits(engine)), default=1e-3)  # not zero: kernels may divide by it
        with snapshot.unchanged(engine):
            engine.step(short)
            engine.ledger()
            if engine.contact is not None:
                engine.contact.warm_up()
            for store in engine.stores:
                for name in store.layout.derived:  # frames ask for them
                    store.tiles_of(name, 0, 0)
        engine.clocks.clear()
        engine.flags[:] = False

    def step_to(self, until: float, reporter: Reporter) -> None:
        """Step to `until` and nothing else: no compilation, no frame in memory, no summary; what studies measure."""
        engine = self.engine
        every = min((r.record.history for r in self.recorders), default=10)
        if engine.t >= until:
            return
        copies = self._snapshot = self._snapshot or snapshot.Snapshot(engine)
        if not copies.kept:
            copies.take(self.facts())
        with self._interruptible():
            while engine.t < until:
                try:
                    dt, due = self._step(until, every)
                except StabilityError as error:
                    self._go_back(error, reporter)
                    continue
                written = due or engine.t >= until
                if written or (copies.due() and self._calm(copies)):
                    copies.take(self.facts(), alone=bool(written))  # before the checkpoint, which says so
                for r in self.recorders:
                    r.after_step(engine.step_number, self.ledger.last, r in due)
                reporter.n_particles = self.n_particles
                reporter.update(engine.step_number, engine.t, dt, self.ledger.last["balance"], self.writer.seconds)
                if self._stop:
                    raise KeyboardInterrupt
        for r in self.recorders:
            if r.record.checkpoint:
                r.checkpoint(always=True)
        self.writer.finish()

    def _calm(self, copies: snapshot.Snapshot) -> bool:
        """Whether the state is worth a copy: not while energy is being made; but none gets twice as old as it should."""
        if not copies.kept:
            return True
        last = copies.copies[-1]
        risen = self.ledger.last["balance"] - last.facts["ledger"]["last"]["balance"]
        return risen < CREATED_WARN or self.engine.step_number >= last.step + 2 * snapshot.EVERY

    def _step(self, until: float, every: int) -> tuple[float, list[Recorder]]:
        """One step, what it leaves to be looked at, and the records that want a frame of it."""
        engine = self.engine
        limit = timestep.next_step(engine)
        self.first_dt = self.first_dt or limit.dt
        if not limit.dt > COLLAPSE * self.first_dt:
            raise StabilityError(
                f"the time step collapsed to {limit.dt:.3g} s (first one {self.first_dt:.3g} s) at step {engine.step_number}, t = "
                f"{engine.t:.6g} s; limited by {limit.rule}. To fix: look at the body named there, lower cfl, or refine the grid"
            )
        self.limit = self.repeats.slowed(limit, engine.t)
        target = min([until, *(r.next_time(engine.t) for r in self.recorders)])
        fixed = getattr(engine.c.integrator or engine.c.discretization, "dt", None) is not None
        dt, arrived = timestep.land(engine.t, self.limit.dt, target, fixed=fixed)
        self._whole = False
        engine.step(dt)
        self._take_out(leaving.act(engine, self.sim.leaving))
        guards.check(engine)
        self._whole = True
        self.writer.check()
        if arrived:
            engine.t = target  # frames lie on their times exactly
        due = [r for r in self.recorders if arrived and r.due(engine.t, until)]
        asked = engine.step_number % every == 0 or due or engine.t >= until
        if asked:
            self.rows.append(self.ledger.row(dt, self.repeats.steps))
        if asked or self.alarm.due(engine):
            self.alarm.look(engine, self.ledger.last["balance"] if asked else self.ledger.balance(), self.limit.rule)
        return dt, due

    def _take_out(self, rows: list[leaving.Row]) -> None:
        """List the particles that were taken out of the domain."""
        if rows:
            self.left += rows
            for r in self.recorders:
                r.write_left(rows)

    # --- going back ---------------------------------------------------------------------------------------------
    def facts(self) -> dict[str, Any]:
        """What the run itself knows of the present state, as plain data."""
        return {"first_dt": self.first_dt, "ledger": self.ledger.facts(), "alarm": self.alarm.facts()}

    def _recall(self, facts: dict[str, Any]) -> None:
        """The run as it was when these facts were written down."""
        self.first_dt = facts["first_dt"]
        self.ledger.recall(facts["ledger"])
        self.alarm.recall(facts["alarm"])
        self._whole = True

    def _forget_later(self) -> None:
        """Drop the rows after the present step: those of steps that a run has gone back behind."""
        step = self.engine.step_number
        for r in self.recorders:
            r.go_back(step)
        self.rows = [row for row in self.rows if row["step"] <= step]
        self.left = [row for row in self.left if row["step"] <= step]

    def saved_copies(self) -> tuple[dict[str, Any], list[dict[str, Any] | None]]:
        """The copies to which a resumed run may have to go back, as arrays and plain data."""
        return self._snapshot.save() if self._snapshot is not None else ({}, [])

    def _go_back(self, error: StabilityError, reporter: Reporter) -> None:
        """After a failed step: the last good copy and a smaller Courant number, or the error again if that would be of no use."""
        engine, copies, most = self.engine, self._snapshot, self.sim.retries
        stepper = engine.c.integrator or engine.c.discretization
        why_not = ""
        if not error.shorter:
            raise error
        if getattr(stepper, "dt", None) is not None:
            why_not = "dt is fixed; with an automatic time step a failed step is done again with a smaller one"
        elif not most:
            why_not = "retries = 0"
        elif copies is None or not copies.kept:
            why_not = f"there is no copy in memory of a state of more than {snapshot.IN_MEMORY >> 20} MiB to go back to"
        elif self.repeats.level >= most:
            last = self.repeats.done[-1]
            why_not = (
                f"{most} times in a row was not enough, the last time from step {last.back_step}, t = {last.back_t:.6g} s, with the "
                f"Courant number times {last.share:g} (retries = {most})"
            )
        if why_not:
            error.args = (f"{error.args[0]}\nnot repeated: {why_not}", *error.args[1:])
            raise error
        assert copies is not None
        failed = engine.step_number, engine.t
        copy = copies.restore(AWAY)
        self._recall(copy.facts)
        self._forget_later()
        told = self.repeats.went_back(*failed, copy.step, copy.t, str(error).split("\n")[0].split(". To fix")[0])
        warnings.warn(f"{told}", stacklevel=5)
        reporter.go_back(copy.step, copy.t)

    @contextmanager
    def _interruptible(self) -> Iterator[None]:
        """Ctrl-C takes effect between two steps, so that the state it leaves is whole; a second one at once."""
        self._stop = False
        if threading.current_thread() is not threading.main_thread():
            yield
            return

        def stop(number: int, frame: Any) -> None:
            if self._stop:
                raise KeyboardInterrupt
            self._stop = True

        before = signal.signal(signal.SIGINT, stop)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)

    # --- last good state ----------------------------------------------------------------------------------------
    def _leave(self, error: BaseException) -> None:
        """After a failure: the last good state, on disk where there is a record, in the simulation otherwise; the error says where."""
        if self._snapshot is None:
            return
        engine = self.engine
        unwritten = self.writer.settle()
        for r in self.recorders:
            r.forget_lost()
        good = self._whole and not isinstance(error, StabilityError)
        if not good and self._snapshot.kept:
            self._recall(self._snapshot.restore().facts)  # the rows of the steps that failed stay until the next run
            good = True
        here = f"step {engine.step_number}, t = {engine.t:.6g} s"
        on_disk = [f"step {r.on_disk[1]}, t = {r.on_disk[0]:.6g} s, {r.path}" for r in self.recorders if r.on_disk]
        if good and unwritten is None and self.recorders:
            where = f"{here}, {', '.join(map(self._saved, self.recorders))}"
        elif on_disk:  # what is written is never later than a frame that was lost
            where = f"{', '.join(on_disk)} (the last checkpoint)"
        elif good:
            where = f"{here}, kept in this simulation" + ("" if self.recorders else " (no Record was added)")
        else:
            where = (
                f"not kept: of a state of {snapshot.size(engine) >> 20} MiB there is no copy in memory (that ends at "
                f"{snapshot.IN_MEMORY >> 20} MiB), and no checkpoint was written; add a Record(path, checkpoint=True)"
            )
        error.args = (f"{error.args[0] if error.args else 'interrupted'}\nlast good state: {where}", *error.args[1:])

    def _saved(self, recorder: Recorder) -> str:
        """Write a checkpoint now; say where it is, or why it is not."""
        try:
            recorder.checkpoint(always=True)
            self.writer.finish()
        except MpmkitError as error:
            return f"not written ({error})"
        return str(recorder.path)

    def resume(self, path: str | PathLike[str]) -> None:
        """Take the state of a checkpoint; see `Simulation.resume`."""
        arrays, attributes = checkpoint.load(path)
        mine = self.identity()
        theirs = {k: attributes.get(k) for k in mine}
        if theirs["mpmkit"] != mine["mpmkit"]:
            raise ResultsError(
                f"{path}: written by mpmkit {theirs['mpmkit']}, this is {mine['mpmkit']}; resume with the version that wrote it"
            )
        if theirs != mine:
            differ = [k for k in mine if theirs[k] != mine[k]]
            raise ResultsError(
                f"{path}: checkpoint of another composition ({', '.join(differ)} differ); compose the simulation that wrote it"
            )
        if len(attributes["frames"]) != len(self.sim.records):
            raise ResultsError(
                f"{path}: the run that wrote it had {len(attributes['frames'])} Record(s), this simulation has {len(self.sim.records)}; "
                "add the same ones, their files are continued"
            )
        engine = self.engine
        engine.restore(arrays, float(attributes["t"]), int(attributes["step"]))
        self.rows = [dict(zip(COLUMNS, row, strict=True)) for row in attributes["rows"]] or self.rows
        self.left = attributes["left"]
        self.repeats.recall(attributes["repeats"])
        self._recall(attributes["facts"])
        self._snapshot = snapshot.Snapshot(engine)
        self._snapshot.load(arrays, attributes["copies"], self.facts())
        self.recorders = [Recorder.resume(r, self, number) for r, number in zip(self.sim.records, attributes["frames"], strict=True)]

    def identity(self) -> dict[str, Any]:
        """What a checkpoint must agree with."""
        from mpmkit._core.composing.fingerprint import fingerprint

        plan, sim = self.plan, self.sim
        parts = [sim.grid, sim.shape, sim.integrator, sim.discretization, *sim.boundaries, *sim.contacts, *sim.effects]
        parameters = [v.hex() for s, b in zip(self._stores, self.engine.body_par, strict=True) for v in map(float, b)]
        return {
            "mpmkit": mpmkit.__version__,
            "kernels": fingerprint(plan.names.functions, plan.text),
            "components": [_told(part) for part in parts if part is not None],
            "materials": parameters,
            "bodies": [s.name for s in self._stores],
            "particles": [s.begun for s in self._stores],
        }

    # --- what others read ---------------------------------------------------------------------------------------
    def history(self) -> dict[str, Any]:
        return {name: np.array([row[name] for row in self.rows]) for name in COLUMNS}

    def momentum_error(self) -> float:
        """Momentum that appeared without an impulse of forces or walls, relative to the sum of all momenta and impulses."""
        first, last = self.rows[0], self.ledger.last
        scale = sum(float((m * np.abs(v)).sum()) for s in self._stores for m, v in s.pieces("m", "v"))
        error = 0.0
        for a in "xyz":
            gained = last[f"momentum_{a}"] + last[f"left_momentum_{a}"] - first[f"momentum_{a}"]
            given = last[f"impulse_{a}"] + last[f"force_impulse_{a}"]
            scale = max(scale, abs(given))
            error = max(error, abs(gained - given))
        return error / scale if scale > 0.0 else 0.0

    def meta(self) -> dict[str, Any]:
        """Facts about the run for its result file."""
        from mpmkit.fields import PARTICLE_FIELDS

        grid = self.sim.grid
        scene, reason = self.sim.scene_text()
        units = {n: f.unit for n, f in PARTICLE_FIELDS.items()} | {f.name: f.unit for s in self._stores for f in s.group.state}
        return {
            "scene": scene,
            "scene_error": reason,
            "bodies": [s.name for s in self._stores],
            "ledger": list(COLUMNS),
            "versions": {"mpmkit": mpmkit.__version__, "numpy": np.__version__},
            "dim": grid.dim,
            "space": grid.space,
            "units": units,
            "grid": {"lower": list(grid.lower), "upper": list(grid.upper), "spacing": list(grid.spacing)},
        }


def _told(value: Any) -> str:
    """A component with its parameters as text that is the same in every process; functions by name, the fingerprint covers their code."""
    if attrs.has(type(value)):
        return f"{type(value).__name__}({', '.join(f'{a.name}={_told(getattr(value, a.name))}' for a in attrs.fields(type(value)))})"
    if isinstance(value, tuple):
        return f"({', '.join(map(_told, value))})"
    return getattr(value, "__qualname__", "function") if callable(value) else repr(value)
