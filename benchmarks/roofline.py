"""What the machine allows at most for a particle-step, and how much of that is reached."""

from __future__ import annotations

import os
from statistics import median
from typing import Any

from benchmarks import arithmetic, compare, inside, machine, mpmkit_program, problem


def main(quick: bool = False, only: tuple[str, ...] = ()) -> dict[str, Any]:
    """Bounds of memory and arithmetic for all cases (or those in `only`), and the measured speed beside them."""
    cores = len(os.sched_getaffinity(0))
    threads = [t for t in (1, 2) if t <= cores]
    megabytes = 100 if quick else 400
    roofs = {t: {"bandwidth": machine.bandwidth(t, megabytes), "f64": machine.peak(t, 64), "f32": machine.peak(t, 32)} for t in threads}
    for t, roof in roofs.items():
        print(
            f"  {t} thread(s): {roof['bandwidth'] / 1e9:.1f} GB/s, {roof['f64'] / 1e9:.0f} and {roof['f32'] / 1e9:.0f} GFLOP/s (f64, f32)"
        )
    program = compare.commands({}, ("mpmkit",))[0]["mpmkit"]
    rows = []
    for case, dim in problem.CASES.items():
        if only and case not in only:
            continue
        for prec in ("f64",) if quick else problem.PRECISIONS:
            work = count(case, dim, prec)
            for t in threads:
                lines = [compare.run(program, case, "Q" if quick else "S", prec, t, 1.0) for _ in range(1 if quick else 3)]
                rows.append(_row(case, prec, t, work, roofs[t], median(line["mps_med"] for line in lines)))
    return {"roofs": roofs, "rows": rows}


def count(case: str, dim: int, prec: str) -> dict[str, float]:
    """Bytes and operations of a particle-step, from a small simulation of the same composition."""
    sim = mpmkit_program.compose(case, problem.SIZES[dim, "T"], "float64" if prec == "f64" else "float32")
    stepper = inside.stepper(sim)
    moved = arithmetic.traffic(stepper, 8 if prec == "f64" else 4, 2**dim)
    transfer = sim.integrator.transfer
    return {"bytes": sum(moved.values()), "flops": arithmetic.flops(stepper, sim.shape, transfer, sim.bodies[0].material)}


def _row(case: str, prec: str, threads: int, work: dict[str, float], roof: dict[str, float], mps: float) -> dict[str, Any]:
    memory, arithmetic_ = roof["bandwidth"] / work["bytes"] / 1e6, roof[prec] / work["flops"] / 1e6
    bound = min(memory, arithmetic_)
    row = {"case": case, "prec": prec, "threads": threads, **work, "memory": memory, "arithmetic": arithmetic_}
    row |= {"mps": mps, "limited_by": "memory" if memory < arithmetic_ else "arithmetic", "reached": mps / bound}
    print(
        f"  {case} {prec}, {threads} thread(s): {work['bytes']:.0f} bytes and {work['flops']:.0f} operations per particle-step, at most "
        f"{memory:.1f} (memory) and {arithmetic_:.1f} (arithmetic) M/s; {mps:.2f} M/s is {row['reached']:.0%}",
        flush=True,
    )
    return row
