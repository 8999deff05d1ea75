"""Runs the phases of a plan: arrays, arguments and clocks. The method itself is in the generated module."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from mpmkit._core.composing.plan import LEDGER, Plan
from mpmkit._core.composing.schedule import Phase, Schedule
from mpmkit._core.composing.sweep import WORK
from mpmkit._core.running.contact import ContactPairs
from mpmkit._core.running.store import BodyStore

Operation = tuple[str, Callable[..., Any], tuple[Any, ...]]


class Field:
    """One velocity field on the nodes: of all bodies, or of one body if there is contact."""

    def __init__(self, n_nodes: int, channels: int, dtype: type) -> None:
        self.G: Any = np.zeros(n_nodes * channels, dtype=dtype)
        self.span = np.array([0, n_nodes], dtype=np.int64)  # nodes that may be occupied


class Engine:
    """State of a running simulation and its step.

    Parameters
    ----------
    plan : Plan
        Phases, layouts and the generated module.
    stores : list of BodyStore
        Particles, in the order of the bodies.
    """

    def __init__(self, plan: Plan, stores: list[BodyStore]) -> None:
        self.plan, self.stores = plan, stores
        c = plan.composition
        self.c, self.dtype = c, plan.dtype
        self.module = plan.load()
        self.t, self.step_number = 0.0, 0
        self.work = np.zeros(len(WORK))
        self.clocks: dict[str, float] = {}
        self.flags = np.full((len(stores), 4), -1, dtype=np.int64)
        self.outs = np.zeros((len(stores), 8))
        for k, s in enumerate(stores):
            s.flag, s.out = self.flags[k], self.outs[k]
        self.channels = plan.node_layout.size
        self._nodes()
        particle_mass = min(float(s.get("m").min()) for s in stores)
        small = float(np.finfo(self.dtype).eps) ** 2 * particle_mass
        mean_mass = float(np.mean([s.get("m").mean() for s in stores]))
        roles = c.roles() | {
            "m_limit": c.fraction * mean_mass,
            "m_light": 0.5 * mean_mass,
            "grid": c.grid,
            "ghosts": float(plan.operator.padding[0]),
            "m_small": small,
        }
        self.node_par = plan.node_parameters.values(roles, self.dtype)
        self.m_small = small
        self.body_par = [
            plan.group_parameters[s.group.name].values(roles | {"material": body.material}, self.dtype)
            for s, body in zip(stores, c.sim.bodies, strict=True)
        ]
        self.moving_layers: list[tuple[Any, list[Any]]] = []
        self.contact = ContactPairs(self) if c.contact is not None else None
        self.operations = self._bind(plan.schedule)
        self._bind_ledger()

    # --- nodes --------------------------------------------------------------------------------------------------
    def _nodes(self) -> None:
        c, plan = self.c, self.plan
        if c.stored_operator:
            self.X_nodes: Any = np.concatenate([s.points.nodes for s in self.stores])
            first = 0
            for s in self.stores:
                s.operator = (s.points.connectivity + first, s.points.N.astype(self.dtype), s.points.dN.astype(self.dtype))
                first += len(s.points.nodes)
            self.lat = np.zeros(6, dtype=np.int64)
            self.n_nodes = first
        else:
            low, high = plan.operator.padding
            self.shape = [n + low + high for n in c.grid.nodes]
            strides = [int(np.prod(self.shape[a + 1 :])) for a in range(c.dim)]
            self.lat = np.array([*c.grid.cells, *[0] * (3 - c.dim), *strides, *[0] * (3 - c.dim)], dtype=np.int64)
            self.n_nodes = int(np.prod(self.shape))
            self.X_nodes = None
        n_fields = len(self.stores) if c.contact is not None else 1
        self.fields = [Field(self.n_nodes, self.channels, self.dtype) for _ in range(n_fields)]

    def field_of(self, body: int) -> Field:
        return self.fields[body if len(self.fields) > 1 else 0]

    def node_positions(self) -> Any:
        """Positions of the stored nodes, float64[n_nodes, dim]."""
        if self.X_nodes is not None:
            return self.X_nodes
        grid, low = self.c.grid, self.plan.operator.padding[0]
        axes = [grid.lower[a] + (np.arange(self.shape[a]) - low) * grid.spacing[a] for a in range(self.c.dim)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, self.c.dim)

    def _face_nodes(self, faces: tuple[str, ...]) -> tuple[Any, Any]:
        """Numbers and outward normals of the nodes on faces; a node on two faces is listed twice."""
        grid, x = self.c.grid, self.node_positions()
        numbers, normals = [], []
        for face in faces:
            axis, upper = "xyz".index(face[0]), face.endswith("max")
            wall = grid.upper[axis] if upper else grid.lower[axis]
            on = np.flatnonzero(np.abs(x[:, axis] - wall) < 1e-6 * grid.spacing[axis])
            n: Any = np.zeros((on.size, 3), dtype=self.dtype)
            n[:, axis] = 1.0 if upper else -1.0
            numbers.append(on)
            normals.append(n)
        if not numbers:
            return np.zeros(0, dtype=np.int64), np.zeros((0, 3), dtype=self.dtype)
        return np.concatenate(numbers).astype(np.int64), np.concatenate(normals)

    # --- binding ------------------------------------------------------------------------------------------------
    def _particle_arguments(self, k: int) -> tuple[Any, ...]:
        s, G = self.stores[k], self.field_of(k).G
        middle = s.operator if self.c.stored_operator else (self.lat,)
        return (s.P, s.n, G, self.body_par[k], *middle, s.out, s.flag)

    def _node_arguments(self, field: Field) -> tuple[Any, ...]:
        return (field.G, field.span, *((self.X_nodes,) if self.c.stored_operator else ()))

    def _bind(self, schedule: Schedule) -> list[Operation]:
        operations: list[Operation] = []
        for phase in schedule.phases:
            operations += self._bind_phase(phase, schedule)
        return operations

    def _bind_phase(self, phase: Phase, schedule: Schedule) -> list[Operation]:
        m = self.module
        tail = (self.node_par, self.lat, self.work)
        if phase.kind == "particles":
            return [
                (phase.name, getattr(m, f"{phase.name}_{s.group.name}"), self._particle_arguments(k)) for k, s in enumerate(self.stores)
            ]
        if phase.kind == "loads":
            return self._bind_load(phase)
        if phase.kind == "nodes":
            more = (self.dtype(phase.number),) if phase.name.startswith("filter") else ()
            return [(phase.name, getattr(m, phase.name), (*self._node_arguments(f), *more, *tail)) for f in self.fields]
        if phase.kind == "boundary":
            return self._bind_boundary(phase, tail)
        if phase.kind == "contact":
            assert self.contact is not None
            first = phase.channel == schedule.contact_channels[0] and phase is next(p for p in schedule.phases if p.kind == "contact")
            return [(phase.name, self.contact.operation(phase.channel, find=first), ())]
        from mpmkit._core.running.consistent import ConsistentMomentum

        return [(phase.name, ConsistentMomentum(self), ())]

    def _bind_boundary(self, phase: Phase, tail: tuple[Any, ...]) -> list[Operation]:
        layer, function = self.c.layers[phase.role], getattr(self.module, phase.name)
        faces = layer.faces_of(self.c.grid)
        if faces:
            numbers, normals = self._face_nodes(faces)
        else:
            numbers = np.flatnonzero(layer.nodes_in(self.node_positions(), self.t)).astype(np.int64)
            normals = np.zeros((numbers.size, 3), dtype=self.dtype)
        extra = (self.X_nodes,) if self.c.stored_operator else ()
        if getattr(layer, "moving", None) is None:
            return [(phase.name, function, (f.G, numbers, normals, *extra, *tail)) for f in self.fields]

        x = self.node_positions()

        def moving(t: Any, dt: Any) -> None:
            now = np.flatnonzero(layer.nodes_in(x, float(t))).astype(np.int64)
            for f in self.fields:
                function(f.G, now, np.zeros((now.size, 3), dtype=self.dtype), *extra, *tail, t, dt)

        return [(phase.name, moving, ())]

    def _bind_load(self, phase: Phase) -> list[Operation]:
        layer = self.c.layers[phase.role]
        out: list[Operation] = []
        for k, (s, body) in enumerate(zip(self.stores, self.c.sim.bodies, strict=True)):
            if getattr(layer, "body", None) not in (None, self.c.sim.body_name(body)):
                continue
            chosen = layer.select(s.points, self.c.grid)
            assert chosen is not None
            arrays: Any = tuple(np.ascontiguousarray(a, dtype=self.dtype) for a in (chosen.area, chosen.normals, chosen.arms))
            out.append(
                (phase.name, getattr(self.module, f"{phase.name}_{s.group.name}"), (*self._particle_arguments(k), chosen.chosen, *arrays))
            )
        return out

    # --- running ------------------------------------------------------------------------------------------------
    def start(self) -> None:
        """Initial stresses and wave speeds; nodes of stored operators get their masses and velocities."""
        zero = self.dtype(0.0)
        self.outs[:, 0] = 0.0
        for k, s in enumerate(self.stores):
            getattr(self.module, f"initial_{s.group.name}")(*self._particle_arguments(k), zero, zero)
        self._update_spans()
        for _, function, arguments in self._bind(self.plan.start):
            function(*arguments, zero, zero)

    def step(self, dt: float) -> None:
        """One step of length dt."""
        clock, clocks = time.perf_counter, self.clocks
        begin = clock()
        t_, dt_ = self.dtype(self.t), self.dtype(dt)
        if not self.c.stored_operator:
            for field in self.fields:
                field.G[field.span[0] * self.channels : field.span[1] * self.channels] = 0.0
            self._update_spans()
        now = clock()
        clocks["zero"] = clocks.get("zero", 0.0) + now - begin
        for name, function, arguments in self.operations:
            function(*arguments, t_, dt_)
            then, now = now, clock()
            clocks[name] = clocks.get(name, 0.0) + now - then
        self.t += dt
        self.step_number += 1

    def _update_spans(self) -> None:
        """Range of nodes that the particles can reach, from their extent along the first axis."""
        if self.c.stored_operator:
            return
        grid, operator, stride = self.c.grid, self.plan.operator, int(self.lat[3])
        for k, field in enumerate(self.fields):
            outs = self.outs[k : k + 1] if len(self.fields) > 1 else self.outs
            low = int((outs[:, 3].min() - grid.lower[0]) / grid.spacing[0] - operator.offset) - 1
            high = int((outs[:, 4].max() - grid.lower[0]) / grid.spacing[0]) + operator.nodes + 1
            field.span[0] = max(0, low + operator.ghosts) * stride
            field.span[1] = min(self.shape[0], high + operator.ghosts + 1) * stride

    # --- sums ---------------------------------------------------------------------------------------------------
    def _bind_ledger(self) -> None:
        self.sums = np.zeros((len(self.stores), 16))

    def ledger(self) -> dict[str, float]:
        """Sums over all bodies, and the works done since the start."""
        zero = self.dtype(0.0)
        self.sums[:] = 0.0
        for k, s in enumerate(self.stores):
            arguments = list(self._particle_arguments(k))
            arguments[-2] = self.sums[k]
            getattr(self.module, f"ledger_{s.group.name}")(*arguments, zero, zero)
        row = dict(zip(LEDGER, self.sums.sum(axis=0), strict=False))
        if self.c.stored_operator:
            row |= self._nodal_motion()
        row |= dict(zip(WORK, self.work, strict=True))
        row["external"] += float(self.outs[:, 5].sum())
        row["viscous"] = float(self.outs[:, 2].sum())
        return {name: float(value) for name, value in row.items()}

    def _nodal_motion(self) -> dict[str, float]:
        """Momentum and kinetic energy of nodes that carry the velocity themselves."""
        G, layout = self.fields[0].G.reshape(-1, self.channels), self.plan.node_layout
        m, v = G[:, layout.start["m"]], G[:, layout.start["v"] : layout.start["v"] + self.c.dim]
        momentum = (m[:, None] * v).sum(axis=0)
        return {f"momentum_{a}": momentum[k] for k, a in enumerate("xyz"[: self.c.dim])} | {"kinetic": 0.5 * (m[:, None] * v * v).sum()}

    # --- state --------------------------------------------------------------------------------------------------
    def state(self) -> dict[str, Any]:
        """Every array that the next step depends on (views, not copies)."""
        arrays = {f"P/{s.name}": s.P for s in self.stores} | {"work": self.work, "outs": self.outs}
        if self.c.stored_operator:
            arrays["nodes"] = self.fields[0].G
        return arrays

    def restore(self, arrays: dict[str, Any], t: float, step: int) -> None:
        for name, array in self.state().items():
            array[...] = arrays[name]
        self.t, self.step_number = t, step
        for field in self.fields:
            if not self.c.stored_operator:
                field.span[:] = (0, self.n_nodes)  # the first step clears everything
