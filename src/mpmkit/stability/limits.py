"""Limits of the main compositions, found by search: one small scene and one criterion for each, and what they are published as."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import attrs

from mpmkit._core.composing.limits import COURANT, PATH, STRETCH, needed, signature
from mpmkit.errors import MpmkitError
from mpmkit.stability import lattice_theory
from mpmkit.stability.case import Composition
from mpmkit.stability.limit_scenes import OFFSETS, Vibration, meeting, separation
from mpmkit.stability.search import Bracket, first_failure, ladder

CREATED = 0.05
"""Energy made, relative to that of the start, at which a vibration has failed."""
FLIGHT = 0.1
"""Speed of flight [c] through cells."""
SPACES = {"1D": 1, "plane strain": 2, "3D": 3}
PER_CELL = {"1D": (1, 2, 3, 4), "plane strain": (1, 2, 3), "3D": (1, 2)}
STEPS = {"1D": 1000, "plane strain": 400, "3D": 300}
HIGHEST = {"courant": 4.0, "stretch": 4.0, "cells": 3.0, "ratio": 1e5}
HOW = {
    "courant": "Largest dt (c + |v|) / h at which free elastic blocks (8, 5 x 5, 3 x 3 x 3 cells) at 8 places between the nodes vibrate in "
    "their lowest mode with noise of 1e-6 of its energy and none makes 5 % energy (1000, 400, 300 steps in 1, 2, 3 dimensions).",
    "courant at a wall": "The same in one dimension, the first block held by a wall.",
    "courant in flight": "The same in one dimension while the blocks fly at 0.1 c through the cells, 1000 steps.",
    "courant by theory": "Largest dt c / h at which no eigenvalue of the step's matrix, for the same blocks in one dimension with weights "
    "that do not change, is above 1.001.",
    "stretch": "Stretch at which a bar drawn out by a uniform velocity gradient comes apart: a stress in its middle third is half wrong; "
    "the least of four places between the nodes.",
    "cells per step": "Largest |v| dt / h at which blocks fly with c dt / h = 0.1 for 200 steps and make no 5 % energy.",
    "stiffness": "Largest ratio of Young's moduli of two bars that meet at 0.1 c, in one dimension at cfl = 0.4: energy made below 5 %, "
    "never half a cell into each other.",
    "density": "The same for the ratio of densities.",
    "particles per cell": f"Lowest number per direction with which a bar stays whole up to a stretch of {STRETCH:g} and vibrates at cfl = "
    f"{COURANT:g} in one dimension without making 5 % energy.",
}
"""What each limit means and how it was found."""


def main_compositions() -> list[Composition]:
    """The compositions whose limits are published: the default, others that differ from it in one choice, and every shape function with
    strains that are not mapped again, whose limits are lower than those of others.
    """
    from mpmkit.stability.compositions import registered
    from mpmkit.stability.facts import strains_last_unmapped

    a = registered()
    out = [a.one()]
    out += [a.one(shape=shape) for shape in a.shapes[1:]]
    out += [a.one(integrator=integrator) for integrator in a.integrators[1:]]
    out += [a.one(transfer=transfer) for transfer in a.transfers[1:]]
    out += [a.one(shape, integrator) for integrator in a.integrators[1:] if strains_last_unmapped(integrator) for shape in a.shapes[1:]]
    return [one for one in out if one.precision == "float64"]


def find_limits(
    compositions: Sequence[Composition] | None = None,
    quick: bool = False,
    say: Callable[[str], None] = lambda text: None,
    *,
    jobs: int = 1,
) -> dict[str, Any]:
    """Search the limits of compositions.

    Parameters
    ----------
    compositions : list of Composition, optional
        `main_compositions` if not given.
    quick : bool
        In one dimension only, with 1 and 2 particles per cell.
    say : callable
        Told what is being searched, a line at a time.
    jobs : int
        Child processes; with 1 everything is done in this one.

    Returns
    -------
    dict
        Plain data, as it is published: how each limit was found, with what versions, and for each composition its limits. A limit is a
        pair of the largest value that held and the smallest that failed; None in place of the first if nothing held, in place of the
        second if nothing failed.
    """
    import numba
    import numpy as np

    import mpmkit

    chosen = main_compositions() if compositions is None else list(compositions)
    found: list[dict[str, Any]] = []
    with ExitStack() as stack:
        if jobs > 1:
            pool = stack.enter_context(ProcessPoolExecutor(jobs, mp_context=get_context("spawn")))
            searched: Iterable[dict[str, Any]] = pool.map(_search, chosen, [quick] * len(chosen))
        else:
            searched = (_search(one, quick, say) for one in chosen)
        for one in searched:
            found.append(one)
            say(f"{len(found)}/{len(chosen)} {one['label']}")
    return {
        "about": "Limits of compositions found by search; made by `mpmkit stability --limits`.",
        "found with": {
            "mpmkit": mpmkit.__version__,
            "numpy": np.__version__,
            "numba": numba.__version__,
            "python": platform.python_version(),
            "precision": "float64",
        },
        "how": HOW | {"searched up to": HIGHEST},
        "quick": quick,
        "compositions": found,
    }


def _search(one: Composition, quick: bool, say: Callable[[str], None] = lambda text: None) -> dict[str, Any]:
    spaces = ("1D",) if quick else tuple(s for s in SPACES if s in one.shape.spaces)
    counts = {space: PER_CELL[space][:2] if quick else PER_CELL[space] for space in spaces}
    alone = attrs.evolve(one, contact=None)
    out: dict[str, Any] = {"label": alone.label, **signature(one.shape, one.integrator), "courant": {}}
    say(alone.label)

    def each(name: str, numbers: Sequence[int], search: Callable[[int], list[float | None]]) -> dict[str, Any]:
        say(f"    {name}")
        return {str(n): _tried(lambda n=n: search(n)) for n in numbers}  # type: ignore[misc]

    for space in spaces:
        out["courant"][space] = each(f"courant, {space}", counts[space], lambda n, s=space: courant(alone, s, n))  # type: ignore[misc]
    line = counts["1D"]
    out["courant at a wall"] = each("courant at a wall", line, lambda n: courant(alone, "1D", n, held=True))
    out["courant in flight"] = each("courant in flight", line, lambda n: courant(alone, "1D", n, flight=FLIGHT))
    if lattice_theory.known(alone):
        out["courant by theory"] = {str(n): _least([lattice_theory.stable_courant(alone, n, shift) for shift in OFFSETS]) for n in line}
    out["stretch"] = each("stretch", line, lambda n: _stretch(alone, n))
    out["cells per step"] = each("cells per step", line[:2], lambda n: cells_per_step(alone, n))
    out["particles per cell"] = needed(out, "1D")
    for name, ratio in (("stiffness", lambda r: (r, 1.0)), ("density", lambda r: (1.0, r))):
        out[name] = {}
        for place, composition in (("contact", one), ("one field", alone)):
            if composition.contact is None and place == "contact":
                continue
            say(f"    {name}, {place}")
            out[name][place] = _tried(lambda c=composition, r=ratio: _pair(first_failure(lambda x: meeting(c, *r(x)), _ratios(), 0.5)))  # type: ignore[misc]
    return out


def courant(one: Composition, space: str, per_cell: int, *, held: bool = False, flight: float = 0.0) -> list[float | None]:
    """Largest stable Courant number, and the smallest that is not."""
    blocks = Vibration(one, SPACES[space], per_cell, flight=flight, held=held, steps=STEPS[space])
    steps = ladder(0.05, 1.0, 11) if flight else ladder(0.1, HIGHEST["courant"], 13)
    return _pair(first_failure(lambda c: blocks.created(c) < CREATED, steps))


def cells_per_step(one: Composition, per_cell: int) -> list[float | None]:
    """Largest distance of flight in a step [cells], and the smallest at which energy is made."""

    def holds(cells: float) -> bool:
        flight = cells / 0.1
        return Vibration(one, 1, per_cell, flight=flight, steps=200, reach=cells + 0.1).created(cells + 0.1) < CREATED

    return _pair(first_failure(holds, ladder(0.05, HIGHEST["cells"], 12), 0.05))


def _stretch(one: Composition, per_cell: int) -> list[float | None]:
    at = separation(one, per_cell, HIGHEST["stretch"])
    return [HIGHEST["stretch"], None] if at is None else [round(at, 2), round(at, 2)]


def _ratios() -> list[float]:
    return [10.0**k for k in range(round(math.log10(HIGHEST["ratio"])) + 1)]


def _tried(search: Callable[[], list[float | None]]) -> Any:
    """What a search finds; if the composition is refused for the scene, why."""
    try:
        return search()
    except MpmkitError as error:
        return str(error).split("\n")[0]


def _pair(found: Bracket) -> list[float | None]:
    return [None if value is None else float(f"{value:.3g}") for value in (found.holds, found.fails)]


def _least(values: Sequence[float | None]) -> float | None:
    return None if None in values else round(min(v for v in values if v is not None), 2)


def write(data: dict[str, Any], path: Path = PATH) -> Path:
    """Publish: the file that the time step and `explain` read."""
    path.write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return path


def read(path: Path = PATH) -> dict[str, Any]:
    """What is published."""
    return json.loads(path.read_text(encoding="utf-8"))  # type: ignore[no-any-return]


# --- as a table -------------------------------------------------------------------------------------------------
def table(data: dict[str, Any]) -> str:
    """The limits as Markdown, with how they were found and the theory beside the Courant numbers."""
    made = data["found with"]
    rows = data["compositions"]
    spaces = [s for s in SPACES if any(s in row["courant"] for row in rows)]
    head = ["composition", *[f"{s}, at rest" for s in spaces], "1D theory", "1D at a wall", "1D in flight at 0.1 c", "cells per step"]
    first = [
        [
            row["label"],
            *[_by_count(row["courant"].get(space)) for space in spaces],
            _by_count({n: [v, v] for n, v in row.get("courant by theory", {}).items()}),
            _by_count(row["courant at a wall"]),
            _by_count(row["courant in flight"]),
            _by_count(row["cells per step"]),
        ]
        for row in rows
    ]
    second = [
        [
            row["label"],
            _by_count(row["stretch"]),
            str(row["particles per cell"] or "more than tried"),
            *[_one(row[name].get(place)) for name in ("stiffness", "density") for place in ("contact", "one field")],
        ]
        for row in rows
    ]
    ratios = [f"{name} ratio, {place}" for name in ("stiffness", "density") for place in ("contact", "one field")]
    lines = [
        "## Largest stable Courant number",
        "",
        f"The largest value that held for 1 / 2 / 3 / 4 particles per cell and direction, found with mpmkit {made['mpmkit']} in "
        f"{made['precision']} to 2 %; `>` where nothing failed up to the largest value tried.",
        "",
        *_grid(head, first),
        "",
        "## Stretch, sampling and contact",
        "",
        *_grid(["composition", "stretch at separation", "lowest particles per cell and direction", *ratios], second),
        "",
        "## How they were found",
        "",
        *[f"- **{name}**: {text}" for name, text in data["how"].items() if isinstance(text, str)],
        "",
    ]
    return "\n".join(lines)


def _grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]


def _by_count(found: dict[str, Any] | None) -> str:
    return " / ".join(map(_one, found.values())) if found else "–"


def _one(found: Any) -> str:
    if found is None:
        return "–"
    if isinstance(found, str):
        return "refused"
    holds, fails = found
    if holds is None:
        return "none" if fails is None else f"< {fails:.2g}"
    return f"> {holds:.3g}" if fails is None else f"{holds:.3g}"
