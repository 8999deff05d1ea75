"""Time of a particle-step against the number of particles and of threads, the size of an empty domain, and bodies that fly apart."""

from __future__ import annotations

import os
from statistics import median
from typing import Any

from benchmarks import compare, inside, mpmkit_program, problem

PARTICLES = (1e4, 3e4, 1e5, 3e5, 1e6, 4e6)
PARTICLES_QUICK = (1e4, 3e4)
CASE = "apic3"


def main(quick: bool = False, only: tuple[str, ...] = ()) -> dict[str, Any]:
    """All parts, or those named in `only`: particles, threads, domain, apart."""
    inside.set_threads(1)
    parts = {"particles": particles, "threads": threads, "domain": domain, "apart": apart}
    return {name: part(quick) for name, part in parts.items() if not only or name in only}


def particles(quick: bool) -> list[dict[str, Any]]:
    """Nanoseconds per particle-step for cubes of different numbers of particles, interleaved."""
    sizes = [problem.cube(n) for n in (PARTICLES_QUICK if quick else PARTICLES)]
    steppers = [inside.stepper(mpmkit_program.compose(CASE, size)) for size in sizes]
    times: list[list[float]] = [[] for _ in sizes]
    for stepper, size in zip(steppers, sizes, strict=True):
        stepper.steps(3, size.dt)
    for _ in range(3 if quick else 7):
        for stepper, size, found in zip(steppers, sizes, times, strict=True):
            found.append(1e9 * stepper.steps(_count(size.particles), size.dt) / size.particles)
    rows = [{"particles": s.particles, "ns": [median(t), min(t), max(t)]} for s, t in zip(sizes, times, strict=True)]
    for row in rows:
        print(f"  {row['particles']:9,} particles: {row['ns'][0]:7.1f} ns per particle-step", flush=True)
    return rows


def _count(n: int) -> int:
    """Steps of a burst: about half a million particle-steps, and at least two."""
    return min(50, max(2, round(5e5 / n)))


def threads(quick: bool) -> list[dict[str, Any]]:
    """Speed with 1 to all cores, each in its own process, in turn; ratios to one thread of the same round."""
    cores = range(1, len(os.sched_getaffinity(0)) + 1)
    program = compare.commands({}, ("mpmkit",))[0]["mpmkit"]
    rows: dict[int, list[dict[str, Any]]] = {t: [] for t in cores}
    for _ in range(2 if quick else 5):
        for t in cores:
            rows[t].append(compare.run(program, CASE, "Q" if quick else "S", "f64", t, 1.0 if quick else 4.0))
    out = []
    for t in cores:
        ratios = [line["mps_med"] / one["mps_med"] for line, one in zip(rows[t], rows[1], strict=True)]
        out.append({"threads": t, "mps": median(line["mps_med"] for line in rows[t]), "ratio": [median(ratios), min(ratios), max(ratios)]})
        print(f"  {t} thread(s): {out[-1]['mps']:.2f} M/s, {out[-1]['ratio'][0]:.2f} x one", flush=True)
    return out


def domain(quick: bool) -> list[dict[str, Any]]:
    """The same block in domains of 1, 10 and 1000 times the volume; ratio of the times to the first."""
    size = problem.SIZES[3, "Q"] if quick else problem.SIZES[3, "S"]
    n = size.cells
    domains = {1: (n, n, n), 10: (10 * n, n, n), 1000: (10 * n, 10 * n, 10 * n)}
    steppers = {factor: inside.stepper(mpmkit_program.compose(CASE, size, domain=cells)) for factor, cells in domains.items()}
    return _beside("domain times", steppers, dict.fromkeys(steppers, size.dt), 3 if quick else 9)


def apart(quick: bool) -> list[dict[str, Any]]:
    """Two halves of a block: together, after they have flown many cells apart, and in flight at half a cell in each step."""
    side, dt = (12 if quick else 32), 1e-4
    together, away, flying = (inside.stepper(halves(side, dt)) for _ in range(3))
    for stepper in (away, flying):
        stepper.steps(20 if quick else 40, dt)  # that is 20 cells at the finer grid, and well within the domain
    # a thousandth of the time step: the particles stay where they are
    return _beside(
        "halves", {"together": together, "apart": away, "flying": flying}, {"together": 1e-3 * dt, "apart": 1e-3 * dt, "flying": dt}, 3
    )


def halves(side: int, dt: float) -> Any:
    """Two bodies of `side` cells in height, which move away from each other by half a cell in each step."""
    import mpmkit as mpm
    from mpmkit.integrators import FLIP, USL
    from mpmkit.materials import NeoHookean
    from mpmkit.shapes import QuadraticBSpline

    h = 1.0 / side
    grid = mpm.Grid((0.0, 0.0, 0.0), (8.0, 2.0, 2.0), h)
    sim = mpm.Simulation(grid, shape=QuadraticBSpline(), integrator=USL(FLIP(), limit=0.0, dt=dt))
    rubber = NeoHookean(E=problem.E, nu=problem.NU, rho=problem.RHO)
    for name, low, sign in (("left", 3.5, -1.0), ("right", 4.0, 1.0)):
        box = mpm.Box((low, 0.5, 0.5), (low + 0.5, 1.5, 1.5))
        sim += mpm.Body(box, rubber, v=(sign * 0.5 * h / dt, 0.0, 0.0), name=name)
    return sim


def _beside(name: str, steppers: dict[Any, inside.Stepper], dt: dict[Any, float], rounds: int) -> list[dict[str, Any]]:
    """Interleaved times of compositions, and their ratios to the first."""
    times: dict[Any, list[float]] = {key: [] for key in steppers}
    for key, stepper in steppers.items():
        stepper.steps(2, dt[key])
    for _ in range(rounds):
        for key, stepper in steppers.items():
            times[key].append(1e9 * stepper.steps(2, dt[key]) / stepper.particles)
    first = next(iter(steppers))
    rows = []
    for key, found in times.items():
        ratio = median(a / b for a, b in zip(found, times[first], strict=True))
        rows.append({name: key, "ns": median(found), "ratio": ratio})
        print(f"  {name} {key}: {median(found):.1f} ns per particle-step, {ratio:.3f} x", flush=True)
    return rows
