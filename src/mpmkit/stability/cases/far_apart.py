"""A body alone in a small domain, and the same in a huge one with another body far away."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import fixed, rounding, run, step
from mpmkit.stability.cases._tubes import WAVE, rubber

SIDE, NEAR, FAR = 4.0, 12, 1600  # cells


def block(composition: Composition, cells: int, others: bool) -> mpm.Simulation:
    """A block that shears and swells, in a domain of so many cells on a side; with `others`, blocks in two corners far away."""
    sim = simulation(fixed(composition, step(composition, 1.0, 2.0 * WAVE)), mpm.Grid((0.0, 0.0), (cells, cells), 1.0))
    v = (f"{0.2 * WAVE} * (y - 6) / 2", f"{0.1 * WAVE} * (y - 5)")
    sim += mpm.Body(mpm.Box((4.0, 4.0), (4.0 + SIDE, 4.0 + SIDE)), rubber(), v=v, name="block")
    if others:
        for k, corner in enumerate(((cells - 8.0, cells - 8.0), (cells - 8.0, 4.0))):
            box = mpm.Box(corner, (corner[0] + SIDE, corner[1] + SIDE))
            sim += mpm.Body(box, rubber(), v=(0.1 * WAVE, 0.0), name=f"far{k}")
    return sim


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Difference of all fields of the block."""
    cells, until = (NEAR * 20, 4.0 / WAVE) if quick else (FAR, 20.0 / WAVE)
    alone = run(block(composition, NEAR, False), until).particles("block")
    among = run(block(composition, cells, True), until).particles("block")
    scales = {"x": 1.0, "v": WAVE, "F": 1.0, "stress": float(np.abs(alone["stress"]).max())}
    return [
        Figure(f"{f}, difference", float(np.abs(among[f] - alone[f]).max() / scale), rounding(composition, 1e-12))
        for f, scale in scales.items()
    ]


CASE = Case(
    name="far-apart",
    title="A block alone in a small domain, and in a huge one with others far away",
    failure="A sparse grid that mixes up its blocks lets bodies feel each other that are a thousand cells apart; one that depends on the "
    "domain gives another result in another box.",
    criterion="All fields of the block equal to 1e-12, in a domain of 12 x 12 cells alone and of 1600 x 1600 with others in its corners.",
    source="Locality of the equations; a pull request of matter in which a sparse grid failed the tests of the dense one",
    dim=2,
    measure=measure,
)
