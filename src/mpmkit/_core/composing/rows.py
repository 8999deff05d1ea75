"""Text of the sums over a particle's nodes and of the terms added to them, one row of nodes along the last axis at a time.

A row with its channels is one vector or a few: channel c of node k at lane k W + c, W channels in a window. The products of
the weights along the axes are taken one axis after the other, so that a node costs one or two fused multiply-adds.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import permutations

from mpmkit._core.composing.layout import LANES, Slots, lane


def stride(results: int, width: int) -> int:
    """Numbers per particle in the transposed scratch: whole blocks of 8."""
    return -(-results * width // 8) * 8


def pieces(nodes: int, asked: list[str], itemsize: int) -> list[tuple[int, int]]:
    """A row as vectors: (first lane, lanes).

    Vectors of one node where that fills 32 bytes: the arena begins a cache line, and few vectors then lie across two.
    Smaller records share vectors; lanes beyond the row belong to the next node and get weight zero.
    """
    width = len(asked)
    if width * itemsize >= 32:
        # in the order in which channels that ask for much share vectors with the fewest that do not
        cuts = [whole(width, order) for order in permutations(k for k in reversed(range(width.bit_length())) if width >> k & 1)]
        best = min(cuts, key=lambda cut: sum(len(set("".join(_of_row(asked, row)))) * row[1] for row in cut))
        return [(k * width + first, lanes) for k in range(nodes) for first, lanes in best]
    out, first, lanes = [], 0, nodes * width
    while first < lanes:
        n = 1 << ((lanes - first).bit_length() - 1)
        if n != lanes - first and n < 16:
            n *= 2
        out.append((first, min(n, 32)))
        first += out[-1][1]
    return out


def whole(width: int, order: Sequence[int] = ()) -> list[tuple[int, int]]:
    """Vectors that together have `width` lanes: (first lane, lanes), in the given order of the bits of `width`, or the longest first."""
    lanes = [1 << k for k in order or reversed(range(width.bit_length())) if width >> k & 1]
    return [(sum(lanes[:k]), n) for k, n in enumerate(lanes)]


def transposed(to_lanes: bool, first_slot: int, S: int, wanted: set[int]) -> list[str]:
    """Lines that move the wanted of S numbers of 16 particles between rows of lanes in ``sc`` and particles in ``tr``, 8 x 8 at a time."""
    lines = []
    for s in sorted({number // 8 * 8 for number in wanted}):
        for half in (0, 8):
            rows, particles = f"sc, {LANES * (first_slot + s) + half}, {LANES}", f"tr, {S * half + s}, {S}"
            lines.append(f"transpose({particles}, {rows})" if to_lanes else f"transpose({rows}, {particles})")
    return lines


def results(dim: int, kinds: list[str]) -> list[str]:
    """What a gather leaves, in this order: sums with N ("w"), with N k_b and with dN/dxi_b."""
    return ["w", *(f"{kind}{a}" for kind in kinds for a in range(dim))]


def gather_function(name: str, slots: Slots, side: int, width: int, asked: list[str], itemsize: int) -> str:
    """Sums over nodes for a window of channels: u_i N_i where ``asked[c]`` has "w", with index moments for "k", with slopes for "g".

    A vector gets the sums that one of its channels asks for.
    ``V`` is the sum so far, ``K1`` the one with moments along axis 1, ``G0`` with slopes along axis 0; ``sV`` and so on while the
    middle axis is summed up.
    """
    dim, n, last = slots.dim, slots.nodes, slots.dim - 1
    rows = [row for row in pieces(n, asked, itemsize) if any(_of_row(asked, row))]
    own = ["".join(_of_row(asked, row)) for row in rows]
    kinds = kinds_of(asked)
    S = stride(len(results(dim, kinds)), width)
    lines = [*_row_weights(slots, rows, width, kinds), *_middle_weights(slots, kinds), f"node = int(ib[U(l)]) * {width}"]
    factors = [["w", *(kind for kind in kinds if kind in one)] for one in own]
    inner = [["V", *(f"{kind.upper()}{last - 1}" for kind in one[1:])] for one in factors]  # sums over the axis next to the last
    if dim == 3:
        outer = [[*some, *(f"{kind.upper()}0" for kind in one[1:])] for some, one in zip(inner, factors, strict=True)]
        lines += [f"{s}_{p} = splat(zero, {lanes})" for p, (_, lanes) in enumerate(rows) for s in outer[p]]
        lines.append(f"for j in range({n}):")
        lines += [f"    {line}" for line in _outer_weights(slots, kinds)]
    pad, mark = ("    ", "s") if dim == 3 else ("", "")
    for p, (first, lanes) in enumerate(rows):
        for j in range(n if last else 1):
            at = f"node + {'' if dim < 3 else f'{side * side * width} * j + '}{(j * side if last else 0) * width + first}"
            lines.append(f"{pad}u{p} = load(arena, {at}, {lanes})")
            if not last:
                lines.append(f"V_{p} = u{p}")
                continue
            for s, factor in zip(inner[p], factors[p], strict=True):
                begun = j > (factor == "k")  # index moments of node 0 are zero
                if j or factor != "k":
                    lines.append(f"{pad}{mark}{s}_{p} = {f'{mark}{s}_{p} + ' if begun else ''}{factor}{last - 1}_{j} * u{p}")
        if dim == 3:
            lines += [f"    {s}_{p} = {s}_{p} + w0 * s{s}_{p}" for s in inner[p]]
            lines += [f"    {kind.upper()}0_{p} = {kind.upper()}0_{p} + {kind}0 * sV_{p}" for kind in factors[p][1:]]
    for place, result in enumerate(results(dim, kinds)):
        of_last = result != "w" and int(result[1]) == last
        factor = f"{result[0]}_row" if of_last else "w_row"
        source = "V" if of_last or result == "w" else result.upper()
        for begin in sorted({first % width for first, _ in rows}):
            some = [p for p, (first, n) in enumerate(rows) if first % width == begin and (factor != "k_row" or first + n > width)]
            if result[0] not in factors[some[0]]:
                continue
            total = " + ".join(f"summed({factor}{p} * {source}_{p}, {min(width, rows[p][1])})" for p in some)
            lines.append(f"store(tr, {S} * l + {place * width + begin}, {total})")
    told = ", ".join({"k": "u_i N_i k_b", "g": "u_i dN_i/dxi_b"}[kind] for kind in kinds)
    doc = f"Sums of u_i N_i{', ' + told if told else ''} over the nodes of each particle."
    return _function(name, "arena, l0, l1, sc, ib, tr", doc, lines)


def kinds_of(asked: list[str]) -> list[str]:
    """What is asked for beside the plain sums or terms, in order."""
    return [kind for kind in ("k", "g") if any(kind in one for one in asked)]


def _of_row(asked: list[str], row: tuple[int, int]) -> list[str]:
    """What the channels of a vector ask for."""
    return [asked[lane % len(asked)] for lane in range(row[0], sum(row))]


def scatter_function(name: str, slots: Slots, side: int, width: int, kinds: list[str], itemsize: int) -> str:
    """Add A N_i + sum_b B_b (dN_i/dxi_b or N_i k_b) for a window of `width` channels; ``kinds[c]`` is "g", "k" or "" for channel c.

    ``z`` is the row without the weights of the other axes, ``q_b`` the row that still waits for a slope or moment along axis b.
    """
    dim, n, last = slots.dim, slots.nodes, slots.dim - 1
    rows, used = pieces(n, kinds, itemsize), kinds_of(kinds)
    S = stride(dim + 1 if used else 1, width)
    sloped = [any(_of_row(kinds, row)) for row in rows]  # of vectors without slopes or moments only the plain terms are added
    mask = sum(1 << c for c, kind in enumerate(kinds) if kind == "g")

    def profile(kind: str, row: tuple[int, int], p: str = "") -> str:
        """Index moment or slope for each channel of a row: k for some, g for others."""
        if len(used) < 2:
            return f"{used[0]}{kind}{p}"
        first, lanes = row
        bits = sum(mask << (k * width) for k in range(-(-lanes // width) + 1)) >> first % width & ((1 << lanes) - 1)
        if p:
            return f"mixed(k{kind}{p}, g{kind}{p}, {bits})"
        return f"mixed(splat(k{kind}, {lanes}), splat(g{kind}, {lanes}), {bits})"

    lines = [*_row_weights(slots, rows, width, used), *_middle_weights(slots, used), f"node = int(ib[U(l)]) * {width}"]
    for p, row in enumerate(rows):
        begin, lanes = row[0] % width, row[1]
        values = [_tiled(f"load(tr, {S} * l + {a * width + begin}, {min(width, lanes)})", width, lanes) for a in range(dim + 1)]
        lines.append(f"z{p} = w_row{p} * {values[0]}")
        if sloped[p]:
            along = values[1:]
            if used != ["k"] or sum(row) > width:  # index moments of node 0 are zero
                lines[-1] += f" + {profile('_row', row, str(p))} * {along[last]}"
            lines += [f"q{a}_{p} = w_row{p} * {along[a]}" for a in range(last)]
    if last and len(used) == 2:
        lines += [f"p{j}_{p} = {profile(f'{last - 1}_{j}', row)}" for j in range(n) for p, row in enumerate(rows) if sloped[p]]
    pad = ""
    if dim == 3:
        lines.append(f"for j in range({n}):")
        pad = "    "
        lines += [f"{pad}{line}" for line in _outer_weights(slots, used)]
        for p, row in enumerate(rows):
            lines.append(f"{pad}y{p} = w0 * z{p}" + (f" + {profile('0', row)} * q0_{p}" if sloped[p] else ""))
            if sloped[p]:
                lines.append(f"{pad}x{p} = w0 * q1_{p}")
    for p, (first, lanes) in enumerate(rows):
        z, q = (f"y{p}", f"x{p}") if dim == 3 else (f"z{p}", f"q0_{p}")
        for j in range(n if last else 1):
            value = f"w{last - 1}_{j} * {z}" if last else z
            if last and sloped[p] and (j or used != ["k"]):
                value += f" + {f'p{j}_{p}' if len(used) == 2 else f'{used[0]}{last - 1}_{j}'} * {q}"
            at = f"node + {'' if dim < 3 else f'{side * side * width} * j + '}{(j * side if last else 0) * width + first}"
            lines.append(f"{pad}store(arena, {at}, load(arena, {at}, {lanes}) + {value})")
    return _function(name, "arena, l0, l1, sc, ib, tr", "Add the terms of each particle to its nodes.", lines)


def _row_weights(slots: Slots, rows: list[tuple[int, int]], width: int, kinds: list[str]) -> list[str]:
    """Weights, index moments and slopes along the last axis as vectors."""
    last, lines = slots.dim - 1, []
    for p, (first, lanes) in enumerate(rows):
        nodes = range(first // width, min(slots.nodes, -(-(first + lanes) // width)))
        values = {
            "w": [lane(slots.w(last, k)) for k in nodes],
            "k": [f"T({k}) * {lane(slots.w(last, k))}" for k in nodes],
            "g": [lane(slots.d(last, k)) for k in nodes],
        }
        lines += [f"{kind}_row{p} = spread(({', '.join(values[kind])},), {min(width, lanes)}, {lanes})" for kind in ("w", *kinds)]
    return lines


def _middle_weights(slots: Slots, kinds: list[str]) -> list[str]:
    """Weights, index moments and slopes of each node along the axis next to the last; read once, for stores would make LLVM read again."""
    lines, a = [], slots.dim - 2
    for j in range(slots.nodes if a >= 0 else 0):
        lines.append(f"w{a}_{j} = {lane(slots.w(a, j))}")
        lines += [f"k{a}_{j} = T({j}) * w{a}_{j}"] if "k" in kinds else []
        lines += [f"g{a}_{j} = {lane(slots.d(a, j))}"] if "g" in kinds else []
    return lines


def _outer_weights(slots: Slots, kinds: list[str]) -> list[str]:
    """The same of node j along the first of three axes."""
    w, d = slots.w(0, 0) * LANES, slots.d(0, 0) * LANES
    lines = [f"w0 = sc[U({w} + {LANES} * j + l)]"]
    lines += ["k0 = T(j) * w0"] if "k" in kinds else []
    return lines + ([f"g0 = sc[U({d} + {LANES} * j + l)]"] if "g" in kinds else [])


def _tiled(vector: str, width: int, lanes: int) -> str:
    return vector if width >= lanes else f"tiled({vector}, {lanes})"


def _function(name: str, arguments: str, doc: str, lines: list[str]) -> str:
    head = ["@compiled", f"def {name}({arguments}):", f'    """{doc}"""', "    for l in range(l0, l1):"]
    return "\n".join([*head, *(f"        {line}" for line in lines)]) + "\n"
