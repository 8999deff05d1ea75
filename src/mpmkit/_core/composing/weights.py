"""Text of the weights of 16 particles at a time: products over the directions are formed later, by the rows."""

from __future__ import annotations

from mpmkit._core.composing.layout import LANES, Slots, lane
from mpmkit._core.composing.sizes import half_size
from mpmkit._core.composing.source import ParticleLoop


def weights_function(loop: ParticleLoop, name: str, ghosts: int, side: int, slopes: bool, moved: bool) -> str:
    """Weights and, if asked for, slopes along each axis; the arena's number of each particle's first node into ``ib``."""
    c = loop.composition
    shape, dim = c.shape, loop.dim
    assert shape is not None
    n, slots = shape.nodes, Slots(loop.dim, shape.nodes)
    function = loop.names.of("weights", shape.weights.function)
    x = loop.field("x")
    lines = []
    for a in range(dim):
        lower, inv_h = loop.along("lower", a), loop.along("inv_h", a)
        last = loop.along("last", a)
        special = {"f": f"f{a}"}
        if not shape.smooth:
            # A particle on a node exactly would give its neighbour a force but no mass to carry it: momentum would be lost.
            special["f"] = f"min(max(f{a}, edge), T({n - 1}) - edge)"
        arguments = _arguments(loop, a, special)
        lines += [
            f"xi{a} = ({x}[{a}] - {lower}) * {inv_h}",
            f"i{a} = min(floor(xi{a} - T({shape.offset})), {last})",
            f"f{a} = xi{a} - i{a}",
            f"w, d = {function}({', '.join(arguments)})",
            *[f"{lane(slots.w(a, k))} = w[{k}]" for k in range(n)],
            *[f"{lane(slots.d(a, k))} = d[{k}]" for k in range(n) if slopes],
            f"{lane(slots.f(a))} = f{a}",
        ]
    if moved:  # perhaps too far: kept inside, see `cycle`
        place = ""
        for a in range(dim):
            one = f"min(max(int32(i{a} - c{a}), 0), {side - n})"
            place = f"({place}) * {side} + {one}" if a else one
        lines.append(f"ib[U(l)] = {place}")
    else:
        place = "i0 - c0"
        for a in range(1, dim):
            place = f"({place}) * T({side}) + i{a} - c{a}"
        lines.append(f"ib[U(l)] = int32({place})")
    head = [f"c{a} = T(corner[U(3 * block + {a})] - {ghosts})" for a in range(dim)]
    text = [
        "@compiled",
        f"def {name}(P, tile, l0, l1, corner, block, par, sc, ib):",
        f'    """{"Weights and slopes" if slopes else "Weights"} of the nodes around each particle, and its first node in the arena."""',
        "    wide()",
        *loop.parameter_lines(),
        f"    b = tile * {loop.group.layout.size * LANES}",
        *(f"    {line}" for line in head),
        "    for l in range(l0, l1):",
        *(f"        {line}" for line in (*loop.lines, *lines)),
    ]
    return "\n".join(text) + "\n"


def _arguments(loop: ParticleLoop, a: int, special: dict[str, str]) -> list[str]:
    """Arguments of the weights along axis a, at the place ``special["f"]``."""
    c, shape = loop.composition, loop.composition.shape
    assert shape is not None
    if shape.particle_size != "none":
        kept = c.keeps_size and not loop.first
        if shape.particle_size == "current" and not kept:
            special["half"] = f"{half_size(loop, a)} * {loop.along('inv_h', a)}"
        else:
            special["half"] = f"{loop.field('size_now' if kept else 'size')}[{a}] * {loop.along('inv_h', a)}"
    return [loop.argument(one, shape, "shape", "weights", special) for one in shape.weights.arguments]


def fold_function(loop: ParticleLoop, name: str) -> str:
    """Weights of nodes outside the domain folded into the two outermost, in the blocks at the boundary only.

    The outermost node then interpolates. A particle on it exactly would give its neighbour a force, or take a slope from it, but no
    mass to carry them: momentum would be lost, and a velocity gradient come from nothing. Its weights are those a little inside.
    """
    shape = loop.composition.shape
    assert shape is not None
    n, dim, slots = shape.nodes, loop.dim, Slots(loop.dim, shape.nodes)
    function = loop.names.of("weights", shape.weights.function)
    lines: list[str] = []
    for a in range(dim):
        lower, inv_h, last = loop.along("lower", a), loop.along("inv_h", a), loop.along("last", a)
        x = f"P[U(b + {(loop.group.layout.start['x'] + a) * LANES} + l)]"
        lines.append(f"i = int(min(floor(({x} - {lower}) * {inv_h} - T({shape.offset})), {last}))")
        lines.append(f"n = int({last}) + 1")
        lines.append(f"if i < 0 or i > n - {n - 1}:")
        place = lane(slots.f(a))
        lines += [
            f"    f = min(max({place}, face - T(i)), T(n - i) - face)",
            f"    if f != {place}:",
            f"        {place} = f",
            f"        w, d = {function}({', '.join(_arguments(loop, a, {'f': 'f'}))})",
            *(f"        {lane(row(a, k))} = {values}[{k}]" for values, row in (("w", slots.w), ("d", slots.d)) for k in range(n)),
        ]
        for row in (slots.w, slots.d):
            lines.append(f"    w = fold(({', '.join(lane(row(a, k)) for k in range(n))}), i, n)")
            lines += [f"    {lane(row(a, k))} = w[{k}]" for k in range(n)]
    text = [
        "@compiled",
        f"def {name}(P, tile, l0, l1, par, sc):",
        '    """The weights of nodes outside the domain folded into the outermost ones."""',
        *loop.parameter_lines(),
        f"    b = tile * {loop.group.layout.size * LANES}",
        "    for l in range(l0, l1):",
        *(f"        {line}" for line in (*loop.lines, *lines)),
    ]
    return "\n".join(text) + "\n"


def fold_rule(nodes: int) -> str:
    """`fold`, which continues a field linearly: the value at a missing node is 2 v_0 - v_1."""

    def row(factors: list[list[int]]) -> str:
        terms = []
        for k in range(nodes):
            parts = [f"T({f}) * w[{j}]" if f != 1 else f"w[{j}]" for j, f in enumerate(factors[k]) if f]
            terms.append(" + ".join(parts) or "zero")
        return f"({', '.join(terms)})"

    def identity() -> list[list[int]]:
        return [[int(j == k) for j in range(nodes)] for k in range(nodes)]

    lines = [
        "@compiled",
        "def fold(w, i, n):",
        '    """Nodes outside the domain folded into the two outermost, as if the field went on linearly: v_-1 = 2 v_0 - v_1."""',
    ]
    for ghosts in range(1, nodes - 1):
        factors = identity()
        for k in range(ghosts):
            distance = ghosts - k
            factors[ghosts][k], factors[ghosts + 1][k] = 1 + distance, -distance
            factors[k][k] = 0
        lines += [f"    if i == {-ghosts}:", f"        w = {row(factors)}"]
    for last in range(1, nodes - 1):  # position of the outermost upper node among the particle's nodes
        factors = identity()
        for k in range(last + 1, nodes):
            distance = k - last
            factors[last][k], factors[last - 1][k] = 1 + distance, -distance
            factors[k][k] = 0
        lines += [f"    if i == n - {last}:", f"        w = {row(factors)}"]
    lines.append("    return w")
    return "\n".join(lines) + "\n"
