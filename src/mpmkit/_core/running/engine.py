"""Runs the phases of a plan: arrays, arguments, threads and clocks. The method itself is in the generated module."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import attrs
import numpy as np

from mpmkit._core.composing.layout import LANES
from mpmkit._core.composing.module import LEDGER
from mpmkit._core.composing.plan import Plan
from mpmkit._core.composing.schedule import Phase, Schedule
from mpmkit._core.composing.sweep import WORK
from mpmkit._core.composing.writer import ACCOUNTS
from mpmkit._core.running import bindings
from mpmkit._core.running.contact import ContactPairs
from mpmkit._core.running.held import Held
from mpmkit._core.running.nodes import SparseNodes
from mpmkit._core.running.placing import ListedNodes, ListedPoints, SortedBodies
from mpmkit._core.running.store import BodyStore, aligned
from mpmkit._core.running.workers import Team, chosen
from mpmkit.errors import StabilityError

Operation = tuple[str, Callable[[Any, Any], None]]

SPEED, DIFFUSION, MOVED, VISCOUS, EXTERNAL, MOTION = (
    ACCOUNTS.index(n) for n in ("speed", "diffusion", "moved", "viscous", "external", "motion")
)
JOIN_BYTES = 128 * 2**20
"""Particles from here on are stepped with the end of one step and the beginning of the next in one pass: it reads memory once in place
of twice, but holds more in registers, so that bodies that fit into the caches gain nothing. The results are the same to the bit.
"""
FLAGS = ("inverted", "inside", "stretched")
GONE = ("mass", "momentum_x", "momentum_y", "momentum_z", "energy", "dissipated", "particles")
"""What has left the domain with particles that were taken out (see `leaving`); what they had dissipated stays with the rest of it."""


@attrs.frozen
class Turn:
    """What a step does in order: `clears` and `first` unless the step before has joined them to its own end; then `middle`; then `last`,
    or, in one pass, the last loop and the first of the next step, from the nodes' one side to their other (`other` clears that).
    """

    clears: list[Callable[[], None]]
    first: list[Operation]
    middle: list[Operation]
    last: list[Operation]
    other: list[Callable[[], None]]
    joined: list[Operation]


class Engine:
    """State of a running simulation and its step.

    Parameters
    ----------
    plan : Plan
        Phases, layouts and the generated module.
    stores : list of BodyStore
        Particles, in the order of the bodies.
    threads : int, optional
        How many threads step; results do not depend on it. Chosen by the number of particles if not given.

    Attributes
    ----------
    outs : float64[bodies, 9]
        By `ACCOUNTS`: fastest signal and largest diffusivity of the last step, dissipation and work of external forces so far.
    flags : bool[bodies, 3]
        Whether some particle is inverted, outside the domain, or wider than its shape function allows.
    gone : float64[7]
        By `GONE`: mass, momentum, energy of particles that were taken out.
    """

    def __init__(self, plan: Plan, stores: list[BodyStore], threads: int | None = None) -> None:
        self.plan, self.stores = plan, stores
        c = plan.composition
        self.c, self.dtype = c, plan.dtype
        self.module = plan.load()
        self.t, self.step_number = 0.0, 0
        self.team = Team(chosen(threads, sum(s.n for s in stores)))
        self.work = np.zeros(len(WORK))
        self.gone = np.zeros(len(GONE))
        self.clocks: dict[str, float] = {}
        self.flags = np.zeros((len(stores), len(FLAGS)), dtype=bool)
        self.outs = np.zeros((len(stores), len(ACCOUNTS)))
        self.channels = plan.node_layout.size
        if not c.stored_operator and not c.loaded:
            for s in stores:
                s.release()
        self._parameters()
        n_fields = len(stores) if c.contact is not None else 1
        self.places: Any
        if c.stored_operator:
            self.fields: list[Any] = [ListedNodes(stores, self.channels, self.dtype)]
            self.places = ListedPoints(stores)
        else:
            self.places = SortedBodies(plan, stores, self.team)
            self.fields = [SparseNodes(self.places.lattice, self.channels, self.dtype) for _ in range(n_fields)]
        self.scratch = [self._scratch() for _ in range(self.team.size)]
        self.held = {(role, k): Held() for role, layer in c.layers.items() if c.remembers(layer) for k in range(n_fields)}
        self.contact = ContactPairs(self) if c.contact is not None else None
        fixed = getattr(c.integrator, "dt", None) is not None
        large = sum(s.P.nbytes for s in stores) >= JOIN_BYTES
        self.joins = large and plan.schedule.cycle is not None and (fixed or not c.first_loop_asks_dt)
        self.ready: float | None = None  # nodes hold what particles give them for a step of this length
        self.turns: list[Turn] = []
        self.start_operations: list[Operation] = []
        self._largest, self._sums = np.zeros(16), np.zeros(16)
        for k, store in enumerate(stores):
            store.derive = partial(self._derive, k)
        self._place()

    def _derive(self, k: int, s: BodyStore, field: str, first: int, last: int) -> Any:
        """A field of body k that steps do not keep, in tiles of 16 particles; of its particles as they are in this store."""
        tile = LANES
        rows: Any = slice(first * tile * s.layout.size, last * tile * s.layout.size)
        out: Any = np.zeros((last - first) * tile * len(s.layout.stored(field)), self.dtype)
        getattr(self.module, f"{field}_{s.group.name}")(0, last - first, s.n - first * tile, s.P[rows], self.body_par[k], out)
        return out

    def use(self, threads: int | None) -> None:
        """Go on with this many threads (see `workers.chosen`); the results do not depend on it."""
        size = chosen(threads, sum(s.n for s in self.stores))
        if size == self.team.size:
            return
        self.team.close()
        self.team = Team(size)
        self.scratch = [self._scratch() for _ in range(size)]
        if not self.c.stored_operator:
            self.places.team = self.team
        self.bind()

    def _parameters(self) -> None:
        c, plan, stores = self.c, self.plan, self.stores
        masses = [[m for (m,) in s.pieces("m")] for s in stores]
        particle_mass = min(float(m.min()) for pieces in masses for m in pieces)
        mean_masses = [sum(float(m.sum()) for m in pieces) / s.n for s, pieces in zip(stores, masses, strict=True)]
        self.m_small = float(np.finfo(self.dtype).eps) ** 2 * particle_mass
        roles = c.roles() | {"grid": c.grid, "m_small": self.m_small} | self._light(min(mean_masses))
        self.node_par = plan.node_parameters.values(roles, self.dtype)
        # What is a light node of a heavy body may be a full one of a light body: with a field for each body, each has its own measure; in
        # one field it is that of the lightest, since limiting full nodes of a light body would take a tenth of its energy.
        own = mean_masses if c.contact is not None else []
        self.field_par = [plan.node_parameters.values(roles | self._light(m), self.dtype) for m in own] or [self.node_par]
        self.body_par = [
            plan.group_parameters[s.group.name].values(roles | {"material": body.material}, self.dtype)
            for s, body in zip(stores, c.sim.bodies, strict=True)
        ]

    def _light(self, mass: float) -> dict[str, float]:
        """Masses of nodes that count as light, where a particle has this mass."""
        return {"m_limit": self.c.fraction * mass, "m_light": 0.5 * mass}

    def _scratch(self) -> tuple[Any, ...]:
        """Arrays that one thread works in: rows of lanes, the same by particle, first nodes, arenas to read and to add to."""
        operator, T = self.plan.operator, self.dtype
        if self.c.stored_operator:
            return (aligned(16 * self.plan.slots, T),)
        arena = operator.arena.size * self.channels + 64
        lanes = 16 * self.plan.slots
        return (aligned(lanes, T), aligned(lanes, T), np.zeros(16, dtype=np.int32), aligned(arena, T), aligned(arena, T))

    def field_of(self, body: int) -> Any:
        return self.fields[body if len(self.fields) > 1 else 0]

    def node_positions(self, field: Any = None) -> Any:
        """Positions of the stored nodes of a field, float64[n_nodes, dim]."""
        return (field or self.fields[0]).positions()

    # --- places of particles and nodes --------------------------------------------------------------------------
    def _place(self) -> None:
        """Sort the bodies that need it and bind the operations to what has changed."""
        if not self.places.update(self.module):
            return
        for k, field in enumerate(self.fields):
            field.update(self.places.blocks[k : k + 1] if len(self.fields) > 1 else self.places.blocks)
        self.bind()

    def bind(self) -> None:
        """Make the operations of a step anew, with the present arrays; for either side of the nodes if steps are joined."""
        if self.contact is not None:
            self.contact.update()
        self.node_work = [np.zeros(max(1, f.active) * len(WORK)) for f in self.fields]
        self.turns = []
        for _ in range(2 if self.joins else 1):
            self.turns.append(self._turn())
            if self.joins:
                for field in self.fields:
                    field.turn()
        self.start_operations = self._bind(self.plan.start)

    def _turn(self) -> Turn:
        operations = self._bind(self.plan.schedule)
        if self.c.stored_operator:
            return Turn([], [], operations, [], [], [])
        n = len(self.stores)  # operations of a loop over the particles of all bodies
        clears = [bindings.clear(self, field, field.G) for field in self.fields]
        if not self.joins:
            return Turn(clears, operations[:n], operations[n:], [], [], [])
        other = [bindings.clear(self, field, field.H) for field in self.fields]
        joined = [(operations[-1][0], bindings.joined(self, k)) for k in range(n)]
        return Turn(clears, operations[:n], operations[n:-n], operations[-n:], other, joined)

    def particle_arguments(self, k: int, acc: Any) -> tuple[Any, ...]:
        """Arguments of a loop over the particles of body k after the range of blocks."""
        s, b, field = self.stores[k], self.places.blocks[k], self.field_of(k)
        if self.c.stored_operator:
            return (s.P, b.starts, *s.operator, field.G, self.body_par[k], acc)
        return (s.P, b.starts, b.corner, b.home, b.edge, field.G, self.body_par[k], acc)

    def _bind(self, schedule: Schedule) -> list[Operation]:
        return [(phase.name, operation) for phase in schedule.phases for operation in self._operations(phase, schedule)]

    def _operations(self, phase: Phase, schedule: Schedule) -> list[Callable[[Any, Any], None]]:
        if phase.kind == "particles":
            return [bindings.over_particles(self, k, phase.name, self.places.acc[k]) for k in range(len(self.stores))]
        if phase.kind == "nodes":
            return [bindings.over_nodes(self, k, phase) for k in range(len(self.fields))]
        if phase.kind == "loads":
            return bindings.loads(self, phase)
        if phase.kind == "boundary":
            return bindings.boundary(self, phase)
        if phase.kind == "contact":
            assert self.contact is not None
            first = next(p for p in schedule.phases if p.kind == "contact")
            return [self.contact.operation(phase.channel, find=phase is first)]
        from mpmkit._core.running.consistent import ConsistentMomentum

        return [ConsistentMomentum(self)]

    # --- running ------------------------------------------------------------------------------------------------
    def start(self) -> None:
        """Initial stresses and wave speeds; nodes of stored operators get their masses and velocities."""
        zero = self.dtype(0.0)
        for k in range(len(self.stores)):
            bindings.over_particles(self, k, "initial", self.places.acc[k])(zero, zero)
            self._speeds(k, self._reduced(self.places.acc[k], self.places.blocks[k].count, len(ACCOUNTS))[0])
        for _, operation in self.start_operations:
            operation(zero, zero)

    def step(self, dt: float) -> None:
        """One step of length dt.

        Raises
        ------
        StabilityError
            If the step before has left particles that no loop may touch (`guards.check` says which).
        """
        if self.flags.any():
            raise StabilityError(f"step {self.step_number} left particles that are inverted, too wide, outside or not a number")
        clock, clocks = time.perf_counter, self.clocks
        begin = clock()
        t_, dt_ = self.dtype(self.t), self.dtype(dt)
        now = begin

        def clear(clears: list[Callable[[], None]]) -> None:
            nonlocal now
            for one in clears:
                one()
            begin, now = now, clock()
            clocks["zero"] = clocks.get("zero", 0.0) + now - begin

        def do(operations: list[Operation]) -> None:
            nonlocal now
            for name, operation in operations:
                operation(t_, dt_)
                then, now = now, clock()
                clocks[name] = clocks.get(name, 0.0) + now - then

        if self.ready is None or (self.ready != dt and self.c.first_loop_asks_dt):
            if not self.c.stored_operator:
                self._place()
                now = clock()
                clocks["sort"] = clocks.get("sort", 0.0) + now - begin
                clear(self.turns[0].clears)
            do(self.turns[0].first)
        turn, self.ready = self.turns[0], None
        do(turn.middle)
        joined = self.joins and self.places.stays()
        if joined:
            clear(turn.other)
        do(turn.joined if joined else turn.last)
        self._account()
        if joined and self.places.in_place():
            self.ready = dt
            self.turns.reverse()
            for field in self.fields:
                field.turn()
        clocks["accounts"] = clocks.get("accounts", 0.0) + clock() - now
        self.t += dt
        self.step_number += 1

    def _account(self) -> None:
        """Take over what the loops have left in the accounts of their blocks."""
        for k in range(len(self.stores)):
            largest, sums = self._reduced(self.places.acc[k], self.places.blocks[k].count, len(ACCOUNTS))
            self._speeds(k, largest)
            self.places.moved(k, largest[MOVED])
            self.outs[k, VISCOUS] += sums[VISCOUS]
            self.outs[k, EXTERNAL] += sums[EXTERNAL]
            self.flags[k] = largest[MOVED + 1 : MOVED + 4] > 0.0
        for field, work in zip(self.fields, self.node_work, strict=True):
            self.work += self._reduced(work, field.active, len(WORK))[1][: len(WORK)]
            work[:] = 0.0

    def _speeds(self, k: int, largest: Any) -> None:
        """Take over what limits the time step: signals move with the particles, which some recipes account for in another loop."""
        self.outs[k, SPEED], self.outs[k, DIFFUSION] = largest[SPEED] + largest[MOTION], largest[DIFFUSION]

    def _reduced(self, acc: Any, count: int, width: int) -> tuple[Any, Any]:
        self.module.reduce(acc, count, width, self._largest, self._sums)
        return self._largest, self._sums

    # --- sums ---------------------------------------------------------------------------------------------------
    def ledger(self) -> dict[str, float]:
        """Sums over all bodies, and the works done since the start."""
        self._place()  # as the next step would: weights near the boundary are folded in blocks that are marked for particles in place
        zero = self.dtype(0.0)
        total = np.zeros(len(LEDGER))
        for k in range(len(self.stores)):
            acc = self.places.ledger_acc(k, len(LEDGER))
            bindings.over_particles(self, k, "ledger", acc)(zero, zero)
            total += self._reduced(acc, self.places.blocks[k].count, len(LEDGER))[1][: len(LEDGER)]
        row: dict[str, float] = dict(zip(LEDGER, total.tolist(), strict=True))
        if self.c.stored_operator:
            row |= self._nodal_motion()
        row |= dict(zip(WORK, self.work, strict=True))
        row["external"] += float(self.outs[:, EXTERNAL].sum())
        row["viscous"] = float(self.outs[:, VISCOUS].sum())
        row |= {f"left_{name}": float(value) for name, value in zip(GONE, self.gone, strict=True)}
        return {name: float(value) for name, value in row.items()}

    def _nodal_motion(self) -> dict[str, float]:
        """Momentum and kinetic energy of nodes that carry the velocity themselves."""
        field, layout = self.fields[0], self.plan.node_layout
        G = field.G[: field.n_nodes * self.channels].reshape(-1, self.channels)
        m, v = G[:, layout.start["m"]], G[:, layout.start["v"] : layout.start["v"] + self.c.dim]
        momentum = (m[:, None] * v).sum(axis=0)
        return {f"momentum_{a}": momentum[k] for k, a in enumerate("xyz"[: self.c.dim])} | {"kinetic": 0.5 * (m[:, None] * v * v).sum()}

    # --- state --------------------------------------------------------------------------------------------------
    def bytes(self) -> dict[str, int]:
        """Memory of particles, nodes and scratch arrays, with the numbers of stored nodes and of their blocks."""
        return {
            "particles": sum(s.P.nbytes + s.ids.nbytes for s in self.stores),
            "nodes": sum(f.G.nbytes for f in self.fields) * (2 if self.joins else 1),
            "scratch": sum(a.nbytes for arrays in self.scratch for a in arrays),
            "stored nodes": sum(f.n_nodes for f in self.fields),
            "blocks": sum(f.active for f in self.fields),
        }

    def state(self) -> dict[str, Any]:
        """Every array that the next step depends on (views, not copies)."""
        arrays = {f"P/{s.name}": s.P for s in self.stores} | {"work": self.work, "outs": self.outs, "gone": self.gone}
        for (role, k), held in self.held.items():
            arrays |= {f"held/{role}/{k}/{name}": array for name, array in held.state().items()}
        return arrays | (self.places.state() if not self.c.stored_operator else {"nodes": self.fields[0].G})

    def restore(self, arrays: dict[str, Any], t: float, step: int) -> None:
        for s in self.stores:
            s.take(arrays[f"P/{s.name}"], arrays.get(f"ids/{s.name}"), arrays.get(f"kept/{s.name}"))
        self.work[:], self.outs[:], self.gone[:] = arrays["work"], arrays["outs"], arrays["gone"]
        for (role, k), held in self.held.items():
            held.restore(arrays[f"held/{role}/{k}/keys"], arrays[f"held/{role}/{k}/flags"])
        if self.c.stored_operator:
            self.fields[0].G[:] = arrays["nodes"]
        else:
            self.places.restore(arrays)
            for k, field in enumerate(self.fields):
                field.update(self.places.blocks[k : k + 1] if len(self.fields) > 1 else self.places.blocks)
            self.ready = None
            self.bind()
        self.t, self.step_number = t, step
