"""What all loops over nodes have in common: their text, the accounts they add to, vectors of channels."""

from __future__ import annotations

from collections.abc import Sequence

from mpmkit._core.composing.composition import Composition
from mpmkit._core.composing.layout import NodeLayout
from mpmkit._core.composing.source import Names, Parameters, Text

# Columns of the ledger's accounts `work` that the loops over nodes add to.
WORK = (
    "external",
    "effect_dissipation",
    "boundary",
    "friction",
    "impulse_x",
    "impulse_y",
    "impulse_z",
    "force_x",
    "force_y",
    "force_z",
)


CHUNK = 64  # nodes of a block where nodes are stored in a list
IMPULSE, FORCE = WORK.index("impulse_x"), WORK.index("force_x")


def node(layout: NodeLayout, channel: str, a: int = 0) -> str:
    """One number of the record of node k."""
    offset = layout.start[channel] + a
    return f"G[U(k + {offset})]" if offset else "G[U(k)]"


def limited(layout: NodeLayout, a: int, smooth: bool) -> list[str]:
    """Lines for ``u{a}``, the nodal velocity with its change reduced to ``share``.

    What accelerations do to all mass alike is no matter of little mass: the change of what falls is left alone, and with smooth shape
    functions every change between none, as of a body that rests under its weight, and that. Slopes that jump would make rounding errors
    grow up to it (see the caution about raw velocities).
    """
    old, new = node(layout, "v_old", a), node(layout, "v", a)
    if "v_given" not in layout.start:
        return [f"u{a} = {old} + share * ({new} - {old})"]
    given = node(layout, "v_given", a)
    if not smooth:
        return [f"u{a} = {old} + {given} + share * ({new} - {old} - {given})"]
    return [
        f"dv{a} = {new} - {old}",
        f"mild{a} = min(max(dv{a}, min({given}, zero)), max({given}, zero))",
        f"u{a} = {old} + mild{a} + share * (dv{a} - mild{a})",
    ]


def vector(layout: NodeLayout, channel: str, dim: int) -> str:
    """A nodal vector as a tuple of three."""
    return "(" + ", ".join([node(layout, channel, a) for a in range(dim)] + ["zero"] * (3 - dim)) + ")"


def assign(layout: NodeLayout, channel: str, dim: int, name: str) -> list[str]:
    """Lines that set a nodal vector from a tuple."""
    return [f"{node(layout, channel, a)} = {name}[{a}]" for a in range(dim)]


class Sweep(Text):
    """One loop over all stored nodes, block by block, or over a list of nodes."""

    def __init__(self, composition: Composition, parameters: Parameters, names: Names, layout: NodeLayout, block: int) -> None:
        super().__init__(composition, parameters, names)
        self.layout = layout
        self.dim = composition.dim
        self.block = block  # nodes of a block along an axis

    @property
    def per_block(self) -> int:
        """Nodes of a block."""
        return CHUNK if self.composition.stored_operator else int(self.block**self.dim)

    def position(self, index: str) -> str:
        """Text of a node's position as a tuple of three, from its number."""
        if self.composition.stored_operator:
            return "(" + ", ".join([f"where[{index}, {a}]" for a in range(self.dim)] + ["zero"] * (3 - self.dim)) + ")"
        parts = []
        for a in range(self.dim):
            power = self.block ** (self.dim - 1 - a)
            digit = f"{index} // {power} % {self.block}" if power > 1 else f"{index} % {self.block}"
            lower, h = self.along("lower", a), self.along("h", a)
            parts.append(f"{lower} + T(where[{index} // {self.per_block}, {a}] + {digit}) * {h}")
        return f"({', '.join(parts + ['zero'] * (3 - self.dim))})"

    def over_nodes(self, name: str, doc: str, lines: list[str], accounts: dict[str, int], more: str = "") -> str:
        """A function over blocks of nodes; `accounts` are local sums and the columns of `WORK` where each block leaves them."""
        text = ["@compiled", f"def {name}(first, last, G, count, where, {more}par, acc, t, dt):", f'    """{doc}"""']
        text += [*self.parameter_lines(), "    for block in range(first, last):"]
        text += [f"        {account} = 0.0" for account in accounts]
        text.append(f"        for i in range({self.per_block} * block, min({self.per_block} * (block + 1), count)):")
        text += [f"            k = i * {self.layout.size}", *(f"            {line}" for line in lines)]
        text += [f"        acc[U({len(WORK)} * block + {column})] += {account}" for account, column in accounts.items()]
        return "\n".join(text) + "\n"

    def over_list(self, name: str, doc: str, arguments: str, header: list[str], lines: list[str], tail: Sequence[str] = ()) -> str:
        """A function over a list of nodes, which adds to the accounts `work`."""
        text = ["@compiled", f"def {name}({arguments}, where, par, work, t, dt):", f'    """{doc}"""', *self.parameter_lines()]
        return (
            "\n".join(
                [*text, *(f"    {line}" for line in header), *(f"        {line}" for line in lines), *(f"    {line}" for line in tail)]
            )
            + "\n"
        )

    def smallest_mass(self) -> str:
        """The mass below which a node counts as out of reach of all particles."""
        return self.parameter("m_small", lambda roles: roles["m_small"])


def needs_of(component: object, kernel: object, dim: int) -> set[str]:
    """Arguments of a kernel, with those of the functions behind its `Value` parameters."""
    arguments = set(kernel.arguments)  # type: ignore[attr-defined]
    for name in list(arguments):
        arguments |= set(value_arguments(component, name, dim))
    return arguments


def value_arguments(component: object, name: str, dim: int) -> tuple[str, ...]:
    """Arguments of the user's function behind a `Value` parameter; empty if it is a constant or no such parameter."""
    if name not in getattr(component, "values", ()):
        return ()
    from mpmkit.expression import as_function

    made = as_function(getattr(component, name), dim)
    return made.__code__.co_varnames[: made.__code__.co_argcount] if callable(made) else ()
