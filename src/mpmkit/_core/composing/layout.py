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
    """Where each stored component of each field lies in a particle's record, and why the field exists."""

    space: str
    dim: int
    fields: dict[str, Field] = attrs.field(factory=dict)
    start: dict[str, int] = attrs.field(factory=dict)
    reasons: dict[str, list[str]] = attrs.field(factory=dict)
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
        return components(self.fields[name], self.space, self.dim)


@attrs.define
class NodeLayout:
    """Channels of a node's record, in the order they were asked for."""

    dim: int
    start: dict[str, int] = attrs.field(factory=dict)
    reasons: dict[str, str] = attrs.field(factory=dict)
    size: int = 0

    def add(self, names: Iterable[str], reason: str, *, scalar: bool = False) -> None:
        for name in names:
            if name not in self.start:
                self.start[name] = self.size
                self.reasons[name] = reason
                self.size += 1 if scalar else self.dim
