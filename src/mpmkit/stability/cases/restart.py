"""A run that is stopped and goes on from its checkpoint."""

from __future__ import annotations

import tempfile
from pathlib import Path

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure
from mpmkit.stability.cases._disks import GLANCING, SPEED, WAVE, disks
from mpmkit.stability.cases._tools import run, step

FRAMES = 0.5


def scene(composition: Composition, h: float, folder: str, name: str) -> mpm.Simulation:
    """Two disks that glance off each other, recorded."""
    sim = disks(composition, mpm.Grid((-1.0, -1.0), (1.0, 1.0), h), h, GLANCING)
    sim += mpm.Record(str(Path(folder) / f"{name}.vtkhdf"), every=FRAMES, history=1)
    return sim


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Stopped after the first step, one step before a frame, after a sort, and in the impact; each time in a new simulation."""
    h, until = (1 / 16, 2.0) if quick else (1 / 32, 3.0)
    dt = step(composition, h, WAVE + SPEED)
    sorted_at = int(h / (SPEED * dt)) + 2  # somebody has moved by a cell
    stops = [dt, (int(FRAMES / dt) - 1) * dt, max(sorted_at, 3) * dt, 0.9 * until]
    with tempfile.TemporaryDirectory() as folder:
        whole, parts = scene(composition, h, folder, "whole"), scene(composition, h, folder, "parts")
        for stop in [*sorted(stops), until]:
            run(whole, stop)
            run(parts, stop)
            if stop < until:
                parts = scene(composition, h, folder, "parts")
                parts.resume(str(Path(folder) / "parts.ckpt.h5"))
        a, b = whole.particles(), parts.particles()
        differ = sum(int((a[f] != b[f]).sum()) for f in a)
        rows = sum(
            int((whole.history[c] != parts.history[c]).sum()) for c in whole.history if len(whole.history[c]) == len(parts.history[c])
        )
        frames = [len(mpm.Results(str(Path(folder) / f"{name}.vtkhdf")).times) for name in ("whole", "parts")]
    return [
        Figure("numbers of particles that differ", differ, 0.0),
        Figure("numbers of the history that differ", rows, 0.0),
        Figure("frames missing or too many", float(frames[0] - frames[1]), 0.0),
    ]


CASE = Case(
    name="restart",
    title="Two disks glance off each other; the run is stopped four times and goes on from its checkpoint",
    failure="What is not in a checkpoint is made anew: the order of particles, works so far, the time of the next frame. The run goes on, "
    "a little differently.",
    criterion="Stopped after the first step, one step before a frame, after particles were sorted, and during the impact: every number "
    "of every "
    "particle and of the history the same to the bit as of a run that only paused there; no frame missing or twice.",
    source="Same input, same result",
    dim=2,
    measure=measure,
    contact=True,
)
