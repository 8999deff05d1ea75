"""Cost of each component relative to the base step, beside what arithmetic lets expect; all compositions in one interleaved run."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

import mpmkit as mpm
from benchmarks import arithmetic, inside, variants

SIDE, SIDE_QUICK = 24, 10
"""Cells along the cube: 110,592 and 8,000 particles."""
AROUND: dict[str, dict[str, Any] | None] = {
    "run loop: guards, time step, history every 10 steps": None,
    "history every step": {"history": 1, "fields": ("v",), "checkpoint": False},
    "frame and checkpoint every {count} steps": {},
}
"""What `Simulation.run` does around the steps: options of a record, or none at all."""


def main(quick: bool = False, only: tuple[str, ...] = ()) -> dict[str, Any]:
    """Measure all variants (or those whose name or group is in `only`, and their bases)."""
    inside.set_threads(1)
    side, rounds, count = (SIDE_QUICK, 3, 2) if quick else (SIDE, 9, 3)
    chosen = variants.variants()
    if only:
        wanted = {v.name for v in chosen if {v.name, v.group} & set(only)}
        needed = wanted | {v.base for v in chosen if v.name in wanted} | {"base"}
        chosen = [v for v in chosen if v.name in needed]
    steppers = {}
    for v in chosen:
        begin = time.perf_counter()
        steppers[v.name] = inside.stepper(variants.compose(v, side))
        steppers[v.name].steps(3, variants.DT)
        print(f"  {v.name}: ready after {time.perf_counter() - begin:.1f} s", flush=True)
    times = _interleaved(steppers, rounds, count)
    rows = [_row(v, {o.name: o for o in chosen}, steppers, times) for v in chosen]
    if not only or "run" in only:
        rows += around(side, 3, 10 if quick else 100)
    for row in rows:
        print(
            f"  {row['name']:34} {row['ratio']:6.2f} x, expected {row['expected']:5.2f}, measured/expected {row['over']:5.2f}", flush=True
        )
    return {"particles": steppers["base"].particles, "rounds": rounds, "rows": rows}


def _interleaved(steppers: dict[str, inside.Stepper], rounds: int, count: int) -> dict[str, list[float]]:
    """Wall time of a particle-step [s] in each round, all compositions in turn."""
    times: dict[str, list[float]] = {name: [] for name in steppers}
    for _ in range(rounds):
        for name, stepper in steppers.items():
            times[name].append(stepper.steps(count, variants.DT) / stepper.particles)
    return times


def _row(
    v: variants.Variant, known: dict[str, variants.Variant], steppers: dict[str, inside.Stepper], times: dict[str, list[float]]
) -> dict[str, Any]:
    ratio = median(a / b for a, b in zip(times[v.name], times[v.base], strict=True))
    work, base = (_work(known[name], steppers[name]) for name in (v.name, v.base))
    expected = max(work["flops"] / base["flops"], work["bytes"] / base["bytes"])
    return {
        "name": v.name,
        "group": v.group,
        "base": v.base,
        "ns": 1e9 * median(times[v.name]),
        "ratio": ratio,
        "expected": expected,
        "over": ratio / expected,
        "nodes": v.shape.nodes**3,
        "passes": len(steppers[v.name].passes()),
    } | work


def _work(v: variants.Variant, stepper: inside.Stepper) -> dict[str, float]:
    transfer = v.integrator.transfer
    effects = tuple(p for p in v.parts if hasattr(p, "viscous_pressure"))
    return {
        "flops": arithmetic.flops(stepper, v.shape, transfer, v.material, effects),
        "bytes": sum(arithmetic.traffic(stepper, 8, 8).values()),
    }


def around(side: int, rounds: int, count: int) -> list[dict[str, Any]]:
    """The run loop and what is recorded, relative to steps by hand; a run ends after `count` steps, and its last state is a frame."""
    base = variants.variants()[0]
    by_hand = inside.stepper(variants.compose(base, side))
    sizes, work = by_hand.field_numbers(), _work(base, by_hand)
    bare: list[float] = []
    looped: dict[str, list[float]] = {name: [] for name in AROUND}
    with tempfile.TemporaryDirectory() as folder, inside.quiet():
        sims = {}
        for k, (name, record) in enumerate(AROUND.items()):
            sims[name] = variants.compose(base, side)
            if record is not None:
                sims[name] += mpm.Record(str(Path(folder) / f"run{k}.vtkhdf"), **record)
            sims[name].run(until=variants.DT, quiet=True)
        for r in range(rounds):
            bare.append(by_hand.steps(count, variants.DT))
            for name, sim in sims.items():
                begin = time.perf_counter()
                sim.run(until=(1 + (r + 1) * count) * variants.DT, quiet=True)
                looped[name].append((time.perf_counter() - begin) / count)
    rows = []
    for name, record in AROUND.items():
        options = record or {}
        # a row of the history is one more loop that reads all fields; a frame reads and writes its fields, a checkpoint all of them
        # (stresses that no field keeps are six numbers, too)
        frame = sum(sizes.get(f, 6) for f in options.get("fields", ("x", "v", "stress"))) if record is not None else 0
        kept = sum(sizes.values()) if record is not None and options.get("checkpoint", True) else 0
        read = sum(sizes.values()) / options.get("history", 10)
        more = 8 * (read + 2 * (frame + kept) / count)
        ratio = median(a / b for a, b in zip(looped[name], bare, strict=True))
        expected = 1.0 + more / work["bytes"]
        row = {"name": name.format(count=count), "group": "run", "base": "base", "ns": 1e9 * median(looped[name]) / by_hand.particles}
        row |= {
            "ratio": ratio,
            "expected": expected,
            "over": ratio / expected,
            "nodes": base.shape.nodes**3,
            "passes": len(by_hand.passes()),
        }
        rows.append(row | work)
    return rows
