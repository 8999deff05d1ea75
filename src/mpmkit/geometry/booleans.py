"""Union, intersection and difference of shapes."""

from __future__ import annotations

import math
from functools import reduce
from itertools import combinations
from typing import Any

import numpy as np

from mpmkit.errors import ParameterError
from mpmkit.geometry.base import Array, Geometry, Moments
from mpmkit.geometry.primitives import Box
from mpmkit.geometry.relations import disjoint, encloses
from mpmkit.parameters import Vector, define, parameter


def _parts(shapes: tuple[Any, ...], given: Any) -> tuple[Any, ...]:
    """Shapes from ``Union(a, b)``, ``Union([a, b])`` or ``Union(shapes=[a, b])``."""
    if given is not None:
        shapes = (*shapes, *given)
    return tuple(shapes[0]) if len(shapes) == 1 and isinstance(shapes[0], (list, tuple)) else shapes


class _Combination(Geometry):
    """What the three combinations have in common."""

    shapes: tuple[Geometry, ...]

    def check(self) -> None:
        name = type(self).__name__
        if not self.shapes:
            raise ParameterError(f"{name}.shapes must hold at least one shape, got none")
        for k, shape in enumerate(self.shapes):
            if shape.dim != self.shapes[0].dim:
                raise ParameterError(
                    f"{name}.shapes[{k}] ({type(shape).__name__}) has {shape.dim} dimensions, shapes[0] "
                    f"({type(self.shapes[0]).__name__}) has {self.shapes[0].dim}; combine shapes of one dimension"
                )

    @property
    def dim(self) -> int:
        return self.shapes[0].dim


@define
class Union(_Combination):
    """All points that lie in any of the shapes: ``Union(a, b, ...)`` or ``a | b``."""

    shapes: tuple[Geometry, ...] = parameter("shapes to join", example=(Box((0.0, 0.0), (0.5, 0.2)), Box((0.0, 0.2), (0.2, 0.5))))

    def __init__(self, *parts: Any, shapes: Any = None) -> None:
        self.__attrs_init__(_parts(parts, shapes))  # type: ignore[attr-defined]

    @property
    def tight_bounds(self) -> bool:  # type: ignore[override]
        return all(s.tight_bounds for s in self.shapes)

    def bounds(self) -> tuple[Vector, Vector]:
        lowers, uppers = zip(*(s.bounds() for s in self.shapes), strict=True)
        return tuple(map(min, zip(*lowers, strict=True))), tuple(map(max, zip(*uppers, strict=True)))

    def depth(self, x: Array) -> Array:
        return reduce(np.maximum, (s.depth(x) for s in self.shapes))

    def moments(self) -> Moments | None:
        """Known for shapes that are apart, within each other, or two whose intersection is known."""
        kept: list[Geometry] = []
        for shape in sorted(self.shapes, key=_extent, reverse=True):  # large ones first, which may hold the others
            if not any(encloses(k, shape) for k in kept):
                kept.append(shape)
        if len(kept) == 2:
            return _combined((1, *kept), (-1, Intersection(*kept)))
        if not all(disjoint(a, b) for a, b in combinations(kept, 2)):
            return None
        return _combined((1, *kept))


@define
class Intersection(_Combination):
    """All points that lie in every one of the shapes: ``Intersection(a, b, ...)`` or ``a & b``."""

    shapes: tuple[Geometry, ...] = parameter("shapes to intersect", example=(Box((0.0, 0.0), (0.5, 0.5)), Box((0.2, 0.2), (0.8, 0.8))))

    def __init__(self, *parts: Any, shapes: Any = None) -> None:
        self.__attrs_init__(_parts(parts, shapes))  # type: ignore[attr-defined]

    @property
    def tight_bounds(self) -> bool:  # type: ignore[override]
        return all(isinstance(s, Box) for s in self.shapes) and all(up > low for low, up in zip(*self.bounds(), strict=True))

    def bounds(self) -> tuple[Vector, Vector]:
        """The common part of the bounds; a box of no size where there is none."""
        lowers, uppers = zip(*(s.bounds() for s in self.shapes), strict=True)
        lower = tuple(max(ends) for ends in zip(*lowers, strict=True))
        return lower, tuple(max(low, min(ends)) for low, ends in zip(lower, zip(*uppers, strict=True), strict=True))

    def depth(self, x: Array) -> Array:
        return reduce(np.minimum, (s.depth(x) for s in self.shapes))

    def moments(self) -> Moments | None:
        """Known for boxes, for shapes that lie within each other, and for shapes that are apart."""
        if any(disjoint(a, b) for a, b in combinations(self.shapes, 2)):
            return 0.0, (0.0,) * self.dim
        if all(isinstance(s, Box) for s in self.shapes):
            return Box(*self.bounds()).moments()
        smallest = next((s for s in self.shapes if all(o is s or encloses(o, s) for o in self.shapes)), None)
        return None if smallest is None else smallest.moments()


@define
class Difference(_Combination):
    """All points of the first shape that lie inside none of the others: ``Difference(a, b, ...)`` or ``a - b``.

    The surface of what is cut away belongs to the result.
    """

    shapes: tuple[Geometry, ...] = parameter(
        "a shape, then those to cut away", example=(Box((0.0, 0.0), (1.0, 1.0)), Box((0.4, 0.4), (0.6, 0.6)))
    )

    def __init__(self, *parts: Any, shapes: Any = None) -> None:
        self.__attrs_init__(_parts(parts, shapes))  # type: ignore[attr-defined]

    @property
    def tight_bounds(self) -> bool:  # type: ignore[override]
        first, *others = self.shapes
        return first.tight_bounds and all(disjoint(first, s) for s in others)

    def bounds(self) -> tuple[Vector, Vector]:
        return self.shapes[0].bounds()

    def depth(self, x: Array) -> Array:
        first, *others = self.shapes
        return reduce(np.minimum, (-s.depth(x) for s in others), first.depth(x))

    def moments(self) -> Moments | None:
        """Known where the intersections with the first shape are known and apart from each other."""
        first, *others = self.shapes
        if any(encloses(s, first) for s in others):
            return 0.0, (0.0,) * self.dim
        holes = [s for s in others if not disjoint(first, s)]
        if not all(disjoint(a, b) for a, b in combinations(holes, 2)):
            return None
        return _combined((1, first), (-1, *(Intersection(first, s) for s in holes)))


def _combined(*groups: tuple[Any, ...]) -> Moments | None:
    """Sum of moments over groups (sign, shape, shape ...); None if one is not known."""
    total: list[float] = []
    for sign, *shapes in groups:
        for shape in shapes:
            moments = shape.moments()
            if moments is None:
                return None
            row = [sign * moments[0], *(sign * m for m in moments[1])]
            total = [a + b for a, b in zip(total, row, strict=True)] if total else row
    return total[0], tuple(total[1:])


def _extent(shape: Geometry) -> float:
    lower, upper = shape.bounds()
    return math.dist(lower, upper) if all(map(math.isfinite, (*lower, *upper))) else math.inf
