"""Assembles the text of one loop over particles from its sections."""

from __future__ import annotations

import textwrap
from typing import Any

from mpmkit._core.composing.layout import LANES, NodeLayout
from mpmkit._core.composing.pieces import PIECES
from mpmkit._core.composing.source import ParticleLoop


def fused_function(loop: ParticleLoop, layout: NodeLayout, operator: Any, name: str, verbs: list[str], channel: dict[str, str]) -> str:
    """One function whose loop does several verbs."""
    loop.first = "p2g" in verbs
    for verb in verbs:
        PIECES[verb](loop, layout, "gather", channel)
    _fields_of_weights(loop)
    loop.in_middle = True
    for verb in verbs:
        PIECES[verb](loop, layout, "compute", channel)
    return particle_function(loop, layout, operator, name, "; ".join(loop.titles))


def _fields_of_weights(loop: ParticleLoop) -> None:
    """Make what the weights need available before anything is changed."""
    shape = loop.composition.shape
    if shape is not None and not loop.composition.stored_operator:
        loop.field("x")
        if loop.composition.keeps_size and not loop.first:
            loop.field("size_now")
        elif shape.particle_size != "none":
            loop.field("size")
            if shape.particle_size == "current":
                loop.field("F")


def particle_function(
    loop: ParticleLoop, layout: NodeLayout, operator: Any, name: str, doc: str, *, extra: str = "", chosen: bool = False
) -> str:
    """Text of a compiled function over all particles of a body, or over a chosen list of them."""
    gathers, scatters = bool(loop.gather), bool(loop.scatter)
    if gathers or scatters:
        _fields_of_weights(loop)
    inner = list(loop.load)
    if gathers or scatters:
        header, pad = operator.nodes_loop(loop, layout.size)  # first: it may ask for parameters
        inner += operator.weights(loop)
        header, pad = operator.nodes_loop(loop, layout.size)
    if gathers:
        inner += loop.gather_zero + header + [f"{pad}{line}" for line in loop.gather]
    inner += loop.middle
    if scatters:
        inner += header + [f"{pad}{line}" for line in loop.scatter]
    inner += loop.store_lines
    text = "\n".join(inner)
    sums = {
        "speed": ("zero", 0),
        "diffusion": ("zero", 1),
        "viscous": ("0.0", 2),
        "external": ("0.0", 5),
        "x_low": ("T(1e30)", 3),
        "x_high": ("T(-1e30)", 4),
    }
    used = {n: s for n, s in sums.items() if f"{n} = m" in text or f"\n{n} -= " in text or f"\n{n} += " in text}
    before = [f"{n} = {start}" for n, (start, _) in used.items()]
    after = [f"out[{slot}] {'+=' if n in ('viscous', 'external') else '='} {n}" for n, (_, slot) in used.items()]
    signature = f"{operator.arguments}, {extra}{'chosen, area, normals, arms, ' if chosen else ''}t, dt"
    lines = ["@compiled", f"def {name}({signature}):", textwrap.indent('"""' + _wrapped(doc) + '"""', "    ")]
    lines += [f"    {line}" for line in operator.head(loop) if gathers or scatters]
    lines += loop.parameter_lines()
    lines += [f"    {line}" for line in before]
    record = f"b = (p >> 4) * {loop.group.layout.size * LANES} + (p & 15)"
    lines += ["    for j in range(chosen.size):", "        p = chosen[j]"] if chosen else ["    for p in range(n):"]
    lines += [f"        {record}"] + [f"        {line}" for line in inner]
    lines += [f"    {line}" for line in after]
    return "\n".join(lines) + "\n"


def _wrapped(doc: str) -> str:
    return "\n".join(textwrap.wrap(doc[:1].upper() + doc[1:] + ".", 120))
