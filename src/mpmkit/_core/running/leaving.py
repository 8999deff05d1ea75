"""Particles that leave the domain: the run stops, or they are taken out, or held at the face; what they carry is booked.

Nothing of this costs anything while all particles are inside: it begins with the flag that the loops raise. Only blocks with a particle
outside are looked through, by one thread and in the order of the buffer, so results do not depend on the number of threads.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.composing.module import LEDGER
from mpmkit._core.composing.sweep import IMPULSE, WORK
from mpmkit._core.composing.writer import ACCOUNTS
from mpmkit._core.running import guards
from mpmkit._core.running.blocks import BodyBlocks
from mpmkit._core.running.engine import FLAGS, GONE
from mpmkit._core.running.sort import Scratch, sort_body

if TYPE_CHECKING:
    from mpmkit._core.running.engine import Engine

OUTSIDE, ACCOUNT = FLAGS.index("inside"), ACCOUNTS.index("inside")
FRICTION = WORK.index("friction")
COLUMNS = ("step", "t", "id", "body", "m", "x", "y", "z", "vx", "vy", "vz")
"""Columns of the list of particles that were taken out; ``id`` and ``body`` are the numbers they have in frames."""

Row = dict[str, float]


def act(engine: Engine, leaving: str) -> list[Row]:
    """Deal with the particles that the last step has moved out of the domain.

    Parameters
    ----------
    engine : Engine
        After a step.
    leaving : str
        "stop" (nothing is done here, the guards stop the run), "remove" or "clamp". Particles that are not a number, or have been
        thrown out by more than a cell in one step, are left to the guards in any case.

    Returns
    -------
    list of dict
        For each particle that was taken out, its `COLUMNS`.
    """
    rows: list[Row] = []
    if leaving == "stop" or not engine.flags[:, OUTSIDE].any():
        return rows
    for k in np.flatnonzero(engine.flags[:, OUTSIDE]).tolist():
        if guards.jumped(engine, k):
            continue
        places = _outside(engine, k)
        store = engine.stores[k]
        if not places.size or not (np.isfinite(store.columns("x", places)).all() and np.isfinite(store.columns("v", places)).all()):
            continue
        if leaving == "remove":
            rows += _remove(engine, k, places)
        else:
            _clamp(engine, k, places)
        engine.ready = None  # what the nodes may already have got for the next step came from these particles too
        engine.flags[k] = [guards.wrong(engine, k, flag).any() and bool(engine.flags[k, j]) for j, flag in enumerate(FLAGS)]
    return rows


def _faces(engine: Engine) -> tuple[Any, Any]:
    """Lower and upper corner of the domain in the numbers that the loops compare with."""
    grid = engine.c.grid
    return np.asarray(grid.lower, engine.dtype), np.asarray(grid.upper, engine.dtype)


def _outside(engine: Engine, k: int) -> Any:
    """Places in the buffer of the particles of body k that are outside."""
    blocks, store = engine.places.blocks[k], engine.stores[k]
    marked = np.flatnonzero(engine.places.acc[k].reshape(-1, len(ACCOUNTS))[: blocks.count, ACCOUNT] > 0.0)
    spans = [np.arange(blocks.starts[b], blocks.starts[b + 1]) for b in marked.tolist()]
    near = np.concatenate(spans) if spans else np.zeros(0, dtype=np.int64)
    x = store.columns("x", near)
    low, high = _faces(engine)
    return near[~((x >= low) & (x <= high)).all(axis=1)]


def _remove(engine: Engine, k: int, places: Any) -> list[Row]:
    store, dim = engine.stores[k], engine.c.dim
    carried = _sums(engine, k, store.packed(places), len(places))
    gone = carried | {"energy": carried["kinetic"] + carried["stored"], "particles": float(len(places))}
    engine.gone += [gone[name] for name in GONE]
    order = np.argsort(store.ids[places])
    first = sum(s.begun for s in engine.stores[:k])
    x, v, m = (store.columns(name, places).astype(float) for name in ("x", "v", "m"))
    points = store.points_now()[store.ids[places]]
    rows = []
    for p in order.tolist():
        row = {"step": engine.step_number, "t": engine.t, "id": int(first + points[p]), "body": k, "m": float(m[p, 0])}
        row |= {a: float(x[p, j]) if j < dim else 0.0 for j, a in enumerate("xyz")}
        row |= {f"v{a}": float(v[p, j]) if j < dim else 0.0 for j, a in enumerate("xyz")}
        rows.append(row)
    store.remove(places)
    engine.places.changed(k)
    return rows


def _clamp(engine: Engine, k: int, places: Any) -> None:
    """Back to the face, without the velocity through it: as if the particle had hit a wall without a rebound."""
    store, dim = engine.stores[k], engine.c.dim
    before = _sums(engine, k, store.packed(places), len(places))
    low, high = _faces(engine)
    x, v = store.columns("x", places), store.columns("v", places)
    through = ((x < low) & (v < 0.0)) | ((x > high) & (v > 0.0))
    eps = np.finfo(engine.dtype).eps
    # not onto the face itself: its nodes interpolate, and moments about a particle on a node vanish
    inside = np.maximum(np.sqrt(eps) * np.asarray(engine.c.grid.spacing), 8.0 * eps * np.maximum(np.abs(low), np.abs(high)))
    inside = inside.astype(engine.dtype)
    store.set_columns("x", places, np.clip(x, low + inside, high - inside))
    store.set_columns("v", places, np.where(through, v.dtype.type(0.0), v))
    if "C" in store.layout.fields:  # rows of the velocity's gradient; of the plane four numbers are stored
        stored = store.layout.stored("C")
        C = store.columns("C", places)
        for j, full in enumerate(stored):
            if full // 3 < dim:
                C[through[:, full // 3], j] = 0.0
        store.set_columns("C", places, C)
    after = _sums(engine, k, store.packed(places), len(places))
    engine.work[FRICTION] += before["kinetic"] - after["kinetic"]
    for j, a in enumerate("xyz"):
        engine.work[IMPULSE + j] += after[f"momentum_{a}"] - before[f"momentum_{a}"]


class _Cut:
    """Some particles of a body by themselves, as sorting asks for them."""

    def __init__(self, P: Any, n: int, layout: Any) -> None:
        self.P, self.n, self.layout = P, n, layout


def _sums(engine: Engine, k: int, P: Any, n: int) -> dict[str, float]:
    """Mass, momentum and energies by the body's own loop for the ledger; for its weights particles outside are put on the face."""
    store, lattice = engine.stores[k], engine.places.lattice
    dim = engine.c.dim
    start = store.layout.start["x"]
    x = P.reshape(-1, store.layout.size, 16)[:, start : start + dim, :]
    low, high = _faces(engine)
    np.clip(x, low[None, :, None], high[None, :, None], out=x)
    blocks = BodyBlocks(lattice)
    sort_body(engine.module, _Cut(P, n, store.layout), lattice, blocks, Scratch())
    acc, home = np.zeros(blocks.count * len(LEDGER)), np.zeros(blocks.count * 3**dim, dtype=np.int32)
    corner = (blocks.coords * lattice.B - 1).reshape(-1)
    zero = engine.dtype(0.0)
    arguments = (P, blocks.starts, corner, home, blocks.edge, engine.field_of(k).G, engine.body_par[k], acc)
    getattr(engine.module, f"ledger_{store.group.name}")(0, blocks.count, *arguments, *engine.scratch[0], zero, zero)
    sums = acc.reshape(-1, len(LEDGER)).sum(axis=0)
    return dict(zip(LEDGER, sums.tolist(), strict=True))
