"""mpmkit beside other programs on the same problem: each program in turn, several rounds, medians and ratios."""

from __future__ import annotations

import importlib.util
import json
import os
import shlex
import subprocess
import sys
import time
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.agreement import agreement
from benchmarks.problem import CASES, PRECISIONS, SIZES

ROOT = Path(__file__).parents[1]
PROGRAMS = {
    "mpmkit": ("mpmkit", "benchmarks.mpmkit_program"),
    "taichi": ("taichi", "benchmarks.taichi_program"),
    "warp": ("warp", "benchmarks.warp_program"),
    "jax": ("jax", "benchmarks.jax_program"),
}
"""Name: (the package it needs, its module)."""
ONE_THREAD = ("warp",)
Line = dict[str, Any]


def commands(against: dict[str, str], only: tuple[str, ...] = ()) -> tuple[dict[str, list[str]], dict[str, str]]:
    """Commands of the programs that can run here, and of the others why not.

    Parameters
    ----------
    against : dict
        Further programs, name: command.
    only : tuple of str
        Names to run; all if empty. mpmkit always runs.
    """
    found, missing = {}, {}
    for name, (package, module) in PROGRAMS.items():
        if only and name not in (*only, "mpmkit"):
            continue
        if importlib.util.find_spec(package) is None:
            missing[name] = f'{package} is not installed; pip install "mpmkit[bench]"'
        else:
            found[name] = [sys.executable, "-m", module]
    for name, command in against.items():
        found[name] = shlex.split(command)
    return found, missing


def run(command: list[str], case: str, size: str, prec: str, threads: int, budget: float, timeout: float = 900.0) -> Line:
    """Start a program and read its line.

    Raises
    ------
    RuntimeError
        If it fails or prints no line of JSON; with the end of what it said.
    """
    full = [*command, "--case", case, "--size", size, "--prec", prec, "--threads", str(threads), "--budget", str(budget)]
    environment = os.environ | {"BENCHMARK_STARTED": repr(time.time()), "PYTHONPATH": os.pathsep.join([str(ROOT), *_path()])}
    environment |= {"OMP_NUM_THREADS": str(threads), "OMP_PROC_BIND": "true", "OMP_WAIT_POLICY": "active"}
    done = subprocess.run(full, capture_output=True, text=True, env=environment, timeout=timeout)
    lines = [text for text in done.stdout.splitlines() if text.startswith("{")]
    if done.returncode or not lines:
        raise RuntimeError(f"{shlex.join(full)} failed ({done.returncode}): {(done.stderr or done.stdout).strip()[-500:]}")
    return dict(json.loads(lines[-1]))


def _path() -> list[str]:
    return [p for p in os.environ.get("PYTHONPATH", "").split(os.pathsep) if p]


def rounds(
    programs: dict[str, list[str]], setting: dict[str, Any], count: int, budget: float
) -> tuple[dict[str, list[Line]], dict[str, str]]:
    """Run all programs in turn, `count` times; a program that fails is left out of the following rounds."""
    lines: dict[str, list[Line]] = {name: [] for name in programs}
    failed: dict[str, str] = {}
    for _ in range(count):
        for name, command in programs.items():
            if name in failed:
                continue
            try:
                lines[name].append(run(command, **setting, budget=budget))
            except (RuntimeError, subprocess.TimeoutExpired, json.JSONDecodeError) as error:
                failed[name] = str(error)
                print(f"  {name}: {error}", file=sys.stderr)
    return {name: found for name, found in lines.items() if len(found) == count}, failed


