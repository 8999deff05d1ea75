"""What kind of problem a scene is, and how much two problems have in common."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from mpmkit.errors import MpmkitError
from mpmkit.studies.paths import table_of

CROSSING = 0.5
"""Cells that particles move, from which on they cross."""
WEIGHTS = {"space": 3.0, "cells": 2.5, "materials": 1.5, "contact": 1.5, "start": 1.0, "loads": 1.5}
"""What counts how much when problems are compared."""


def describe(sim: Any) -> dict[str, Any]:
    """Facts of a simulation that decide on which errors it will have, as plain data."""
    return {
        "space": sim.grid.space,
        "dim": sim.grid.dim,
        "length": length(sim),
        "materials": sorted({family(body.material) for body in sim.bodies}),
        "contact": len(sim.contacts) > 0 or len(sim.bodies) > 1,
        "moves at the start": any(_moves(body.v) for body in sim.bodies),
        "loads": sorted({type(part).__name__ for part in (*sim.boundaries, *sim.effects)}),
    }


def family(material: Any) -> str:
    """What a material does with work: "elastic" gives it back, "plastic" and "viscous" do not."""
    if getattr(material, "yield_function", None) is not None:
        return "plastic"
    return "viscous" if getattr(material, "diffusivity", None) is not None else "elastic"


def length(sim: Any) -> float:
    """Longest side of the largest body [m]; resolutions are compared by how many cells it has."""
    sides = []
    for body in sim.bodies:
        lower, upper = body.geometry.bounds()
        for lo, up, first, last in zip(lower, upper, sim.grid.lower, sim.grid.upper, strict=False):
            sides.append(min(up, last) - max(lo, first))
    found = max((s for s in sides if math.isfinite(s)), default=0.0)
    return found if found > 0.0 else max(u - lo for u, lo in zip(sim.grid.upper, sim.grid.lower, strict=True))


def _moves(v: Any) -> bool:
    if callable(v):
        return True
    if hasattr(v, "any"):
        return bool(v.any())
    numbers = v if isinstance(v, (tuple, list)) else [v]
    return any(not isinstance(x, (int, float)) or x != 0.0 for x in numbers)


def components(sim: Any) -> dict[str, Any] | None:
    """The choices that studies compare, as paths into a scene with plain values; None if they cannot be written."""
    try:
        if sim.discretization is not None:
            return {"discretization": table_of(sim.discretization)}
        found = {"shape": table_of(sim.shape), "integrator": type(sim.integrator).__name__}
        transfer = getattr(sim.integrator, "transfer", None)
        if transfer is not None:
            found["integrator.transfer"] = table_of(transfer)
    except MpmkitError:
        return None
    counts = {body.particles_per_cell for body in sim.bodies}
    if len(counts) == 1 and isinstance(count := counts.pop(), int):
        found["bodies.*.particles_per_cell"] = count
    return found


def same_components(a: Mapping[str, Any], b: Mapping[str, Any]) -> bool:
    """Whether two choices are the same, as far as both say."""
    shared = set(a) & set(b)
    need = {"shape", "integrator"} if "shape" in a or "shape" in b else {"discretization"}
    return need <= shared and all(key(a[k]) == key(b[k]) for k in shared)


def key(value: Any) -> str:
    """Text that is the same for equal plain values."""
    return json.dumps(value, sort_keys=True, default=str)


def alike(a: Mapping[str, Any], b: Mapping[str, Any], travel_a: float | None, travel_b: float | None) -> tuple[float, list[str], list[str]]:
    """How much two problems have in common, from 0 to 1, with what is the same and what differs.

    Parameters
    ----------
    a, b : mapping
        As from `describe`: the scene that advice is wanted for, and one of a study.
    travel_a, travel_b : float, optional
        How many cells particles move in each.
    """
    parts: dict[str, tuple[float, str]] = {}
    equal = a["space"] == b["space"]
    parts["space"] = (1.0 if equal else 0.6 if a["dim"] == b["dim"] else 0.0, a["space"] if equal else f"{b['space']}, not {a['space']}")
    if travel_a is None or travel_b is None:
        parts["cells"] = (0.5, "nobody knows whether particles cross cells")
    else:
        crossing = [t >= CROSSING for t in (travel_a, travel_b)]
        mine, its = ("particles cross cells" if c else "particles stay in their cells" for c in crossing)
        parts["cells"] = (
            (1.0, mine) if mine == its else (0.0, f"{its} there, but not here" if crossing[1] else f"{its} there, but cross them here")
        )
    materials = set(a["materials"]) == set(b["materials"])
    parts["materials"] = (float(materials), _told(a["materials"]) if materials else f"{_told(b['materials'])}, not {_told(a['materials'])}")
    contact = a["contact"] == b["contact"]
    words = {True: "several bodies", False: "one body"}
    parts["contact"] = (float(contact), words[a["contact"]] if contact else f"{words[b['contact']]}, not {words[a['contact']]}")
    start = a["moves at the start"] == b["moves at the start"]
    words = {True: "moves at the start", False: "starts at rest"}
    parts["start"] = (float(start), words[a["moves at the start"]] if start else f"{words[b['moves at the start']]} there")
    ours, others = set(a["loads"]), set(b["loads"])
    share = len(ours & others) / len(ours | others) if ours | others else 1.0
    told = f"loaded by {', '.join(sorted(others)) or 'nothing'}" + ("" if share == 1.0 else f", not {', '.join(sorted(ours)) or 'nothing'}")
    parts["loads"] = (share, told)
    score = sum(WEIGHTS[name] * value for name, (value, _) in parts.items()) / sum(WEIGHTS.values())
    return score, [t for v, t in parts.values() if v == 1.0], [t for v, t in parts.values() if v < 1.0]


def _told(families: list[str]) -> str:
    return f"{' and '.join(families)} material"
