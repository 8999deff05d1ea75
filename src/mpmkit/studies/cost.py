"""Honest wall times: one run at a time, rounds over all runs to and fro, a reference run beside each; and predictions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import median
from typing import TYPE_CHECKING, Any, TypeVar

from mpmkit._core.composing import jit
from mpmkit.studies import child
from mpmkit.studies.plan import Run, grouped

if TYPE_CHECKING:
    from mpmkit.studies.study import Study

T = TypeVar("T")

REFERENCE: dict[str, Any] = {
    "grid": {"lower": [0.0, 0.0], "upper": [1.0, 1.0], "spacing": 0.05},
    "shape": {"kind": "QuadraticBSpline"},
    "integrator": {"kind": "MUSL", "transfer": {"kind": "FLIP"}, "dt": 1e-3},
    "bodies": [
        {
            "geometry": {"kind": "Box", "lower": [0.2, 0.2], "upper": [0.7, 0.7]},
            "material": {"kind": "NeoHookean", "E": 1000.0, "nu": 0.3, "rho": 1000.0},
            "v": [0.1, 0.05],
            "name": "block",
        }
    ],
}
"""The scene that is timed beside every run, the same in all studies: 400 particles that fly."""
REFERENCE_UNTIL = 1.0
"""A thousand steps."""
CALIBRATED = 20_000
"""Most particles of a run that is only tried out."""


def reference_job() -> dict[str, Any] | None:
    """The reference run as a job; None where steps are plain Python, whose times mean nothing."""
    if not jit.enabled():
        return None
    return {"task": "time", "data": REFERENCE, "folder": ".", "choices": {}, "until": REFERENCE_UNTIL, "threads": 1}


def to_and_fro(items: Sequence[T], rounds: int) -> Iterator[tuple[int, T]]:
    """Round by round over all items, every other round backwards: a machine that slows down steadily favours none."""
    for k in range(rounds):
        for item in items if k % 2 == 0 else reversed(items):
            yield k, item


def summary(times: list[dict[str, Any]], particles: int | None, steps: int | None) -> dict[str, Any]:
    """Median and spread of the wall times of one run, as keys of a row."""
    if not times:
        return {}
    seconds = [t["seconds"] for t in times]
    references = [t["reference"] for t in times if t.get("reference")]
    middle = median(seconds)
    return {
        "seconds": middle,
        "seconds_low": min(seconds),
        "seconds_high": max(seconds),
        "repeats": len(seconds),
        "ns_per_particle_step": 1e9 * middle / (particles * steps) if particles and steps else None,
        "reference_seconds": median(references) if references else None,
    }


def predict(study: Study, plan: list[Run], quiet: bool = True) -> list[dict[str, Any]]:
    """What each run will cost: steps times particles times what a particle-step of its composition takes on this machine.

    The coarsest run of each composition, and another one of up to `CALIBRATED` particles, step for a fraction of a second; a step takes
    a + b n. The number of steps is that of the first step's length.

    Returns
    -------
    list of dict
        For each run "label", "status", "reason", "particles", "steps", "seconds", "bytes".
    """
    from mpmkit.studies.progress import Progress

    groups = grouped(plan)
    models: dict[str, tuple[list[dict[str, Any]], Run]] = {}
    with Progress("calibrating", len(groups), quiet) as progress:
        for name, group in groups.items():
            small = [r for r in group if (r.particles or 0) <= CALIBRATED]
            tried = [group[0], *([small[-1]] if small and (small[-1].particles or 0) > 3 * (group[0].particles or 1) else [])]
            found = [child.run({**study.job(r), "task": "calibrate"}) for r in tried]
            if found[0]["status"] == "done":
                models[name] = ([f for f in found if f["status"] == "done"], tried[0])
            else:
                for r in group:
                    r.notes.append(f"not calibrated: {found[0]['status']}, {found[0]['reason']}".split("\n")[0])
            progress.advance(1.0, name)
    rows = []
    for run in plan:
        row: dict[str, Any] = {"label": run.label, "composition": run.composition, "status": run.status, "reason": run.reason}
        row |= {"particles": run.particles, "bytes": run.bytes, "steps": None, "seconds": None, "notes": run.notes}
        if run.planned and run.composition in models:
            row |= _cost(run, *models[run.composition])
        rows.append(row)
    return rows


def _cost(run: Run, found: list[dict[str, Any]], first: Run) -> dict[str, Any]:
    dt = run.dt or found[0]["dt"] * (run.h * run.cfl) / (first.h * first.cfl)
    steps = max(1, round((run.until or 0.0) / dt))
    n = run.particles or found[0]["particles"]
    small, large = found[0], found[-1]
    slope, start = large["seconds_per_step"] / large["particles"], 0.0
    if large["particles"] > small["particles"]:
        between = (large["seconds_per_step"] - small["seconds_per_step"]) / (large["particles"] - small["particles"])
        if between < slope:
            slope = max(between, 0.0)
            start = large["seconds_per_step"] - slope * large["particles"]
    return {"steps": steps, "seconds": steps * (start + slope * n)}
