"""Time of a step with a component over that without it, in one interleaved run: effects, boundary layers, contact touching and apart."""

from __future__ import annotations

from dataclasses import replace
from statistics import median
from typing import Any

from benchmarks import inside, variants

SIDE, SIDE_QUICK = 24, 10
"""Cells along the cube, as in `components`."""
AGAIN = "the same again"
"""A second copy of the base: what the ratio of equal steps is on this machine, and how far it scatters."""


def main(quick: bool = False, only: tuple[str, ...] = ()) -> dict[str, Any]:
    """Measure all pairs, or those whose component is in `only`."""
    inside.set_threads(1)
    side, rounds, count = (SIDE_QUICK, 3, 2) if quick else (SIDE, 15, 3)
    chosen = [v for v in pairs() if not only or v.name in only]
    known = {v.name: v for v in variants.variants()}
    particles, rows = 0, []
    for v in chosen:  # two copies at a time: the ratio of neighbours is what counts
        with_it, without = (inside.stepper(variants.compose(one, side)) for one in (v, known[v.base]))
        for stepper in (with_it, without):
            stepper.steps(3, variants.DT)
        times: list[tuple[float, float]] = []
        for r in range(rounds):
            first, second = (with_it, without) if r % 2 else (without, with_it)
            one, other = first.steps(count, variants.DT), second.steps(count, variants.DT)
            times.append((one, other) if r % 2 else (other, one))
        rows.append(_row(v, with_it, without, times))
        particles = particles or without.particles
        print(f"  {v.name:36} {rows[-1]['ratio'][0]:6.3f} x ({rows[-1]['ratio'][1]:.3f} to {rows[-1]['ratio'][2]:.3f})", flush=True)
    return {"particles": particles, "rounds": rounds, "rows": rows}


def pairs() -> list[variants.Variant]:
    """Variants with one optional component more than their base."""
    from mpmkit import boundaries

    found = {v.name: v for v in variants.variants()}
    layers = {
        "Wall, nothing near": boundaries.Wall("all"),
        "Wall, across the block": boundaries.Wall("all", "no slip"),
        "TractionLayer": boundaries.TractionLayer("part0", (1.0, 0.0, 0.0), "xmin"),
    }
    out = [replace(found["base"], name=AGAIN)]
    out += [v for v in found.values() if v.parts]
    out += [replace(found["base"], name=name, group="boundary", parts=(layer,)) for name, layer in layers.items()]
    return out


def _row(v: variants.Variant, with_it: inside.Stepper, without: inside.Stepper, times: list[tuple[float, float]]) -> dict[str, Any]:
    ratios = [a / b for a, b in times]
    fields, more = without.field_numbers(), with_it.field_numbers()
    return {
        "name": v.name,
        "group": v.group,
        "base": v.base,
        "ns": 1e9 * median(a for a, _ in times) / with_it.particles,
        "ratio": [median(ratios), min(ratios), max(ratios)],
        "fields": [name for name in more if name not in fields],
        "node numbers": with_it.node_numbers() - without.node_numbers(),
    }
