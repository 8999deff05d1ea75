"""Phases of a step bound to their arrays: each becomes a function of time and time step."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.composing.schedule import Phase

if TYPE_CHECKING:
    from mpmkit._core.running.engine import Engine
    from mpmkit._core.running.held import Held

Step = Callable[[Any, Any], None]


def over_particles(e: Engine, k: int, name: str, acc: Any, *only: Any) -> Step:
    """A loop over the blocks of body k, on all threads; blocks that add to the same nodes are never at work together.

    `only` marks the blocks that are visited, for a loop that asks for it.
    """
    return _over_blocks(e, k, f"{name}_{e.stores[k].group.name}", (*e.particle_arguments(k, acc), *only))


def joined(e: Engine, k: int) -> Step:
    """The last loop of a step over the particles of body k, and the first of the next."""
    P, starts, corner, home, edge, G, par, acc = e.particle_arguments(k, e.places.acc[k])
    return _over_blocks(e, k, f"cycle_{e.stores[k].group.name}", (P, starts, corner, home, edge, G, e.field_of(k).H, par, acc))


def _over_blocks(e: Engine, k: int, name: str, arguments: tuple[Any, ...]) -> Step:
    function, team, blocks, scratch = getattr(e.module, name), e.team, e.places.blocks[k], e.scratch
    if team.size == 1:

        def alone(t: Any, dt: Any) -> None:
            function(0, blocks.count, *arguments, *scratch[0], t, dt)

        return alone
    turns = blocks.chunks(team.size) if name in e.plan.scatters else [blocks.ranges(team.size)]

    def together(t: Any, dt: Any) -> None:
        def work(thread: int, part: tuple[int, int]) -> None:
            function(*part, *arguments, *scratch[thread], t, dt)

        for turn in turns:
            team.run(work, turn)

    return together


def over_nodes(e: Engine, k: int, phase: Phase) -> Step:
    """A loop over the blocks of nodes of a field."""
    field, function = e.fields[k], getattr(e.module, phase.name)
    more = (e.dtype(phase.number),) if phase.name.startswith("filter") else ()
    arguments = (field.G, field.n_nodes, where(e, field), *more, e.field_par[k], e.node_work[k])
    ranges = parts(field.active, e.team.size)

    def run(t: Any, dt: Any) -> None:
        e.team.run(lambda thread, part: function(*part, *arguments, t, dt), ranges)

    return run


def clear(e: Engine, field: Any, G: Any) -> Callable[[], None]:
    """All channels of all stored nodes to zero."""
    function, size, ranges = e.module.clear_nodes, field.lattice.nodes_per_block * e.channels, parts(field.active, e.team.size)
    return lambda: e.team.run(lambda thread, part: function(*part, G, size), ranges)


def where(e: Engine, field: Any) -> Any:
    """For each stored block the number of its first node in the grid, along each axis; of a mesh the positions of its nodes."""
    if e.c.stored_operator:
        return field.where
    lattice = field.lattice
    return field.blocks[:, : lattice.dim] * lattice.B - lattice.ghosts


def parts(count: int, threads: int) -> list[tuple[int, int]]:
    """Ranges of `count` blocks or tiles for the threads to take."""
    if threads == 1:
        return [(0, count)]
    step = max(8, -(-count // (4 * threads)))
    return [(a, min(a + step, count)) for a in range(0, count, step)]


def face_nodes(e: Engine, field: Any, faces: tuple[str, ...]) -> tuple[Any, Any]:
    """Numbers and outward normals of the nodes on faces; a node on two faces is listed twice."""
    numbers: list[Any] = [np.zeros(0, dtype=np.int64)]
    normals: list[Any] = [np.zeros((0, 3), dtype=e.dtype)]
    for face in faces:
        axis, upper = "xyz".index(face[0]), face.endswith("max")
        if e.c.stored_operator:
            wall = e.c.grid.upper[axis] if upper else e.c.grid.lower[axis]
            on = np.flatnonzero(np.abs(field.where[:, axis] - wall) < 1e-6 * e.c.grid.spacing[axis])
        else:
            on = field.face_nodes(axis, upper)
        n: Any = np.zeros((on.size, 3), dtype=e.dtype)
        n[:, axis] = 1.0 if upper else -1.0
        numbers.append(on.astype(np.int64))
        normals.append(n)
    return np.concatenate(numbers), np.concatenate(normals)


def boundary(e: Engine, phase: Phase) -> list[Step]:
    """A boundary layer on its nodes: on faces, in a region, or in a region that moves."""
    layer, function = e.c.layers[phase.role], getattr(e.module, phase.name)
    steps: list[Step] = []
    for k, field in enumerate(e.fields):
        tail = ((e.dtype(phase.number),) if phase.channel in ("u", "v_smooth") else ()) + (where(e, field), e.node_par, e.work)
        memory = e.held.get((phase.role, k)) if phase.channel in ("v", "v_old") else None

        def remembered(listed: tuple[Any, Any], field: Any = field, memory: Held | None = memory) -> tuple[Any, ...]:
            return listed if memory is None else (*listed, memory.of(field.identities(listed[0]), listed[1]))

        faces = layer.faces_of(e.c.grid)
        if faces:
            steps.append(_on_nodes(function, (field.G, *remembered(face_nodes(e, field, faces)), *tail)))
        elif getattr(layer, "moving", None) is None:
            steps.append(_on_nodes(function, (field.G, *remembered(_in_region(e, layer, field.positions(), e.t)), *tail)))
        else:
            steps.append(_on_moving(e, layer, function, field, remembered, tail))
    return steps


def _in_region(e: Engine, layer: Any, x: Any, t: float) -> tuple[Any, Any]:
    numbers = np.flatnonzero(layer.nodes_in(x, t)).astype(np.int64)
    return numbers, np.zeros((numbers.size, 3), dtype=e.dtype)


def _on_nodes(function: Callable[..., None], arguments: tuple[Any, ...]) -> Step:
    return lambda t, dt: function(*arguments, t, dt)


def _on_moving(
    e: Engine,
    layer: Any,
    function: Callable[..., None],
    field: Any,
    remembered: Callable[[tuple[Any, Any]], tuple[Any, ...]],
    tail: tuple[Any, ...],
) -> Step:
    x = field.positions()

    def run(t: Any, dt: Any) -> None:
        function(field.G, *remembered(_in_region(e, layer, x, float(t))), *tail, t, dt)

    return run


def loads(e: Engine, phase: Phase) -> list[Step]:
    """Loads of a layer of particles, found by their places in the sorted buffer."""
    layer = e.c.layers[phase.role]
    steps: list[Step] = []
    for k, (s, body) in enumerate(zip(e.stores, e.c.sim.bodies, strict=True)):
        if getattr(layer, "body", None) not in (None, e.c.sim.body_name(body)):
            continue
        layer_of = layer.select(s.points, e.c.grid)
        assert layer_of is not None
        function, arguments = getattr(e.module, f"{phase.name}_{s.group.name}"), e.particle_arguments(k, None)[:-1]
        chosen, scratch = np.asarray(layer_of.chosen, dtype=np.int64), tuple[Any, ...]()
        order: Any = slice(None)
        if not e.c.stored_operator:
            where_now = s.places()[chosen]
            order = np.argsort(where_now)
            order = order[where_now[order] >= 0]  # points that have been taken out carry nothing
            chosen = where_now[order]
            blocks = np.searchsorted(e.places.blocks[k].starts, chosen, side="right") - 1
            arguments = (arguments[0], blocks, *arguments[2:])
            scratch = (e.scratch[0][0], e.scratch[0][2])
        else:
            arguments = (arguments[0], *arguments[2:])
        arrays: Any = tuple(np.ascontiguousarray(a[order], dtype=e.dtype) for a in (layer_of.area, layer_of.normals, layer_of.arms))
        steps.append(_on_nodes(function, (chosen, *arguments, *arrays, *scratch)))
    return steps
