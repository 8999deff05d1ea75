"""Text of the arena: the nodes around one block of cells, copied from the sparse grid before a gather, added to it after a scatter.

The grid keeps blocks of B nodes along each axis. The particles of a block reach the nodes from one before the block (they
may have drifted by a cell since they were sorted) to B + n - 1, n nodes along an axis being those of one particle.
"""

from __future__ import annotations

import attrs

from mpmkit._core.composing.rows import whole


@attrs.frozen
class Arena:
    """Sizes of blocks and arenas for one dimension and number of nodes per particle and axis."""

    dim: int
    nodes: int

    @property
    def block(self) -> int:
        """Nodes of a block along an axis: such that arenas of blocks with one block between them do not meet."""
        return max((32, 8, 4)[self.dim - 1], self.nodes + 1)

    @property
    def side(self) -> int:
        return self.block + self.nodes + 1

    @property
    def size(self) -> int:
        return int(self.side**self.dim)

    def fetch(self, name: str, record: int, first: int, width: int) -> str:
        """Copy numbers first .. first + width of the records of all nodes around a block into the arena."""
        lines, pad = self._visit()
        lines += [f"{pad}store(arena, e + {k}, load(G, node * {record} + {first + k}, {n}))" for k, n in whole(width)] + [
            f"{pad}e += {width}"
        ]
        return _function(name, "arena, G, home, block", "Copy a window of the records around a block into the arena.", ["e = 0", *lines])

    def flush(self, name: str, record: int, first: int, width: int) -> str:
        """Add the arena to the same numbers of the nodes around a block."""
        lines, pad = self._visit()
        lines.append(f"{pad}at = node * {record} + {first}")
        lines += [f"{pad}store(G, at + {k}, load(G, at + {k}, {n}) + load(arena, e + {k}, {n}))" for k, n in whole(width)]
        lines.append(f"{pad}e += {width}")
        return _function(name, "arena, G, home, block", "Add the arena to a window of the records around a block.", ["e = 0", *lines])

    def node_of(self) -> str:
        """Number in the sparse grid of one node of the arena."""
        A, B, lines, rest, q, r = self.side, self.block, [], "e", "", ""
        for a in range(self.dim):
            power = A ** (self.dim - 1 - a)
            lines.append(f"i{a} = {rest} // {power} + {B - 1}" if power > 1 else f"i{a} = {rest} + {B - 1}")
            rest = f"{rest} % {power}"
            q = f"({q}) * 3 + i{a} // {B}" if q else f"i{a} // {B}"
            r = f"({r}) * {B} + i{a} % {B}" if r else f"i{a} % {B}"
        lines.append(f"return int(home[U({3**self.dim} * block + {q})]) * {B**self.dim} + {r}")
        return _function("node_of", "home, block, e", "Number in the sparse grid of node e of the arena of a block.", lines)

    def _visit(self) -> tuple[list[str], str]:
        """Nested loops over the arena that know the `node` in the sparse grid: block q around this one, place r in it."""
        A, B, lines, pad, q, r = self.side, self.block, [], "", "", ""
        for a in range(self.dim):
            lines.append(f"{pad}for i{a} in range({B - 1}, {A + B - 1}):")
            pad += "    "
            q_next, r_next = f"i{a} // {B}", f"i{a} % {B}"
            lines.append(f"{pad}q{a} = {f'{q} * 3 + ' if q else ''}{q_next}")
            lines.append(f"{pad}r{a} = {f'{r} * {B} + ' if r else ''}{r_next}")
            q, r = f"q{a}", f"r{a}"
        lines.append(f"{pad}node = int(home[U({3**self.dim} * block + {q})]) * {B**self.dim} + {r}")
        return lines, pad


def _function(name: str, arguments: str, doc: str, lines: list[str]) -> str:
    return "\n".join(["@compiled", f"def {name}({arguments}):", f'    """{doc}"""', *(f"    {line}" for line in lines)]) + "\n"
