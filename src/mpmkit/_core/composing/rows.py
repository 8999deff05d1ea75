"""Text of the sums over a particle's nodes and of the terms added to them, one row of nodes along the last axis at a time.

A row with its channels is one vector (or two): channel c of node k at lane k W + c, W channels in a window. The products of
the weights along the axes are taken one axis after the other, so that a node costs one or two fused multiply-adds.
"""

from __future__ import annotations

from mpmkit._core.composing.layout import LANES, Slots, lane


def stride(results: int, width: int) -> int:
    """Numbers per particle in the transposed scratch: whole blocks of 8."""
    return -(-results * width // 8) * 8


def pieces(nodes: int, width: int, itemsize: int) -> list[tuple[int, int]]:
    """A row as vectors: (first lane, lanes).

    One vector for each node where that fills 32 bytes: the arena begins a cache line, and no vector then lies across two.
    Smaller records share vectors; lanes beyond the row belong to the next node and get weight zero.
    """
    if width * itemsize >= 32:
        return [(k * width, width) for k in range(nodes)]
    out, first, lanes = [], 0, nodes * width
    while first < lanes:
        n = 1 << ((lanes - first).bit_length() - 1)
        if n != lanes - first and n < 16:
            n *= 2
        out.append((first, min(n, 32)))
        first += out[-1][1]
    return out


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


def gather_function(name: str, slots: Slots, side: int, width: int, kinds: list[str], itemsize: int) -> str:
    """sum_i u_i N_i, and with "k" or "g" in `kinds` the sums with index moments or slopes, for a window of `width` channels.

    ``V`` is the sum so far, ``K1`` the one with moments along axis 1, ``G0`` with slopes along axis 0; ``sV`` and so on while the
    middle axis is summed up.
    """
    dim, n, last = slots.dim, slots.nodes, slots.dim - 1
    rows = pieces(n, width, itemsize)
    S = stride(len(results(dim, kinds)), width)
    lines = [*_row_weights(slots, rows, width, kinds), *_middle_weights(slots, kinds), f"node = int(ib[U(l)]) * {width}"]
    inner = ["V", *(f"{kind.upper()}{last - 1}" for kind in kinds)]  # sums over the axis next to the last
    outer = [*inner, *(f"{kind.upper()}0" for kind in kinds)]
    if dim == 3:
        lines += [f"{s}_{p} = splat(zero, {lanes})" for p, (_, lanes) in enumerate(rows) for s in outer]
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
            for s, factor in zip(inner, ("w", *kinds), strict=True):
                begun = j > (factor == "k")  # index moments of node 0 are zero
                if j or factor != "k":
                    lines.append(f"{pad}{mark}{s}_{p} = {f'{mark}{s}_{p} + ' if begun else ''}{factor}{last - 1}_{j} * u{p}")
        if dim == 3:
            lines += [f"    {s}_{p} = {s}_{p} + w0 * s{s}_{p}" for s in inner]
            lines += [f"    {kind.upper()}0_{p} = {kind.upper()}0_{p} + {kind}0 * sV_{p}" for kind in kinds]
    for place, result in enumerate(results(dim, kinds)):
        of_last = result != "w" and int(result[1]) == last
        factor = f"{result[0]}_row" if of_last else "w_row"
        source = "V" if of_last or result == "w" else result.upper()
        some = [p for p, row in enumerate(rows) if factor != "k_row" or row != (0, width)]
        total = " + ".join(f"summed({factor}{p} * {source}_{p}, {width})" for p in some)
        lines.append(f"store(tr, {S} * l + {place * width}, {total})")
    told = ", ".join({"k": "u_i N_i k_b", "g": "u_i dN_i/dxi_b"}[kind] for kind in kinds)
    doc = f"Sums of u_i N_i{', ' + told if told else ''} over the nodes of each particle."
    return _function(name, "arena, l0, l1, sc, ib, tr", doc, lines)


def scatter_function(name: str, slots: Slots, side: int, width: int, kinds: list[str], itemsize: int) -> str:
    """Add A N_i + sum_b B_b (dN_i/dxi_b or N_i k_b) for a window of `width` channels; ``kinds[c]`` is "g", "k" or "" for channel c.

    ``z`` is the row without the weights of the other axes, ``q_b`` the row that still waits for a slope or moment along axis b.
    """
    dim, n, last = slots.dim, slots.nodes, slots.dim - 1
    rows, sloped = pieces(n, width, itemsize), any(kinds)
    S = stride(dim + 1 if sloped else 1, width)
    used: list[str] = [kind for kind in ("k", "g") if kind in kinds]
    mask = sum(1 << c for c, kind in enumerate(kinds) if kind == "g")

    def profile(kind: str, lanes: int, p: str = "") -> str:
        """Index moment or slope for each channel of a row: k for some, g for others."""
        if len(used) < 2:
            return f"{used[0]}{kind}{p}"
        whole = sum(mask << (k * width) for k in range(-(-lanes // width))) & ((1 << lanes) - 1)
        if p:
            return f"mixed(k{kind}{p}, g{kind}{p}, {whole})"
        return f"mixed(splat(k{kind}, {lanes}), splat(g{kind}, {lanes}), {whole})"

    lines = [*_row_weights(slots, rows, width, used), *_middle_weights(slots, used), f"node = int(ib[U(l)]) * {width}"]
    for p, row in enumerate(rows):
        lanes = row[1]
        lines.append(f"z{p} = w_row{p} * {_tiled(f'load(tr, {S} * l, {width})', width, lanes)}")
        if sloped:
            along = [_tiled(f"load(tr, {S} * l + {(a + 1) * width}, {width})", width, lanes) for a in range(dim)]
            if used != ["k"] or row != (0, width):  # index moments of node 0 are zero
                lines[-1] += f" + {profile('_row', lanes, str(p))} * {along[last]}"
            lines += [f"q{a}_{p} = w_row{p} * {along[a]}" for a in range(last)]
    if last and sloped and len(used) == 2:
        lines += [f"p{j}_{p} = {profile(f'{last - 1}_{j}', lanes)}" for j in range(n) for p, (_, lanes) in enumerate(rows)]
    pad = ""
    if dim == 3:
        lines.append(f"for j in range({n}):")
        pad = "    "
        lines += [f"{pad}{line}" for line in _outer_weights(slots, used)]
        for p, (_, lanes) in enumerate(rows):
            lines.append(f"{pad}y{p} = w0 * z{p}" + (f" + {profile('0', lanes)} * q0_{p}" if sloped else ""))
            if sloped:
                lines.append(f"{pad}x{p} = w0 * q1_{p}")
    for p, (first, lanes) in enumerate(rows):
        z, q = (f"y{p}", f"x{p}") if dim == 3 else (f"z{p}", f"q0_{p}")
        for j in range(n if last else 1):
            value = f"w{last - 1}_{j} * {z}" if last else z
            if last and sloped and (j or used != ["k"]):
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
        lines += [f"{kind}_row{p} = spread(({', '.join(values[kind])},), {width}, {lanes})" for kind in ("w", *kinds)]
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
    return vector if width == lanes else f"tiled({vector}, {lanes})"


def _function(name: str, arguments: str, doc: str, lines: list[str]) -> str:
    head = ["@compiled", f"def {name}({arguments}):", f'    """{doc}"""', "    for l in range(l0, l1):"]
    return "\n".join([*head, *(f"        {line}" for line in lines)]) + "\n"
