"""One thread and several."""

from __future__ import annotations

import warnings

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure
from mpmkit.stability.cases._disks import GLANCING, disks
from mpmkit.stability.cases._tools import run

UNTIL = 3.0


def cores() -> int:
    """How many this process may use."""
    from mpmkit._core.running.workers import available

    return available()


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Two disks glance off each other, once with one thread and once with as many as there are cores."""
    h = 1 / 16 if quick else 1 / 32
    grid = mpm.Grid((-1.0, -1.0), (1.0, 1.0), h)
    one, many = run(disks(composition, grid, h, GLANCING), UNTIL), disks(composition, grid, h, GLANCING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        many.run(until=UNTIL, quiet=True, threads=min(8, cores()))
    a, b = one.particles(), many.particles()
    differ = sum(int((a[f] != b[f]).sum()) for f in a)
    rows = sum(int((np.asarray(one.history[c]) != many.history[c]).sum()) for c in one.history)
    return [Figure("numbers of particles that differ", differ, 0.0), Figure("numbers of the history that differ", rows, 0.0)]


CASE = Case(
    name="threads",
    title="Two disks glance off each other, with one thread and with all",
    failure="Sums in the order in which threads happen to finish differ by rounding, and after an impact by anything: no run can be "
    "repeated.",
    criterion="Every number of every particle and of the history is the same to the bit.",
    source="Same input, same result",
    dim=2,
    measure=measure,
    contact=True,
    applies=lambda composition: "" if cores() > 1 else "this process may use one core only",
)
