"""Assembles the text of one loop over particles: blocks, tiles of 16, sums over nodes, computation, terms for nodes."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from typing import Any

from mpmkit._core.composing.layout import LANES, NodeLayout, lane
from mpmkit._core.composing.pieces import PIECES
from mpmkit._core.composing.source import ParticleLoop

ACCOUNTS = ("speed", "diffusion", "moved", "inverted", "inside", "stretched", "viscous", "external")
"""Columns of the accounts of a block of particles, see `ParticleLoop.maximum`, `total` and `watch`."""

LINE = {"float64": 8, "float32": 16}  # numbers in a cache line
AHEAD = 6  # tiles: memory answers while the tiles before are worked on

START = {"max": "zero", "sum": "zero", "watch >": "one", "watch >=": "one"}


def fused_function(loop: ParticleLoop, operator: Any, name: str, verbs: list[str], channel: dict[str, str]) -> str:
    """The text of one loop that does several verbs."""
    loop.first = "p2g" in verbs
    for verb in verbs:
        PIECES[verb](loop, "before", channel)
    for verb in verbs:
        PIECES[verb](loop, "compute", channel)
    return particle_function(loop, operator, name, "; ".join(loop.titles))


def particle_function(loop: ParticleLoop, operator: Any, name: str, doc: str, accounts: tuple[str, ...] = ACCOUNTS) -> str:
    """Texts of the computation on one tile and of the loop over blocks that calls it."""
    nodes: NodeLayout = loop.nodes
    slot = operator.slots.count
    before: list[str] = []
    after: list[str] = []
    tile: list[str] = []
    if loop.sums or loop.terms or loop.asks_weights:
        tile += operator.prepare(loop)
    # before the visit to the nodes, which leaves the particles' memory alone
    record, line = loop.group.layout.size * LANES, LINE[loop.composition.sim.precision]
    ahead = [f"for line in range(0, {record}, {line}):", f"    prefetch(P, (tile + {AHEAD}) * {record} + line)"]
    loads: list[str] = []
    if loop.sums or not loop.terms:
        tile += ahead
    if loop.sums:
        first, gather, where, taken = operator.gather(loop, nodes, slot)
        before, tile = before + first, tile + gather
        loads = [f"{local} = {value}" for local, value in where.items()]
        slot += taken
    adds: list[str] = []
    scatter: list[str] = []
    if loop.terms:
        first, adds, scatter, after, taken = operator.scatter(loop, nodes, slot)
        before = before + first
        slot += taken
    at = {account: slot + k for k, account in enumerate(loop.accounts)}
    loop.most_slots = slot + len(at)
    compute = [*loads, *loop.lines, *adds, *loop.store_lines]
    compute = [re.sub(r"\$(\w+)", lambda m: lane(at[m[1]]), line) for line in compute]
    tile.append(f"{name}_tile(P, tile, l0, l1, par, sc, t, dt)")
    tile += ([] if loop.sums else ahead) + scatter if loop.terms else []
    body = textwrap.indent('"""' + _wrapped(doc) + '"""', "    ")
    text = ["@compiled", f"def {name}_tile(P, tile, l0, l1, par, sc, t, dt):", body, "    wide()", *loop.parameter_lines()]
    text += [f"    b = tile * {loop.group.layout.size * LANES}", "    for l in range(l0, l1):", *(f"        {line}" for line in compute)]
    text += ["", "", "@compiled", f"def {name}({operator.arguments}, {operator.scratch}, t, dt):"]
    text += [f'    """Blocks first to last of: {", ".join(loop.verbs) or doc[:1].lower() + doc[1:]}."""', "    mode = tiny_to_zero()"]
    text += ["    for block in range(first, last):"]
    text += [f"        {line}" for line in before]
    if at:
        text += ["        for l in range(16):"]
        text += [f"            {lane(s)} = {START[loop.accounts[account]]}" for account, s in at.items()]
    text += [
        "        p0, p1 = starts[U(block)], starts[U(block + 1)]",
        "        for tile in range(p0 >> 4, (p1 + 15) >> 4):",
        "            l0, l1 = max(p0 - 16 * tile, 0), min(p1 - 16 * tile, 16)",
        *(f"            {line}" for line in tile),
        *(f"        {line}" for line in after),
    ]
    for account, s in at.items():
        kind, column = loop.accounts[account], f"acc[U({len(accounts)} * block + {accounts.index(account)})]"
        one = {
            "max": f"{lane(s)} if not ({lane(s)} <= most) else most",
            "sum": f"most + {lane(s)}",
            "watch >": f"most if {lane(s)} > zero else 1.0",
            "watch >=": f"most if {lane(s)} >= zero else 1.0",
        }[kind]
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
