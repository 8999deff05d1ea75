"""Limits of compositions that were found by search, for the time step and for warnings; `mpmkit stability --limits` finds them anew."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import attrs

if TYPE_CHECKING:
    from mpmkit._core.composing.composition import Composition

PATH = Path(__file__).with_name("limits.json")
GENERAL = 1.0
"""Courant number above which no composition is run: waves and particles would pass a cell in a step. The bound of all whose own limit was
not searched.
"""
LENGTH_OF_STEP = ("cfl", "dt", "transfer", "strain")
"""Parameters of an integrator that are no part of what was searched: others set the step, the strain's form matters to second order."""
STRETCH = 1.25
"""Stretch up to which a body must stay whole to count as sampled finely enough."""
COURANT = 0.4
"""Courant number, the default of the integrators, at which it must vibrate without making energy."""
_SPACE = {"axisymmetric": "plane strain"}


@attrs.frozen
class Stable:
    """The largest stable Courant number of a composition: at most `GENERAL`.

    ``found`` is the limit that was found, None if none of those tried held or the composition was not searched; ``searched`` says which.
    """

    courant: float
    found: float | None = None
    fails: float | None = None
    searched: bool = False
    per_cell: str = ""
    flight: float | None = None


def signature(shape: Any, integrator: Any) -> dict[str, Any]:
    """What limits are kept under: classes of the components, and their parameters but those of the length of the step."""
    parts = {"shape": shape, "integrator": integrator, "transfer": getattr(integrator, "transfer", None)}
    return {role: _told(part) for role, part in parts.items()}


def _told(part: Any) -> Any:
    if part is None:
        return None
    cls = type(part)
    values = {a.name: getattr(part, a.name) for a in attrs.fields(cls) if a.name not in LENGTH_OF_STEP}
    return {"class": f"{cls.__module__.split('.')[0]}.{cls.__qualname__}", "parameters": values}


@cache
def _published() -> dict[str, dict[str, Any]]:
    rows = json.loads(PATH.read_text(encoding="utf-8"))["compositions"] if PATH.exists() else []
    return {_key(row): row for row in rows}


def _key(signed: dict[str, Any]) -> str:
    return json.dumps([signed[role] for role in ("shape", "integrator", "transfer")], sort_keys=True, default=repr)


def of(c: Composition) -> dict[str, Any] | None:
    """The published limits of a composition; None if it was not searched."""
    if c.shape is None or c.integrator is None or c.stored_operator:
        return None
    return _published().get(_key(signature(c.shape, c.integrator)))


def particles_per_cell(c: Composition) -> float:
    """Fewest particles per cell and direction in any body at the start."""
    import numpy as np

    from mpmkit.geometry import PointCloud

    fewest = np.inf
    for body in c.sim.bodies:
        if not isinstance(body.geometry, PointCloud):
            count = float(body.particles_per_cell or 2**c.dim)
        elif body.geometry.size is not None:
            count = float((np.asarray(c.grid.spacing) / (2.0 * body.geometry.size)).prod(axis=-1).min())
        else:
            continue  # of given volumes, in rings too, the sizes are not known before the body is sampled
        fewest = min(fewest, count)
    return float(fewest ** (1.0 / c.dim))


_KNOWN: WeakKeyDictionary[Composition, Stable] = WeakKeyDictionary()


def stable(c: Composition) -> Stable:
    """The largest stable Courant number, the worst for the particles per cell at the start and for more.

    With fewer particles than keep a body stable at all, which `warnings` tells, it is that of as many as do.
    """
    if c not in _KNOWN:
        _KNOWN[c] = _stable(c)
    return _KNOWN[c]


def _stable(c: Composition) -> Stable:
    row = of(c)
    if row is None:
        return Stable(GENERAL)
    space = _SPACE.get(c.grid.space, c.grid.space)
    fewest = max(particles_per_cell(c), needed(row, space) or 1)
    tables = [row["courant"].get(space) or row["courant"]["1D"]] + ([row["courant at a wall"]] if space == "1D" else [])
    pairs = [(n, pair) for table in tables for n, pair in _from(table, fewest) if isinstance(pair, list)]
    flights = [pair[0] for _, pair in _from(row["courant in flight"], fewest) if isinstance(pair, list) and pair[1] is not None]
    n, (holds, fails) = min(pairs, key=lambda one: one[1][0] or 0.0)
    flight = min((v or 0.0 for v in flights), default=None)
    return Stable(min(GENERAL, holds) if holds else GENERAL, holds, fails, True, n, flight)


def _from(table: dict[str, Any], fewest: float) -> list[tuple[str, Any]]:
    """Entries for as many particles per cell as the sparsest body has and for more; the last if it has more than were tried."""
    below = [n for n in table if int(n) <= fewest * (1.0 + 1e-9)]
    first = below[-1] if below else next(iter(table))
    return [(n, pair) for n, pair in table.items() if int(n) >= int(first)]


def needed(row: dict[str, Any], space: str) -> int | None:
    """Fewest particles per cell and direction that keep a body whole and stable; None if none of those tried did."""
    table = row["courant"].get(space) or row["courant"]["1D"]
    for n, pair in table.items():
        if isinstance(pair, list) and (row["stretch"][n][0] or 0.0) >= STRETCH and (pair[0] or 0.0) >= COURANT:
            return int(n)
    return None


def warnings(c: Composition) -> list[str]:
    """A cfl above the found limit; particles too few to keep a body whole."""
    row = of(c)
    if row is None or not c.sim.bodies:
        return []
    out, limit = [], stable(c)
    cfl = getattr(c.integrator, "cfl", None)
    if cfl is not None and getattr(c.integrator, "dt", None) is None and limit.found is not None and cfl > limit.found:
        out.append(
            f"cfl = {cfl:g} is above {limit.found:g}, the largest at which {row['label']} was found to be stable in {c.grid.space} with "
            f"{limit.per_cell} particle(s) per cell and direction: vibrations make energy. To fix: cfl={0.8 * limit.found:.2g} or less"
        )
    least, fewest = needed(row, _SPACE.get(c.grid.space, c.grid.space)), particles_per_cell(c)
    if least is not None and 1.0 <= fewest < least * (1.0 - 1e-9):  # particles larger than cells are told of where sizes are checked
        out.append(
            f"{fewest:.3g} particle(s) per cell and direction: {row['label']} was found to keep a body whole and stable with {least} or "
            f"more. To fix: particles_per_cell={least**c.dim} or more"
        )
    return out


def notes(c: Composition) -> list[str]:
    """What was found about the composition, for `explain`."""
    limit = stable(c)
    if not limit.searched:
        return []
    found = f"up to {limit.found:g}" if limit.found is not None else f"at none, {limit.fails:g} was the lowest tried"
    out = [f"found by search: stable at Courant numbers {found}, at rest with {limit.per_cell} particle(s) per cell and direction"]
    cfl = getattr(c.integrator, "cfl", None)
    if limit.flight is not None and cfl is not None and getattr(c.integrator, "dt", None) is None and cfl > limit.flight:
        out.append(
            f"found by search: while a body flies through many cells its vibrations make energy above cfl = {limit.flight:g} (5 % in 1000 "
            "steps at 0.1 c). To fix where that matters: a smaller cfl, USF, a smoother shape function, or an affine transfer"
        )
    return out