def summary(lines: dict[str, list[Line]], reference: str = "mpmkit") -> dict[str, Line]:
    """Medians over the rounds, and ratios to the reference of the same round.

    Returns
    -------
    dict
        By program: ``mps`` (median, lowest and highest of the rounds), ``ratio`` (speed of the reference over the program's: median,
        lowest, highest), ``agreement`` with the reference, ``first_step`` (lowest and highest time from the start of the process to the
        first step [s]), ``bytes_per_particle``, ``phases``.
    """
    out: dict[str, Line] = {}
    for name, found in lines.items():
        speeds = [line["mps_med"] for line in found]
        row: Line = {"mps": _spread(speeds)}
        if reference in lines:
            row["ratio"] = _spread([ours["mps_med"] / line["mps_med"] for ours, line in zip(lines[reference], found, strict=True)])
            row["agreement"] = agreement(lines[reference][0], found[0])
        begins = [line["start_to_first_step_s"] for line in found if "start_to_first_step_s" in line]
        if begins:
            row["first_step"] = [min(begins), max(begins)]
        for key in ("own_bytes_per_particle", "field_bytes", "phases"):
            if key in found[-1]:
                row[key] = found[-1][key]
        out[name] = row
    return out


def _spread(values: list[float]) -> list[float]:
    return [median(values), min(values), max(values)]


def settings(cases: tuple[str, ...], sizes: tuple[str, ...], precs: tuple[str, ...], threads: tuple[int, ...]) -> list[dict[str, Any]]:
    """All combinations that exist."""
    return [
        {"case": case, "size": size, "prec": prec, "threads": t}
        for case in cases
        for size in sizes
        for prec in precs
        for t in threads
        if (CASES[case], size) in SIZES
    ]


def main(quick: bool = False, against: dict[str, str] | None = None, only: tuple[str, ...] = (), cases: tuple[str, ...] = ()) -> Line:
    """Measure all settings; the result as data for `report`."""
    programs, missing = commands(against or {}, only)
    cores = len(os.sched_getaffinity(0))
    threads = tuple(t for t in (1, 2) if t <= cores)
    sizes, precs, count, budget = (("Q",), ("f64",), 2, 1.0) if quick else (("S",), PRECISIONS, 3, 2.0)
    plan = settings(cases or tuple(CASES), sizes, precs, threads)
    if not quick and "apic3" in (cases or CASES):
        plan += settings(("apic3",), ("L",), ("f64",), threads)
    results = []
    for setting in plan:
        able = {name: c for name, c in programs.items() if setting["threads"] == 1 or name not in ONE_THREAD}
        lines, failed = rounds(able, setting, count, budget)
        row = setting | {"programs": summary(lines), "failed": failed}
        results.append(row)
        print(text(row), flush=True)
    return {"rounds": count, "missing": missing, "settings": results}


def text(row: Line) -> str:
    """One setting in lines for the terminal."""
    out = [f"{row['case']} {row['size']} {row['prec']}, {row['threads']} thread(s)"]
    for name, found in row["programs"].items():
        mps, ratio, agrees = found["mps"], found.get("ratio"), found.get("agreement", {})
        line = f"  {name:8} {mps[0]:8.2f} M/s ({mps[1]:.2f} to {mps[2]:.2f})"
        if ratio and name != "mpmkit":
            line += f"   mpmkit is {ratio[0]:.2f} x ({ratio[1]:.2f} to {ratio[2]:.2f})"
            line += f"   differs by {agrees.get('difference', float('nan')):.1e} in {agrees.get('of', '-')}"
            line += "" if agrees["agrees"] else f"   NOT THE SAME RESULT {agrees['note']}"
        out.append(line)
    phases = row["programs"].get("mpmkit", {}).get("phases", {})
    if phases:
        out.append("  phases of mpmkit: " + ", ".join(f"{name} {share:.0%}" for name, share in phases.items()))
    return "\n".join(out)


def disagreements(results: Line) -> list[str]:
    """Settings and programs whose diagnostics do not agree."""
    return [
        f"{row['case']} {row['size']} {row['prec']} {row['threads']}: {name}"
        for row in results["settings"]
        for name, found in row["programs"].items()
        if not found.get("agreement", {"agrees": True})["agrees"]
    ]


def sort_names(only: tuple[str, ...]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of programs and names of cases."""
    cases = tuple(name for name in only if name in CASES)
    return tuple(name for name in only if name not in CASES), cases
