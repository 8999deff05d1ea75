"""Memory of a million particles in 3D beside the bytes of the declared fields; each run in a process of its own."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.startup import ROOT

STEPPERS = ("MUSL, FLIP", "MUSL, APIC", "USL, MLS, merged sums")
SIDE, SIDE_QUICK = 50, 10  # cells
CELLS = 100
DT = 2e-5  # s
STEPS = 20


def main(quick: bool = False, only: tuple[str, ...] = ()) -> list[dict[str, Any]]:
    """Bytes of all compositions, or those named in `only`."""
    rows = []
    for stepper in STEPPERS:
        if only and stepper not in only:
            continue
        found = [_child(stepper, record, SIDE_QUICK if quick else SIDE) for record in (False, True)]
        row = {"stepper": stepper, **found[0], "peak with frames": found[1]["peak"]}
        rows.append(row)
        declared = row["particle fields"] + row["node fields"]
        print(
            f"  {stepper}: {row['peak'] / declared:.2f} x the declared fields, {row['peak with frames'] / declared:.2f} x with frames",
            flush=True,
        )
    return rows


def _child(stepper: str, record: bool, side: int) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])}
        command = [sys.executable, "-m", "benchmarks.memory", stepper, str(int(record)), str(side)]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=folder, timeout=600)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)} failed: {done.stderr.strip()[-500:]}")
    return dict(json.loads(done.stdout.splitlines()[-1]))


def child(stepper: str, record: bool, side: int) -> dict[str, float]:
    """One run in this process: bytes of fields, and by how much the process grew at the most, after a small run of the same kind."""
    from benchmarks import inside

    with inside.quiet():
        _scene(stepper, record, 3).run(quiet=True)
        before = int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()
        sim = _scene(stepper, record, side)
        sim.run(quiet=True)
    particles, nodes = inside.field_bytes(sim)
    peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    return {"particles": sim.compose().n_particles, "particle fields": particles, "node fields": nodes, "peak": peak}


def _scene(stepper: str, record: bool, side: int) -> Any:
    import mpmkit as mpm
    from mpmkit import boundaries, effects, integrators, materials, shapes

    integrator = {
        "MUSL, FLIP": integrators.MUSL(dt=DT),
        "MUSL, APIC": integrators.MUSL(integrators.APIC(), dt=DT),
        "USL, MLS, merged sums": integrators.USL(integrators.MLS(), limit=0.0, dt=DT),
    }[stepper]
    h = 1.0 / CELLS
    lower, upper = 0.5 - 0.5 * side * h, 0.5 + 0.5 * side * h
    sim = mpm.Simulation(mpm.Grid((0.0,) * 3, (1.0,) * 3, h), shapes.QuadraticBSpline(), integrator, until=STEPS * DT)
    rubber = materials.NeoHookean(E=1e6, nu=0.3, rho=1000.0)
    sim += mpm.Body(mpm.Box((lower,) * 3, (upper,) * 3), rubber, (1.0, 0.5, 0.0)), boundaries.Wall("all", condition="slip")
    sim += effects.Gravity((0.0, 0.0, -9.81))
    if record:
        sim += mpm.Record(f"{side}.vtkhdf", fields=("v", "stress"), every=STEPS * DT / 2)
    return sim


if __name__ == "__main__":
    print(json.dumps(child(sys.argv[1], sys.argv[2] == "1", int(sys.argv[3]))))
