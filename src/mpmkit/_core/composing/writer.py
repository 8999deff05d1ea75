"""Assembles the text of one loop over particles: blocks, tiles of 16, sums over nodes, computation, terms for nodes."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import Any

import attrs

from mpmkit._core.composing.layout import LANES, NodeLayout, lane
from mpmkit._core.composing.pieces import PIECES
from mpmkit._core.composing.source import ParticleLoop

ACCOUNTS = ("speed", "diffusion", "moved", "inverted", "inside", "stretched", "viscous", "external", "motion")
"""Columns of the accounts of a block of particles, see `ParticleLoop.maximum`, `total` and `watch`."""

LINE = {"float64": 8, "float32": 16}  # numbers in a cache line
AHEAD = 6  # tiles: memory answers while the tiles before are worked on

MOST_ACCOUNTS = 11  # rows of lanes kept for accounts, before those of sums and terms

START = {"max": "zero", "sum": "zero", "watch >": "one", "watch >=": "one"}


@attrs.define
class Written:
    """The text of a loop over particles in its parts: before, in and after the tiles of a block."""

    name: str
    doc: str
    verbs: tuple[str, ...]
    computation: str
    accounts: dict[str, str]
    columns: tuple[str, ...]
    before: list[str]
    weights: list[str]
    ahead: list[str]
    gather: list[str]
    scatter: list[str]
    after: list[str]

    def tile(self, time: str = "t") -> list[str]:
        """Lines for the 16 particles of a tile without the weights; memory is asked for before nodes are visited, which leaves it alone."""
        call = [f"{self.name}_tile(P, tile, l0, l1, par, sc, {time}, dt)"]
        if self.gather or not self.scatter:
            return [*self.ahead, *self.gather, *call, *self.scatter]
        return [*call, *self.ahead, *self.scatter]


def written(loop: ParticleLoop, operator: Any, name: str, verbs: list[str], channel: dict[str, str]) -> Written:
    """The text of one loop that does several verbs."""
    loop.first = "p2g" in verbs
    loop.verbs = tuple(verbs)
    for verb in verbs:
        PIECES[verb](loop, "before", channel)
    for verb in verbs:
        PIECES[verb](loop, "compute", channel)
    return in_parts(loop, operator, name, "; ".join(loop.titles))


def in_parts(loop: ParticleLoop, operator: Any, name: str, doc: str, columns: tuple[str, ...] = ACCOUNTS) -> Written:
    """Turn what a loop asks for into text; `columns` are those of the accounts of a block."""
    nodes: NodeLayout = loop.nodes
    at = {account: operator.slots.count + columns.index(account) for account in loop.accounts}
    slot = operator.slots.count + MOST_ACCOUNTS
    before: list[str] = []
    after: list[str] = []
    gather: list[str] = []
    scatter: list[str] = []
    weights = operator.prepare(loop) if loop.sums or loop.terms or loop.asks_weights else []
    record, line = loop.group.layout.size * LANES, LINE[loop.composition.sim.precision]
    ahead = [f"for line in range(0, {record}, {line}):", f"    prefetch(P, (tile + {AHEAD}) * {record} + line)"]
    loads: list[str] = []
    if loop.sums:
        first, gather, where, taken = operator.gather(loop, nodes, slot)
        before = before + first
        loads = [f"{local} = {value}" for local, value in where.items()]
        slot += taken
    adds: list[str] = []
    if loop.terms:
        first, adds, scatter, after, taken = operator.scatter(loop, nodes, slot)
        before = before + first
        slot += taken
    loop.most_slots = slot
    compute = [*loads, *loop.lines, *adds, *loop.store_lines]
    compute = [re.sub(r"\$(\w+)", lambda m: lane(at[m[1]]), one) for one in compute]
    body = textwrap.indent('"""' + _wrapped(doc) + '"""', "    ")
    text = ["@compiled", f"def {name}_tile(P, tile, l0, l1, par, sc, t, dt):", body, "    wide()", *loop.parameter_lines()]
    text += [f"    b = tile * {record}", "    for l in range(l0, l1):", *(f"        {one}" for one in compute)]
    return Written(name, doc, loop.verbs, "\n".join(text), dict(loop.accounts), columns, before, weights, ahead, gather, scatter, after)


def alone(w: Written, operator: Any, only: str = "") -> str:
    """The computation on a tile, and the loop over blocks that calls it; with `only`, the name of an array, over those marked there."""
    told = ", ".join(w.verbs) or w.doc[:1].lower() + w.doc[1:]
    arguments = f"{operator.arguments}, {only}" if only else operator.arguments
    before = [f"if not {only}[U(block)]:", "    continue", *w.before] if only else w.before
    loop = _over_blocks(w.name, told, arguments, operator, w, before, [*w.weights, *w.tile()], w.after)
    return w.computation + "\n\n\n" + loop


def cycle(name: str, last: Written, first: Written, moved: list[str], operator: Any) -> str:
    """The last loop of a step and the first of the next in one pass: from the nodes of the one, in G, to those of the other, in H.

    `moved` are the weights at the positions after the step. A particle that has strayed from the arena is kept inside; the pass is
    then thrown away (`Engine.step`).
    """
    arguments = operator.arguments.replace("G, par", "G, H, par")
    tile = [*last.weights, *last.tile(), *moved, *(line for line in first.tile("t + dt") if line not in first.ahead)]
    after = [*last.after, *(line.replace("(far, G,", "(far, H,") for line in first.after)]
    told = f"{', '.join(last.verbs)}, and {', '.join(first.verbs)} of the next step"
    return _over_blocks(name, told, arguments, operator, last, [*last.before, *first.before], tile, after)


def _over_blocks(
    name: str, told: str, arguments: str, operator: Any, w: Written, before: list[str], tile: list[str], after: list[str]
) -> str:
    at = {account: operator.slots.count + w.columns.index(account) for account in w.accounts}
    text = ["@compiled", f"def {name}({arguments}, {operator.scratch}, t, dt):", f'    """Blocks first to last of: {told}."""']
    text += ["    mode = tiny_to_zero()", "    for block in range(first, last):", *(f"        {line}" for line in before)]
    if at:
        text += ["        for l in range(16):"]
        text += [f"            {lane(s)} = {START[w.accounts[account]]}" for account, s in at.items()]
    text += [
        "        p0, p1 = starts[U(block)], starts[U(block + 1)]",
        "        for tile in range(p0 >> 4, (p1 + 15) >> 4):",
        "            l0, l1 = max(p0 - 16 * tile, 0), min(p1 - 16 * tile, 16)",
        *(f"            {line}" for line in tile),
        *(f"        {line}" for line in after),
    ]
    for account, s in at.items():
        column = f"acc[U({len(w.columns)} * block + {w.columns.index(account)})]"
        one = {
            "max": f"{lane(s)} if not ({lane(s)} <= most) else most",
            "sum": f"most + {lane(s)}",
            "watch >": f"most if {lane(s)} > zero else 1.0",
            "watch >=": f"most if {lane(s)} >= zero else 1.0",
        }[w.accounts[account]]
        text += ["        most = 0.0", "        for l in range(16):", f"            most = {one}", f"        {column} = most"]
    text.append("    as_before(mode)")
    return "\n".join(text) + "\n"


def _wrapped(doc: str) -> str:
    return "\n".join(textwrap.wrap(doc[:1].upper() + doc[1:] + ".", 120))


def each_particle(
    loop: ParticleLoop, operator: Any, name: str, doc: str, lines: list[str], extra: str, only: str = "", before: Sequence[str] = ()
) -> str:
    """Text of a loop that visits particles one by one: for the few that meet special nodes, or for small problems."""
    loop.asks_slopes = True
    text = ["@compiled", f"def {name}({operator.arguments}, {extra}, sc, ib, t, dt):", f'    """{doc}."""', *loop.parameter_lines()]
    text += ["    for block in range(first, last):"]
    text += [f"        if not {only}:", "            continue"] if only else []
    text += [f"        {line}" for line in before]
    text += [
        "        p0, p1 = starts[U(block)], starts[U(block + 1)]",
        "        for tile in range(p0 >> 4, (p1 + 15) >> 4):",
        "            l0, l1 = max(p0 - 16 * tile, 0), min(p1 - 16 * tile, 16)",
        *(f"            {line}" for line in operator.prepare(loop)),
        f"            b = tile * {loop.group.layout.size * LANES}",
        "            for l in range(l0, l1):",
        *(f"                {line}" for line in (*loop.lines, *lines)),
    ]
    return "\n".join(text) + "\n"


def on_demand(loop: ParticleLoop, name: str, field: str) -> str:
    """Text of a loop that computes a field no step keeps, into tiles of its own like those of P: for output."""
    value, stored = loop.field(field), loop.group.layout.stored(field)
    text = ["@compiled", f"def {name}(first, last, count, P, par, D):", f'    """The {field} of the particles in tiles first to last."""']
    text += ["    wide()", *loop.parameter_lines(), "    for tile in range(first, last):"]
    text += [f"        b = tile * {loop.group.layout.size * LANES}", "        for l in range(min(16, count - 16 * tile)):"]
    text += [f"            {line}" for line in loop.lines]
    text += [f"            D[U(tile * {LANES * len(stored)} + {LANES * k} + l)] = {value}[{full}]" for k, full in enumerate(stored)]
    return "\n".join(text) + "\n"
