"""What the phases and the optional components of a step cost, measured on copies of a simulation.

Phases are timed by the clocks of the engine in steps as a run does them. The share of a component is 1 - t(without it) / t(with it),
from two copies of the simulation that take turns, both starting from the same state: machines drift, but within a turn hardly.
A component costs more than its own lines: its fields are moved with the others, and memory, not arithmetic, is often what is short.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import attrs
import numpy as np

from mpmkit._core.running import guards, leaving, timestep, twins
from mpmkit._core.running.engine import Engine
from mpmkit._core.running.loop import Run
from mpmkit.errors import MpmkitError, ParameterError, StabilityError

SECONDS = 1.0
"""Wall time of the steps in which phases are timed, and of those of each pair of copies, unless steps are given."""
MOST_STEPS = 500
"""However short: the state shall stay near the one that is asked about."""
NEAR = 50
"""Steps from that state after which copies are put back to it."""
ROUNDS = (7, 60)
"""Fewest and most turns of a pair of copies."""

Say = Callable[[str], None]


def measure(run: Run, steps: int | None = None, say: Say = lambda text: None) -> dict[str, Any]:
    """Time the step of `run` from its present state; `run` itself does not move.

    Parameters
    ----------
    run : Run
        The composed simulation.
    steps : int, optional
        Steps in which the phases are timed; enough for about a second if not given.
    say : callable
        Told what is being done, as every copy without a component is compiled.

    Returns
    -------
    dict
        "steps", "t" [s], "dt" [s], "threads", "particles", "ns" per particle-step; "phases", rows with "name", "share" and "ns";
        "components", rows with "name", "kind", and either "share" and "spread" (half the width of the 95 % range of the median, the
        difference of two equal copies included) or "refused", the reason why there is no step without it; "control", the share that
        a copy seems to save which lacks nothing; "stopped", why fewer steps were done than asked for.

    Raises
    ------
    ParameterError
        If `steps` is not a number above zero.
    StabilityError
        If the simulation cannot do a single step.
    """
    if steps is not None and (isinstance(steps, bool) or not isinstance(steps, int) or steps < 1):
        raise ParameterError(f"measure: steps must be a whole number above 0, got {steps!r}")
    master = run.engine
    say("measuring the phases")
    base = twins.twin(run.sim, master.team.size)
    twins.take_state(base.engine, master)
    dt = timestep.next_step(master).dt
    out, seconds = _phases(run, base, steps)
    out |= {"t": master.t, "dt": dt, "threads": master.team.size, "particles": run.n_particles}
    near = min(NEAR, max(2, out["steps"])) if out["stopped"] else NEAR
    control = _saved(run, base, None, dt, seconds, steps, near)
    out["control"] = {"share": control[0], "spread": control[1]}
    out["components"] = []
    roles = twins.optional(run.plan.composition)
    for k, (role, place) in enumerate(roles.items(), 1):
        say(f"measuring without {role} ({k} of {len(roles)})")
        row: dict[str, Any] = {"name": role, "kind": place[0]}
        try:
            share, spread, rounds = _saved(run, base, place, dt, seconds, steps, near)
            row |= {"share": share, "spread": math.hypot(spread, control[0]), "rounds": rounds}
        except MpmkitError as error:
            row["refused"] = str(error).split("\n")[0]
        out["components"].append(row)
    return out


def _phases(run: Run, base: Run, steps: int | None) -> tuple[dict[str, Any], float]:
    """Times of all parts of a step as a run does it, and the wall time of one step [s]."""
    engine, stopped = base.engine, ""
    _steps(engine, 2, timestep.next_step(engine).dt)
    if steps is None:
        one = _steps(engine, 2, timestep.next_step(engine).dt) / 2
        steps = int(np.clip(SECONDS / max(one, 1e-9), 10, MOST_STEPS))
    twins.take_state(engine, run.engine)
    engine.clocks.clear()
    around, done, simulated = 0.0, 0, 0.0
    try:
        for _ in range(steps):
            begin = time.perf_counter()
            dt = timestep.next_step(engine).dt
            before = time.perf_counter()
            _step(engine, dt)
            after = time.perf_counter()
            guards.check(engine)
            around += before - begin + time.perf_counter() - after
            done, simulated = done + 1, simulated + dt
    except StabilityError as error:
        if not done:
            raise
        stopped = str(error).split("\n")[0]
        twins.take_state(engine, run.engine)
    parts = {name: spent / done for name, spent in engine.clocks.items()} | {"guards, time step": around / done}
    every = min((r.history for r in run.sim.records), default=10)
    parts[f"history, every {every} steps"] = _median_time(lambda: base.ledger.row(0.0), 5) / every
    for record in run.sim.records:
        parts |= _writing(base, record, simulated / done, sum(parts.values()))
    total, n = sum(parts.values()), run.n_particles
    rows = [{"name": name, "share": spent / total, "ns": 1e9 * spent / n} for name, spent in parts.items()]
    return {"steps": done, "ns": 1e9 * total / n, "phases": rows, "stopped": stopped}, sum(engine.clocks.values()) / done


def _writing(base: Run, record: Any, dt: float, step: float) -> dict[str, float]:
    """How long frames and checkpoints hold up a step on average [s]; they are written to a temporary folder."""
    from mpmkit._core.running import recorder

    if record.every is None:
        return {}  # at the start and the end only
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / f"measured{Path(record.path).suffix}")
        one = recorder.Recorder(attrs.evolve(record, path=path, checkpoint=False), base)
        spent = []
        for _ in range(3):
            _step(base.engine, dt)
            begin = time.perf_counter()
            one.after_step(base.engine.step_number, base.ledger.last, True)
            spent.append(time.perf_counter() - begin)
            base.writer.finish()
        begin = time.perf_counter()
        one.checkpoint(always=True)
        held = time.perf_counter() - begin
        base.writer.finish()
        one.history.close()
    between = record.every / dt
    out = {f"frames, every {record.every:g} s": median(spent) / between}
    if record.checkpoint:
        rare = recorder.CHECKPOINT_SECONDS * max(1.0, one.cost / recorder.CHECKPOINT_COST) / step
        out["checkpoints"] = held / max(between, rare)
    return out


def _saved(
    run: Run, base: Run, place: twins.Place | None, dt: float, step: float, steps: int | None, near: int
) -> tuple[float, float, int]:
    """Share of a step that a copy without a component saves, half the width of the median's 95 % range, and the number of turns."""
    other = twins.twin(run.sim, run.engine.team.size, place)
    count = int(np.clip(0.01 / step, 1, near - 1))
    wanted = SECONDS / (2 * count * step) if steps is None else steps / count
    rounds = int(np.clip(wanted, *ROUNDS))
    pair, shares, done = (base.engine, other.engine), [], near
    for k in range(rounds):
        if done + count + 1 > near:
            for engine in pair:
                twins.take_state(engine, run.engine)
            done = 0
        times = {}
        for engine in pair if k % 2 else pair[::-1]:
            _step(engine, dt)  # sorts, and brings the arrays back into the caches
            times[id(engine)] = _steps(engine, count, dt)
        done += count + 1
        shares.append(1.0 - times[id(pair[1])] / times[id(pair[0])])
    low, high = np.percentile(shares, (25, 75))
    other.engine.team.close()
    # notches of box plots: McGill, Tukey and Larsen (1978), doi:10.2307/2683468
    return float(median(shares)), float(1.57 * (high - low) / math.sqrt(rounds)), rounds


def _step(engine: Engine, dt: float) -> None:
    """A step as a run does it."""
    engine.step(dt)
    leaving.act(engine, engine.c.sim.leaving)


def _steps(engine: Engine, count: int, dt: float) -> float:
    """Wall time of some steps [s]."""
    begin = time.perf_counter()
    for _ in range(count):
        _step(engine, dt)
    return time.perf_counter() - begin


def _median_time(action: Callable[[], Any], times: int) -> float:
    spent = []
    for _ in range(times):
        begin = time.perf_counter()
        action()
        spent.append(time.perf_counter() - begin)
    return median(spent)
