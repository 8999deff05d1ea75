"""What all loops over nodes have in common: their text, the accounts they add to, vectors of channels."""

from __future__ import annotations

from collections.abc import Sequence

from mpmkit._core.composing.composition import Composition
from mpmkit._core.composing.layout import NodeLayout
from mpmkit._core.composing.pieces import node
from mpmkit._core.composing.source import Names, Parameters, Text

# Slots of the ledger array `work` that the loops over nodes add to.
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


IMPULSE, FORCE = WORK.index("impulse_x"), WORK.index("force_x")


def vector(layout: NodeLayout, channel: str, dim: int) -> str:
    """A nodal vector as a tuple of three."""
    return "(" + ", ".join([node(layout, channel, a) for a in range(dim)] + ["zero"] * (3 - dim)) + ")"


def assign(layout: NodeLayout, channel: str, dim: int, name: str) -> list[str]:
    return [f"{node(layout, channel, a)} = {name}[{a}]" for a in range(dim)]


class Sweep(Text):
    """One loop over a range of nodes, or over a list of nodes."""

    def __init__(self, composition: Composition, parameters: Parameters, names: Names, layout: NodeLayout) -> None:
        super().__init__(composition, parameters, names)
        self.layout = layout
        self.dim = composition.dim

    def position(self, index: str) -> str:
        """Text of a node's position as a tuple of three, from its number."""
        if self.composition.stored_operator:
            return "(" + ", ".join([f"X_nodes[{index}, {a}]" for a in range(self.dim)] + ["zero"] * (3 - self.dim)) + ")"
        parts, rest = [], index
        for a in range(self.dim):
            lower = self.along("lower", a)
            h = self.along("h", a)
            ghosts = self.parameter("ghosts", lambda roles: roles["ghosts"])
            parts.append(f"{lower} + (T(({rest}) // lat[{3 + a}]) - {ghosts}) * {h}")
            rest = f"({rest}) % lat[{3 + a}]"
        return f"({', '.join(parts + ['zero'] * (3 - self.dim))})"

    def body(self, name: str, doc: str, arguments: str, header: list[str], lines: list[str], tail: Sequence[str] = ()) -> str:
        text = ["@compiled", f"def {name}({arguments}, par, lat, work, t, dt):", f'    """{doc}"""', *self.parameter_lines()]
        return (
            "\n".join(
                [*text, *(f"    {line}" for line in header), *(f"        {line}" for line in lines), *(f"    {line}" for line in tail)]
            )
            + "\n"
        )

    def smallest_mass(self) -> str:
        return self.parameter("m_small", lambda roles: roles["m_small"])


def grid_arguments(c: Composition) -> str:
    return "G, span, X_nodes" if c.stored_operator else "G, span"


def list_arguments(c: Composition) -> str:
    return "G, nodes, normals, X_nodes" if c.stored_operator else "G, nodes, normals"


def needs_of(component: object, kernel: object, dim: int) -> set[str]:
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
