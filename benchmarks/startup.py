"""From the start of a process to the end of its first step: with an empty cache, and again with what the first process left there."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

ROOT = Path(__file__).parents[1]
JOBS = {"disks": "the main job of the README, examples/two_disks.toml", "block": "the block of the comparison in 3D, 262,144 particles"}


def main(quick: bool = False, only: tuple[str, ...] = ()) -> list[dict[str, Any]]:
    """Cold and warm times of the jobs (all, or those named in `only`)."""
    rows = []
    for job, what in JOBS.items():
        if only and job not in only:
            continue
        cold, warm = [], []
        for _ in range(1 if quick else 3):
            with tempfile.TemporaryDirectory() as folder:
                cold.append(_child(job, folder))
                warm += [_child(job, folder) for _ in range(2)]
        row: dict[str, Any] = {"job": job, "what": what}
        for name, found in (("cold", cold), ("warm", warm)):
            row[name] = {key: median(line[key] for line in found) for key in found[0]}
        rows.append(row)
        print(f"  {job}: first step after {row['cold']['total']:.2f} s cold, {row['warm']['total']:.2f} s warm", flush=True)
    return rows


def _child(job: str, folder: str) -> dict[str, float]:
    environment = os.environ | {"MPMKIT_CACHE_DIR": folder, "BENCHMARK_STARTED": repr(time.time())}
    environment["PYTHONPATH"] = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [sys.executable, "-m", "benchmarks.startup", job]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=folder, timeout=600)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)} failed: {done.stderr.strip()[-500:]}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def child(job: str) -> dict[str, float]:
    """One start, in this process: seconds until mpmkit was imported, until the scene was composed, and until its first step was done."""
    started = float(os.environ["BENCHMARK_STARTED"])
    import mpmkit  # noqa: F401
    from benchmarks import inside, mpmkit_program, problem

    imported = time.time() - started
    if job == "disks":
        from mpmkit import scene

        sim, dt = scene.load(ROOT / "examples/two_disks.toml"), 1e-3
    else:
        size = problem.SIZES[3, "S"]
        sim, dt = mpmkit_program.compose("apic3", size), size.dt
    with inside.quiet():
        run = sim.compose()
    composed = time.time() - started
    inside.Stepper(run).steps(1, dt)
    return {"imported": imported, "composed": composed, "total": time.time() - started}


if __name__ == "__main__":
    print(json.dumps(child(sys.argv[1])))
