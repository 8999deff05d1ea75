"""What all programs share: options, the measuring loop, and the one line of JSON they print.

Any other program can be compared with ours if it takes the same options and prints one line with at least ``case``, ``size``, ``prec``,
``threads``, ``n``, ``mps_min``, ``mps_med``, ``mps_max`` (million particle-steps per second) and ``diag20`` (see `problem.diagnostics`).
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks import problem

IMPORTED = time.time()
CHUNKS = 4
"""At least that many chunks of steps are measured, whatever the budget."""


def options(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """The options of a program, with ``at``: its `problem.Size`."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--case", choices=tuple(problem.CASES), default="apic3")
    parser.add_argument("--size", default="S", help="S, L (3D only), Q or T")
    parser.add_argument("--prec", choices=problem.PRECISIONS, default="f64")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--budget", type=float, default=8.0, help="seconds of measured steps")
    parser.add_argument("--steps", type=int, default=180, help="measured steps at most; later the block meets a wall")
    given = parser.parse_args(arguments)
    key = (problem.CASES[given.case], given.size)
    if key not in problem.SIZES:
        parser.error(f"--size {given.size} does not exist for {given.case}: {', '.join(s for d, s in problem.SIZES if d == key[0])}")
    if given.threads < 1:
        parser.error(f"--threads must be at least 1, got {given.threads}")
    given.at = problem.SIZES[key]
    given.dtype = np.float64 if given.prec == "f64" else np.float32
    return given


def resident() -> int:
    """Memory that the process holds now [bytes]."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


def measure(
    name: str,
    given: argparse.Namespace,
    advance: Callable[[int], None],
    state: Callable[[], tuple[Any, Any, Any]],
    extra: Callable[[], dict[str, Any]] = dict,
) -> dict[str, Any]:
    """Measure a program and print its line.

    Parameters
    ----------
    name : str
        Of the program.
    given : Namespace
        From `options`; with ``base``, the memory held before the first array was made.
    advance : callable
        ``advance(k)`` does k steps and returns when they are done.
    state : callable
        Positions, velocities and F now.
    extra : callable
        More entries of the line, called after the measurement.
    """
    size: problem.Size = given.at
    begin = time.perf_counter()
    advance(1)
    first = time.perf_counter() - begin
    since_start = time.time() - float(os.environ.get("BENCHMARK_STARTED", IMPORTED))
    late = problem.LATE[given.case] if name == "mpmkit" else 0
    begin = time.perf_counter()
    advance(problem.COMPARED_AT - 1 - late)
    one = (time.perf_counter() - begin) / (problem.COMPARED_AT - 1 - late)
    F = None
    if late:
        F = np.array(state()[2])
        advance(late)
    x, v, F_now = state()
    numbers = problem.diagnostics(size, x, v, F_now if F is None else F)
    del x, v, F, F_now
    chunk = max(1, min(10, given.steps // CHUNKS, int(0.25 / one)))
    speeds: list[float] = []
    begin = time.perf_counter()
    while (len(speeds) < CHUNKS or time.perf_counter() - begin < given.budget) and (len(speeds) + 1) * chunk <= given.steps:
        then = time.perf_counter()
        advance(chunk)
        speeds.append(chunk * size.particles / (time.perf_counter() - then) / 1e6)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    line = {"impl": name, "case": given.case, "size": given.size, "prec": given.prec, "threads": given.threads, "n": size.particles}
    line |= {"mps_min": min(speeds), "mps_med": float(np.median(speeds)), "mps_max": max(speeds), "chunks": len(speeds)}
    line |= {"first_step_s": first, "start_to_first_step_s": since_start}
    line |= {"bytes_per_particle": peak / size.particles, "own_bytes_per_particle": (peak - given.base) / size.particles}
    line |= {"diag20": numbers} | extra()
    print(json.dumps(line), flush=True)
    return line
