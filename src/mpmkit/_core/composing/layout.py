"""Memory layout: which components of a field are stored where, for particles and for nodes.

Particles of a body lie in one flat buffer, in tiles of 16: component k of particle p is at
``P[(p >> 4) * 16 R + 16 k + (p & 15)]`` with R components in all, so that a loop reads whole vectors of one component.
"""

from __future__ import annotations

from collections.abc import Iterable

import attrs

from mpmkit.fields import Field

LANES = 16

SYMMETRIC = {"bar": (0,), "1D": (0, 1, 2), "plane strain": (0, 1, 2, 3), "axisymmetric": (0, 1, 2, 3), "3D": (0, 1, 2, 3, 4, 5)}
"""Stored components of a symmetric tensor (xx yy zz xy yz xz); the others are zero."""

TENSOR = {"bar": (0,), "1D": (0,), "plane strain": (0, 1, 3, 4), "axisymmetric": (0, 1, 3, 4, 8), "3D": tuple(range(9))}
"""Stored components of a 3 x 3 tensor, row by row; of the others the diagonal is that of the identity for F, zero for rates."""


def components(field: Field, space: str, dim: int) -> tuple[int, ...]:
    """Stored components of a field, as indices into its full form (1, 3, 6 or 9 numbers)."""
    if field.shape == "scalar":
        return (0,)
    if field.shape == "vector":
        return tuple(range(dim))
    if field.shape == "symmetric":
        return SYMMETRIC[space]
    if field.name == "C":
        return tuple(3 * a + b for a in range(dim) for b in range(dim))
    return TENSOR[space]


@attrs.define
class ParticleLayout:
    """Where each stored component of each field lies in a particle's record, and why the field exists.

    `derived` are fields without a place in the record: loops compute them from others where they are asked for.
    """

    space: str
    dim: int
    fields: dict[str, Field] = attrs.field(factory=dict)
    start: dict[str, int] = attrs.field(factory=dict)
    reasons: dict[str, list[str]] = attrs.field(factory=dict)
    derived: dict[str, Field] = attrs.field(factory=dict)
    size: int = 0

    def add(self, field: Field, reason: str) -> None:
        """Add a field once; remember everyone who asked for it."""
        if field.name not in self.fields:
            self.fields[field.name] = field
            self.start[field.name] = self.size
            self.size += len(self.stored(field.name))
        if reason not in self.reasons.setdefault(field.name, []):
            self.reasons[field.name].append(reason)

    def stored(self, name: str) -> tuple[int, ...]:
        """Its components that there are in this space, as indices into its full form."""
        return components(self.fields.get(name) or self.derived[name], self.space, self.dim)


@attrs.define
class NodeLayout:
    """Channels of a node's record.

    Vectors begin at multiples of 2 (plane) or 4 (space), so that the channels a loop works on can be moved as whole short
    vectors; a scalar takes the place that a vector leaves over.
    """

    dim: int
    itemsize: int = 8
    start: dict[str, int] = attrs.field(factory=dict)
    reasons: dict[str, str] = attrs.field(factory=dict)
    scalars: set[str] = attrs.field(factory=set)
    _used: int = 0

    def add(self, names: Iterable[str], reason: str, *, scalar: bool = False) -> None:
        for name in names:
            if name in self.start:
                continue
            self.reasons[name] = reason
            align = 1 if scalar else (1, 2, 4)[self.dim - 1]
            first = -(-self._used // align) * align
            if scalar:
                self.scalars.add(name)
                taken = {s + k for n, s in self.start.items() for k in range(self.width(n))}
                first = next(k for k in range(first + 1) if k not in taken)
            self.start[name] = first
            self._used = max(self._used, first + self.width(name))

    def width(self, name: str) -> int:
        """Number of components of a channel."""
        return 1 if name in self.scalars else self.dim

    @property
    def size(self) -> int:
        """Numbers in a record: enough for every window."""
        some = 32 // self.itemsize
        return -(-max(self._used, self._rounded(self._used)) // some) * some if self.dim > 1 else _power_of_two(self._used)

    def window(self, channels: Iterable[str]) -> tuple[int, int]:
        """First number and length of the part of a record that holds these channels."""
        spans = [(self.start[n], self.start[n] + self.width(n)) for n in channels]
        low, high = min(s for s, _ in spans), max(e for _, e in spans)
        width = self._rounded(high - low)
        aligned = low // width * width
        return (aligned if high <= aligned + width <= self.size else max(0, min(low, self.size - width))), width

    def _rounded(self, n: int) -> int:
        """Up to a cache line a power of two, for one vector; then whole vectors of 32 bytes."""
        some = 32 // self.itemsize
        return _power_of_two(n) if n * self.itemsize <= 64 or self.dim == 1 else -(-n // some) * some


def _power_of_two(n: int) -> int:
    return max(2, 1 << (n - 1).bit_length())


@attrs.frozen
class Slots:
    """Numbers of the rows of 16 lanes in a loop's scratch array: the weights of 16 particles first.

    ``w(a, k)`` and ``d(a, k)``: weight and slope along axis a of the particle's k-th node, ``f(a)``: its place in that count.
    """

    dim: int
    nodes: int

    def w(self, a: int, k: int) -> int:
        return a * self.nodes + k

    def d(self, a: int, k: int) -> int:
        return (self.dim + a) * self.nodes + k

    def f(self, a: int) -> int:
        return 2 * self.dim * self.nodes + a

    @property
    def count(self) -> int:
        return self.dim * (2 * self.nodes + 1)


def lane(slot: int) -> str:
    """Text of a particle's number in a row of the scratch array."""
    return f"sc[U({LANES * slot} + l)]"
