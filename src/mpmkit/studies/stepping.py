"""One run in a process of its own: errors at chosen instants, or the wall time of the same steps."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable
from statistics import median
from typing import Any

import numpy as np

from mpmkit._core.running import guards, timestep
from mpmkit._core.running.progress import Reporter
from mpmkit.errors import CompositionError, FieldContractError, MpmkitError, ParameterError, SceneError, StabilityError
from mpmkit.studies import limits, measures, samples, scenes, solutions

STAGGERED = "staggered"
AGREES = 0.05
"""Largest difference between a scene's velocities and the exact ones, relative to these, for which they are the same start."""
SHORT_SECONDS, MOST_PASSES = 0.1, 5
"""A run that is shorter is timed several times in a row, and counts with the median."""
CALIBRATION_SECONDS, CALIBRATION_STEPS, LOOKS = 0.2, 200, 20

Say = Callable[[], None]


def execute(job: dict[str, Any], ready: Say = lambda: None) -> dict[str, Any]:
    """Do one job and return plain data; whatever goes wrong in it is data, too.

    Parameters
    ----------
    job : dict
        "task" ("errors", "time", "calibrate"), the scene ("data", or "function", "folder" and "choices"), "until", "measures",
        "startup", "threads", "memory_budget", "arrays" (file for fields that are compared later), "seconds" (to calibrate).
    ready : callable
        Called when everything is compiled and stepping begins.
    """
    task = {"errors": _errors, "time": _time, "calibrate": _calibrate}[job["task"]]
    limit = limits.Memory(job.get("memory_budget"))
    composing = [True]

    def begin() -> None:
        composing[0] = False
        limit.start()
        ready()

    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            out = task(job, begin)
        peak = limit.peak()
        if job.get("memory_budget") and peak is not None and peak > job["memory_budget"]:
            return {"status": "over budget", "reason": f"it needed {limits.text(peak)} of memory, {_allowed(job)}"}
        told = [str(w.message).split("\n")[0] for w in caught if issubclass(w.category, UserWarning)]
        return {"status": "done", "reason": "", "peak_bytes": peak, **out, "notes": [*out.get("notes", []), *dict.fromkeys(told)]}
    except StabilityError as error:
        return _ended("unstable", error)
    except MemoryError:
        return {"status": "over budget", "reason": f"memory ran out, {_allowed(job)}"}
    except (CompositionError, FieldContractError, SceneError) as error:
        return _ended("refused" if composing[0] else "failed", error)
    except MpmkitError as error:
        return _ended("failed", error)
    except Exception as error:  # noqa: BLE001  (a component or scene may raise anything; it is one point of many)
        return {"status": "failed", "reason": f"{type(error).__name__}: {error}"}
    finally:
        limit.lift()


def _allowed(job: dict[str, Any]) -> str:
    return f"{limits.text(job['memory_budget'])} are allowed" if job.get("memory_budget") else "no limit was given"


def _ended(status: str, error: Exception) -> dict[str, Any]:
    return {"status": status, "reason": str(error)}


class Stepping:
    """A composed and compiled simulation, at its start."""

    def __init__(self, job: dict[str, Any], fields: set[str]) -> None:
        self.sim = scenes.build(job)
        self.run = self.sim.compose()
        self.run.use(job.get("threads", 1))
        self.run.warm_up()
        self.engine = self.run.engine
        self.until = float(job["until"])
        self.reporter = Reporter(self.until, self.run.n_particles, quiet=True)
        stores = self.engine.stores
        self.fields = {f for f in fields if all(f in s.available() for s in stores)}
        missing = fields - self.fields - set(samples.POINT) - {"stress", "v"}
        if missing:
            raise ParameterError(f"errors of {', '.join(sorted(missing))} cannot be measured: the particles of this scene do not keep it")
        self.start = {s.name: np.array(s.get("x"), float) for s in stores}
        self.notes: list[str] = []
        self.dt = 0.0
        guards.check(self.engine)

    def sample(self) -> samples.Sample:
        """The particles now."""
        bodies = {s.name: {f: s.get(f) for f in self.fields} for s in self.engine.stores}
        return samples.Sample(self.engine.t, self.dt, self.sim.grid.space, self.start, bodies)

    def travel(self, at: samples.Sample) -> float:
        """How many cells the particle that has moved farthest is away from where it started."""
        moved = [np.abs(at.bodies[name]["x"] - X).max(initial=0.0) for name, X in self.start.items()]
        return float(max(moved, default=0.0) / self.sim.grid.h)

    def to(self, t: float) -> float:
        """Step to a time; the wall time it took [s]."""
        gap = t - self.engine.t
        begin = time.perf_counter()
        self.run.step_to(t, self.reporter)
        spent = time.perf_counter() - begin
        limit = self.run.limit
        self.dt = gap if limit is None else min(limit.dt, gap)  # that of the steps before the last ones, which land on t
        return spent

    def stagger(self, evaluator: solutions.Evaluator, first: float) -> bool:
        """Start with the velocities of half a step before; whether velocities now are those of half steps.

        Explicit steps have velocities half a step behind positions: v(0) at the start is an error a dt/2 that never leaves.
        """
        engine = self.engine
        if engine.c.stored_operator:
            self.notes.append("velocities start at t = 0: this method keeps them at nodes")
            return False
        dt = min(timestep.next_step(engine).dt, first)
        before = {}
        for store in engine.stores:
            X = self.start[store.name]
            given, exact = store.get("v"), evaluator.velocity(X, 0.0)
            if exact is None:
                return False
            earlier = evaluator.velocity(X, -0.5 * dt)
            scale = max(float(np.abs(exact).max(initial=0.0)), float(np.abs(given).max(initial=0.0)))
            apart = min(float(np.abs(given - v).max(initial=0.0)) for v in (exact, earlier))
            if apart > AGREES * scale:
                self.notes.append("velocities are compared as they are: the scene does not start with those of the exact solution")
                return False
            before[store.name] = earlier
        for store in engine.stores:
            store.set("v", before[store.name])
        run = self.run
        run.ledger.first_energy, run.ledger.scale = None, 0.0
        run.rows[:] = [run.ledger.row(0.0)]
        return True


