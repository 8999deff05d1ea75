"""The operators N_ip and G_ip in the text of a particle loop: rebuilt from a grid, or read from neighbour lists.

Everything else of a loop only knows nodes ``i``, weights ``w``, gradients ``g0, g1, g2`` and distances ``r0, r1, r2``.
"""

from __future__ import annotations

from math import ceil

from mpmkit._core.composing.source import ParticleLoop


class GridOperator:
    """MPM: products over the directions of a shape function's weights at the particle's position."""

    arguments = "P, n, G, par, lat, out, flag"

    def __init__(self, nodes: int, offset: float) -> None:
        self.nodes = nodes
        self.ghosts = ceil(offset)  # nodes kept outside the lower faces, whose weights are folded to zero
        self.offset = offset

    @property
    def padding(self) -> tuple[int, int]:
        """Nodes stored beyond the lower and the upper face in each direction."""
        return self.ghosts, self.nodes - 2

    def head(self, loop: ParticleLoop) -> list[str]:
        dim = loop.dim
        lines = [f"n{a} = lat[{a}]" for a in range(dim)]
        return lines + [f"s{a} = lat[{3 + a}]" for a in range(dim)]

    def weights(self, loop: ParticleLoop) -> list[str]:
        """Lines that compute w0, d0, w1, d1 ...; they run before anything is gathered."""
        c = loop.composition
        assert c.shape is not None
        shape = c.shape
        name = loop.names.of("weights", shape.weights.function)
        x = loop.field("x")
        lines = []
        for a in range(loop.dim):
            lower = loop.along("lower", a)
            inv_h = loop.along("inv_h", a)
            special = {"f": f"xi{a} - T(i{a})"}
            if not shape.smooth:
                # A particle on a node exactly would give its neighbour a force but no mass to carry it: momentum would be lost.
                special["f"] = f"min(max({special['f']}, edge), T({self.nodes - 1}) - edge)"
            if shape.particle_size != "none":
                kept = c.keeps_size and not loop.first
                half = f"{loop.field('size_now' if kept else 'size')}[{a}] * {inv_h}"
                special["half"] = f"{half} * {loop.field('F')}[{4 * a}]" if shape.particle_size == "current" and not kept else half
            arguments = [loop.argument(n, shape, "shape", "weights", special) for n in shape.weights.arguments]
            lines += [
                f"xi{a} = ({x}[{a}] - {lower}) * {inv_h}",
                f"i{a} = min(int(floor(xi{a} - T({self.offset}))), n{a} - 1)",
                f"w{a}, d{a} = {name}({', '.join(arguments)})",
                f"if i{a} < 0 or i{a} > n{a} - {self.nodes - 1}:",
                f"    w{a}, d{a} = fold(w{a}, i{a}, n{a}), fold(d{a}, i{a}, n{a})",
            ]
            if loop.needs & {"r", "moment"}:
                lines.append(f"f{a} = xi{a} - T(i{a})")
        if "moment" in loop.needs:
            for a in range(loop.dim):
                h = loop.along("h", a)
                lines.append(f"e{a} = moment(w{a}, d{a}, f{a}, {h})")
        return lines

    def nodes_loop(self, loop: ParticleLoop, channels: int) -> tuple[list[str], str]:
        """Header lines of the loop over the particle's nodes, and the indentation of its body."""
        lines, pad = [], ""
        for a in range(loop.dim):
            lines.append(f"{pad}for a{a} in range({self.nodes}):")
            pad += "    "
        index = " + ".join(f"(i{a} + a{a} + {self.ghosts}) * s{a}" for a in range(loop.dim))
        lines.append(f"{pad}k = ({index}) * {channels}")
        product = " * ".join(f"w{a}[a{a}]" for a in range(loop.dim))
        if loop.needs & {"w", "moment"}:
            lines.append(f"{pad}w = {product}")
        if "g" in loop.needs:
            for b in range(loop.dim):
                factors = " * ".join(f"{'d' if a == b else 'w'}{a}[a{a}]" for a in range(loop.dim))
                inv_h = loop.along("inv_h", b)
                lines.append(f"{pad}g{b} = {factors} * {inv_h}")
        if "r" in loop.needs:
            for b in range(loop.dim):
                h = loop.along("h", b)
                lines.append(f"{pad}r{b} = (T(a{b}) - f{b}) * {h}")
        if "moment" in loop.needs:
            for b in range(loop.dim):
                factors = " * ".join(f"{'e' if a == b else 'w'}{a}[a{a}]" for a in range(loop.dim))
                lines.append(f"{pad}e_{b} = {factors}")
        return lines, pad

    def helpers(self, moment: bool) -> list[str]:
        """Functions of the generated module that the loops call: `fold`, and `moment` if a transfer needs it."""
        k_all = range(self.nodes)

        def row(factors: list[list[int]]) -> str:
            terms = []
            for k in k_all:
                parts = [f"T({f}) * w[{j}]" if f != 1 else f"w[{j}]" for j, f in enumerate(factors[k]) if f]
                terms.append(" + ".join(parts) or "zero")
            return f"({', '.join(terms)})"

        def identity() -> list[list[int]]:
            return [[int(j == k) for j in k_all] for k in k_all]

        lines = [
            "@compiled",
            "def fold(w, i, n):",
            '    """Nodes outside the domain folded into the two outermost, as if the field went on linearly: v_-1 = 2 v_0 - v_1."""',
        ]
        for ghosts in range(1, self.nodes - 1):
            factors = identity()
            for k in range(ghosts):
                distance = ghosts - k
                factors[ghosts][k], factors[ghosts + 1][k] = 1 + distance, -distance
                factors[k][k] = 0
            lines += [f"    if i == {-ghosts}:", f"        w = {row(factors)}"]
        for last in range(1, self.nodes - 1):  # position of the outermost upper node among the particle's nodes
            factors = identity()
            for k in range(last + 1, self.nodes):
                distance = k - last
                factors[last][k], factors[last - 1][k] = 1 + distance, -distance
                factors[k][k] = 0
            lines += [f"    if i == n - {last}:", f"        w = {row(factors)}"]
        lines.append("    return w")
        if not moment:
            return lines
        lines += ["", ""]
        moments = ", ".join(f"w[{k}] * (T({k}) - f) / (D * h)" for k in k_all)
        slopes = ", ".join(f"d[{k}] / h" for k in k_all)
        second = " + ".join(f"w[{k}] * (T({k}) - f) * (T({k}) - f)" for k in k_all)
        lines += [
            "@compiled",
            "def moment(w, d, f, h):",
            '    """w_i (x_i - x_p) / D with D = sum_i w_i (x_i - x_p)^2; where D vanishes (on a node), its limit, the slope."""',
            f"    D = {second}",
            "    if D > T(1e-6):",
            f"        return ({moments},)",
            f"    return ({slopes},)",
        ]
        return lines


class StoredOperator:
    """Neighbour lists made once: node numbers, weights and gradients of each point."""

    arguments = "P, n, G, par, nodes, N, dN, out, flag"
    padding = (0, 0)

    def __init__(self, per_point: int) -> None:
        self.per_point = per_point

    def head(self, loop: ParticleLoop) -> list[str]:
        return []

    def weights(self, loop: ParticleLoop) -> list[str]:
        return []

    def nodes_loop(self, loop: ParticleLoop, channels: int) -> tuple[list[str], str]:
        lines = [f"for a in range({self.per_point}):", f"    k = nodes[p, a] * {channels}"]
        if "w" in loop.needs:
            lines.append("    w = N[p, a]")
        if "g" in loop.needs:
            lines += [f"    g{b} = dN[p, a, {b}]" for b in range(loop.dim)]
        return lines, "    "

    def helpers(self, moment: bool) -> list[str]:
        return []
