"""The text of the generated module: the functions of all phases, each once, and those every body needs beside its step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import mpmkit
from mpmkit import tensor
from mpmkit._core.composing import conditions, meeting, sweeps
from mpmkit._core.composing.composition import Composition, Group
from mpmkit._core.composing.layout import NodeLayout
from mpmkit._core.composing.pieces import PIECES, motion, second_moments
from mpmkit._core.composing.schedule import Phase, Schedule
from mpmkit._core.composing.sorting import sort_functions
from mpmkit._core.composing.source import Names, Parameters, ParticleLoop
from mpmkit._core.composing.sweep import Sweep
from mpmkit._core.composing.writer import ACCOUNTS, Written, alone, cycle, each_particle, in_parts, on_demand, written

LEDGER = (
    "mass",
    "momentum_x",
    "momentum_y",
    "momentum_z",
    "angular_x",
    "angular_y",
    "angular_z",
    "kinetic",
    "stored",
    "dissipated",
    "volume",
)


class Module:
    """The functions of a module in the making, each once."""

    def __init__(self, c: Composition, layout: NodeLayout, operator: Any, plan: Schedule) -> None:
        self.c, self.layout, self.operator, self.plan = c, layout, operator, plan
        self.names, self.node_parameters = Names(), Parameters()
        self.group_parameters = {g.name: Parameters() for g in c.groups}
        self.texts: dict[str, str] = {}
        self.slots = 1  # rows of lanes in the scratch array of a thread
        self.scatters: set[str] = set()  # loops that add to nodes
        self.traffic: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {}  # of each loop: channels summed over nodes, channels added to
        self.written: dict[str, tuple[ParticleLoop, Written]] = {}
        self.channel = {"strain": plan.strain_channel, "u": "u", "u_next": "u_next"}

    def loop(self, group: Group) -> ParticleLoop:
        self.names.of("det", tensor.det)
        return ParticleLoop(self.c, self.group_parameters[group.name], self.names, group, self.layout)

    def sweep(self) -> Sweep:
        block = 0 if self.c.stored_operator else self.operator.arena.block
        return Sweep(self.c, self.node_parameters, self.names, self.layout, block)

    def take(self, loop: ParticleLoop, name: str, text: str) -> None:
        self.slots = max(self.slots, loop.most_slots, self.operator.slots.count)
        self.texts[name] = text
        self.traffic[name] = tuple(dict.fromkeys(channel for channel, _ in loop.sums)), tuple(loop.terms)
        if loop.terms:
            self.scatters.add(name)

    def phase(self, phase: Phase) -> None:
        """The functions one phase needs."""
        c, sweep = self.c, self.sweep()
        has_velocity = self.plan.has_velocity and phase.name != "start_momentum"
        if phase.kind in ("particles", "loads"):
            for g in c.groups:
                name, loop = f"{phase.name}_{g.name}", self.loop(g)
                if name in self.texts:
                    continue
                if phase.kind == "loads":
                    self.take(loop, name, conditions.load(loop, self.operator, phase.role, name))
                else:
                    self.written[name] = loop, written(loop, self.operator, name, list(phase.verbs), self.channel)
                    self.take(loop, name, alone(self.written[name][1], self.operator))
        elif phase.kind == "boundary":
            on_old = phase.channel == "v" and (not has_velocity or c.stored_operator)
            self.texts[phase.name] = conditions.boundary(sweep, phase.role, phase.channel, on_old, phase.name)
        elif phase.kind == "nodes":
            text = NODE_PHASES.get(phase.name)
            self.texts[phase.name] = text(sweep) if text else sweeps.momentum(sweep, has_velocity, phase.name)
        elif phase.kind == "contact":
            for name, function in meeting.contact_functions(sweep, phase.channel).items():
                self.texts.setdefault(name, function)

    def cycle(self, group: Group) -> None:
        """The last loop of a step joined with the first of the next."""
        ends = self.plan.cycle
        if ends is not None:
            (_, last), (loop, first) = (self.written[f"{phase.name}_{group.name}"] for phase in ends)
            name = f"cycle_{group.name}"
            self.texts[name] = cycle(name, last, first, self.operator.prepare(loop, moved=True), self.operator)
            self.scatters.add(name)

    def group(self, group: Group) -> None:
        """What every body needs beside its step: initial stress, sums for the ledger."""
        loops = {"initial": (_initial, ACCOUNTS), "ledger": (_ledger, LEDGER)}
        for name, (fill, accounts) in loops.items():
            loop = self.loop(group)
            doc = fill(loop)
            whole = in_parts(loop, self.operator, f"{name}_{group.name}", doc, accounts)
            self.take(loop, whole.name, alone(whole, self.operator))
        for field in group.layout.derived:
            loop = self.loop(group)
            self.take(loop, f"{field}_{group.name}", on_demand(loop, f"{field}_{group.name}", field))
        if self.c.contact is not None:
            loop, name = self.loop(group), f"outward_{group.name}"
            self.take(loop, name, alone(written(loop, self.operator, name, ["outward"], self.channel), self.operator, only="marked"))
            loop = self.loop(group)
            self.take(loop, f"reach_{group.name}", meeting.reach_function(loop, self.operator, f"reach_{group.name}"))
        if getattr(self.c.integrator, "mass", "lumped") == "consistent":
            loop = self.loop(group)
            self.take(loop, f"mass_matrix_{group.name}", _mass_matrix(loop, self.operator))

    def text(self) -> str:
        """The whole module."""
        texts = [*self.operator.functions.values(), *self.texts.values(), REDUCE]
        if not self.c.stored_operator:
            texts.append(sort_functions(self.c.dim, self.operator.arena.block))
        return _header(self.c, self.names, self.layout) + "\n\n\n".join(t.rstrip("\n") for t in texts) + "\n"


NODE_PHASES: dict[str, Callable[[Sweep], str]] = {
    "carry": lambda sweep: sweeps.carry(sweep, "carry"),
    "velocity": lambda sweep: sweeps.divide(sweep, "v_old", "velocity", "Nodes: v_i = (mv)_i / m_i."),
    "limited_velocity": lambda sweep: sweeps.limit(sweep, "limited_velocity", "v_map", "m_limit"),
    "soft_velocity": lambda sweep: sweeps.limit(sweep, "soft_velocity", "v_soft", "m_light"),
    "mapped_velocity": lambda sweep: sweeps.divide(
        sweep, "v_map", "mapped_velocity", "Nodes: v_i = (mv)_i / m_i after the second mapping."
    ),
    "filter_start": sweeps.filter_start,
    "filter_add": sweeps.filter_add,
}
"""Loops over nodes by the name of their phase; the momentum update has a name of its own where nodes start with velocities."""

REDUCE = '''@compiled
def clear_nodes(first, last, G, size):
    """Zeros in blocks first to last of `size` numbers."""
    for i in range(first * size, last * size):
        G[U(i)] = zero


@compiled
def reduce(acc, count, width, largest, sums):
    """Largest value (NaN if there is one) and sum over the blocks of each column of their accounts."""
    for column in range(width):
        most, total = acc[U(column)], 0.0
        for block in range(count):
            value = acc[U(width * block + column)]
            most = most if not (value > most or value != value) else value
            total += value
        largest[column], sums[column] = most, total
'''


def _initial(loop: ParticleLoop) -> str:
    """Stress of the initial deformation and the wave speed for the first time step: the law with L = 0 and dt = 0."""
    loop.line("L = (zero, zero, zero, zero, zero, zero, zero, zero, zero)")
    loop.have.add("L")
    PIECES["stress"](loop, "compute", {})
    if loop.composition.strains_first:
        loop.line(f"motion = {motion(loop)}")
        loop.maximum("motion", "motion")
    return "Initial stress and wave speed"


def _ledger(loop: ParticleLoop) -> str:
    """Sums for the ledger over one body."""
    dim, group = loop.dim, loop.group
    affine = "C" in group.layout.fields
    for name in ("x", "v", "m", "V0", *(["C"] if affine else [])):
        loop.field(name)
    if affine:
        second_moments(loop)
        for b in range(dim):
            h = loop.along("h", b)
            loop.line(f"M{b} = D{b} * {h} * {h}")
    loop.field("V")
    loop.total("mass", "m")
    for a in range(dim):
        loop.total(f"momentum_{'xyz'[a]}", f"m * v[{a}]")
    squares = " + ".join(f"v[{a}] * v[{a}]" for a in range(dim))
    if affine:
        squares += "".join(f" + C[{3 * a + b}] * C[{3 * a + b}] * M{b}" for a in range(dim) for b in range(dim))
    loop.total("kinetic", f"T(0.5) * m * ({squares})")
    for axis, (a, b) in enumerate(((1, 2), (2, 0), (0, 1))):
        if a < dim and b < dim:
            spin = f" + C[{3 * b + a}] * M{a} - C[{3 * a + b}] * M{b}" if affine else ""
            loop.total(f"angular_{'xyz'[axis]}", f"m * (x[{a}] * v[{b}] - x[{b}] * v[{a}]{spin})")
    loop.total("volume", "V")
    for hook, column in (("energy", "stored"), ("dissipation", "dissipated")):
        if hook in group.hooks:
            loop.total(column, f"V0 * {loop.material(hook, {})}")
    return "Mass, momentum, angular momentum and energies of one body"


def _mass_matrix(loop: ParticleLoop, operator: Any) -> str:
    """Consistent mass matrix m_ij = sum_p m_p N_i N_j (eq 1-14 of SAND2002-0482) into a dense array, `number` maps nodes to rows."""
    loop.field("m")
    for a in range(loop.dim):
        loop.along("h", a), loop.along("inv_h", a)
    header, pad = operator.nodes_loop(loop.nodes)
    first = [*header, f"{pad}rows[count] = number[i]", f"{pad}ws[count] = w", f"{pad}count += 1"]
    outer = ["for q in range(count):", "    for s in range(count):", "        M[rows[q], rows[s]] += m * ws[q] * ws[s]"]
    return each_particle(
        loop, operator, f"mass_matrix_{loop.group.name}", "Consistent mass matrix", ["count = 0", *first, *outer], "M, number, rows, ws"
    )


def _edge(c: Composition) -> list[str]:
    """How near a particle may come to a node of a kinked shape function, and to a face where weights are folded, in cells.

    The moments of folded weights are differences, of which the square root of the last digit is left at that distance.
    """
    if c.shape is None:
        return []
    eps = float(np.finfo(c.sim.precision).eps)
    return [f"edge = T({64.0 * eps!r})"] * (not c.shape.smooth) + [f"face = T({eps**0.5!r})"] * (c.shape.nodes > 2)


def _header(c: Composition, names: Names, layout: NodeLayout) -> str:
    # Only kinds of components: their values are run-time parameters and do not belong to the text.
    sim = c.sim
    kinds = [
        type(x).__name__
        for x in (sim.shape, sim.integrator, sim.discretization, *sim.boundaries, *sim.contacts, *sim.effects)
        if x is not None
    ]
    lines = [
        f'"""One step of a simulation composed of {", ".join(kinds)}',
        f"in {c.grid.space} with {', '.join(g.name for g in c.groups)}, {sim.precision}. Written by mpmkit "
        f"{mpmkit.__version__}; edit the components, not this file.",
        "",
        "P: particles of one body, component k of particle p at P[(p >> 4) * 16 R + 16 k + (p & 15)], sorted by block and cell.",
        f"G: nodes, channel c of node i at G[{layout.size} i + c]; channels: "
        + ", ".join(f"{n} {s}" for n, s in layout.start.items())
        + ".",
        "sc: rows of 16 lanes, one number of 16 particles in each; tr: the same by particle. par: run-time parameters. U: an index without",
        "the test for negative numbers. Component functions are filled in when this module is loaded:",
    ]
    for name, f in names.functions.items():
        lines.append(f"    {name} = {f.__module__}.{f.__qualname__}")
    lines += [
        '"""',
        "",
        "from math import sqrt",
        "",
        "from numpy import floor, int32",
        "from numpy import uintp as U",
        "",
        "zero, one = T(0), T(1)",
        *_edge(c),
        "",
        "",
        "",
    ]
    return "\n".join(lines)