def _prepared(job: dict[str, Any]) -> tuple[Stepping, list[Any], list[float], dict[int, solutions.Evaluator], bool]:
    """The run at its start, the measures, the instants to land on, an evaluator for each exact solution, and how velocities count."""
    wanted = [measures.read(m) for m in job.get("measures", ())]
    stepping = Stepping(job, set().union(*(m.fields() for m in wanted), samples.POINT))
    instants = sorted({stepping.until, *(t for m in wanted for t in m.instants(stepping.until) if t > 0.0)})
    evaluators, staggered = {}, False
    for k, measure in enumerate(wanted):
        if isinstance(measure, measures.Exact):
            solution, notes = solutions.build(measure.solution, stepping.sim, job["choices"], job["folder"], measure.bodies)
            stepping.notes += notes
            evaluators[k] = solutions.Evaluator(solution, measure.origin, measure.axis, stepping.sim.grid.space)
    if evaluators and job.get("startup") == STAGGERED:
        staggered = stepping.stagger(next(iter(evaluators.values())), instants[0])
    return stepping, wanted, instants, evaluators, staggered


def _errors(job: dict[str, Any], ready: Say) -> dict[str, Any]:
    stepping, wanted, instants, evaluators, staggered = _prepared(job)
    ready()
    found, seconds = [stepping.sample()], 0.0
    for t in instants:
        seconds += stepping.to(t)
        found.append(stepping.sample())
    values, numbers = {}, {}
    arrays: dict[str, Any] = {}
    history = stepping.run.history()
    for k, m in enumerate(wanted):
        if isinstance(m, measures.Exact):
            values[m.label] = m.value(found, stepping.until, evaluators[k], staggered)
        elif isinstance(m, measures.Quantity):
            numbers[m.label] = m.number(history, found, job["folder"])
            right = m.right(stepping.sim, job["choices"], job["folder"])
            values[m.label] = abs(numbers[m.label] - right) / (abs(right) if m.relative else 1.0)
        else:
            arrays |= {f"{k}/{name}": a for name, a in m.arrays(found, stepping.until).items()}
    bad = [label for label, value in values.items() if not math.isfinite(value)]
    if bad:
        raise StabilityError(f"the error is no finite number: {', '.join(bad)}")
    if arrays:
        np.savez_compressed(job["arrays"], **arrays)
    run = stepping.run
    travel = max(stepping.travel(sample) for sample in found)
    return {"errors": values, "values": numbers, "notes": stepping.notes, "first_seconds": seconds, "travel": travel, **_counts(run)}


def _counts(run: Any) -> dict[str, Any]:
    return {"steps": run.engine.step_number, "particles": run.n_particles}


def _time(job: dict[str, Any], ready: Say) -> dict[str, Any]:
    """Wall time of the same steps, nothing else: no compilation, no output, no reading of fields."""
    spent: list[float] = []
    counts: dict[str, Any] = {}
    while not spent or (sum(spent) < SHORT_SECONDS and len(spent) < MOST_PASSES):
        stepping, _, instants, _, _ = _prepared(job)
        if not spent:
            ready()
        spent.append(sum(stepping.to(t) for t in instants))
        counts = _counts(stepping.run)
        stepping.engine.team.close()
    return {"seconds": median(spent), "passes": len(spent), **counts}


def _calibrate(job: dict[str, Any], ready: Say) -> dict[str, Any]:
    """Seconds of a step at the start, its length, and how far particles come; for longer if the job says "seconds"."""
    stepping = Stepping(job, {*samples.POINT, "v"})
    ready()
    engine = stepping.engine
    first = timestep.next_step(engine).dt
    most, count = job.get("seconds", CALIBRATION_SECONDS), math.inf if "seconds" in job else CALIBRATION_STEPS
    spent, steps, stride, travel = 0.0, 0, 10, 0.0
    while steps < 3 or (spent < most and steps < count):
        target = min(engine.t + stride * timestep.next_step(engine).dt, stepping.until)
        before = engine.step_number
        spent, steps = spent + stepping.to(target), steps + engine.step_number - before
        travel = max(travel, stepping.travel(stepping.sample()))
        if engine.t >= stepping.until:
            break
        if "seconds" in job:  # few looks at the particles, but some in every run
            stride = max(10, min(int(0.1 * most * steps / max(spent, 1e-9)), int(stepping.until / first / LOOKS)))
    now = stepping.sample()
    speed = max((float(np.abs(b["v"]).max(initial=0.0)) for b in now.bodies.values() if "v" in b), default=0.0)
    out = {"seconds_per_step": spent / max(steps, 1), "dt": first, "steps": steps, "particles": stepping.run.n_particles}
    return out | {"t": engine.t, "seconds": spent, "travel": travel, "speed": speed / stepping.sim.grid.h}
