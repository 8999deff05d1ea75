"""What every shape can answer.

Numpy is imported where it is used: plugins name `Geometry` as the type of a parameter, and listing them must be quick.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

from mpmkit.errors import ParameterError, shown

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from mpmkit.geometry.booleans import Difference, Intersection, Union

Array: TypeAlias = "NDArray[np.float64]"
Moments = tuple[float, tuple[float, ...]]
"""Measure (length, area or volume) and the integrals of x, y, z over the shape."""

ROUNDING = 1e-12  # points this far outside, relative to the size of the coordinates, still lie on the surface


class Geometry:
    """A closed set of points in one, two or three dimensions.

    A subclass supplies `dim`, `bounds`, `depth` and, where a closed form exists, `moments`. Shapes combine with the
    operators ``|`` (union), ``&`` (intersection) and ``-`` (difference).
    """

    tight_bounds: bool = True
    """Whether `bounds` is the smallest box around the shape."""

    def __attrs_post_init__(self) -> None:
        self.check()

    def check(self) -> None:
        """Check parameters against each other."""

    @property
    def dim(self) -> int:
        """Number of space dimensions."""
        raise NotImplementedError(f"{type(self).__name__} must define dim")

    def bounds(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Lower and upper corner of a box around the shape [m]; infinite where the shape is."""
        raise NotImplementedError(f"{type(self).__name__} must define bounds()")

    def depth(self, x: Array) -> Array:
        """Signed distance below the surface [m] of the points float64[n, dim], float64[n].

        Positive inside, zero on the surface, negative outside. Its size never exceeds the distance to the surface and it
        changes by no more than the distance between two points; both bounds survive min, max and change of sign, so that
        combinations of shapes keep them.
        """
        raise NotImplementedError(f"{type(self).__name__} must define depth(x)")

    def moments(self) -> Moments | None:
        """Measure and first moments where a closed form exists, else None."""
        return None

    def contains(self, x: ArrayLike) -> NDArray[np.bool_]:
        """Which of the points float[n, dim] lie inside, bool[n].

        Points on the surface count as inside, also where something was cut away, with a tolerance of 1e-12 of the
        coordinates' size on either side: so lattice points on opposite faces are treated alike.
        """
        import numpy as np

        from mpmkit.grid import as_points

        points = as_points(x, self.dim)
        return np.asarray(self.depth(points) >= -ROUNDING * self._scale(points))

    def _scale(self, points: Array) -> Array:
        """Size of the numbers that the test of a point is made of, float64[n]."""
        import numpy as np

        ends = [abs(c) for corner in self.bounds() for c in corner if math.isfinite(c)]
        return np.asarray(np.maximum(max(ends, default=0.0), np.abs(points).max(axis=1, initial=0.0)))

    def volume(self) -> float | None:
        """Exact length, area or volume; None if no closed form is known (see `measure`)."""
        moments = self.moments()
        return None if moments is None else moments[0]

    def measure(self, levels: int | None = None) -> float:
        """Length, area or volume: exact if a closed form exists, else by adaptive subdivision (see `mpmkit.geometry.measure`)."""
        exact = self.volume()
        if exact is not None:
            return exact
        from mpmkit.geometry.measure import subdivided_measure

        return subdivided_measure(self, levels)

    def __or__(self, other: Geometry) -> Union:
        from mpmkit.geometry.booleans import Union

        return Union(self, other) if isinstance(other, Geometry) else NotImplemented

    def __and__(self, other: Geometry) -> Intersection:
        from mpmkit.geometry.booleans import Intersection

        return Intersection(self, other) if isinstance(other, Geometry) else NotImplemented

    def __sub__(self, other: Geometry) -> Difference:
        from mpmkit.geometry.booleans import Difference

        return Difference(self, other) if isinstance(other, Geometry) else NotImplemented


def check_dims(path: str, vector: tuple[float, ...], dims: tuple[int, ...]) -> None:
    """Raise `ParameterError` unless a vector has one of the given lengths and finite components."""
    if len(vector) not in dims:
        allowed = " or ".join(str(d) for d in dims)
        raise ParameterError(f"{path} must have {allowed} number{'s' if dims != (1,) else ''}, got {len(vector)}: {shown(vector)}")
    if not all(math.isfinite(c) for c in vector):
        raise ParameterError(f"{path} must be finite, got {vector}")


def box_depth(offsets: Array) -> Array:
    """Depth from the signed overshoots float64[n, k] beyond k mutually orthogonal slabs (positive outside)."""
    import numpy as np

    outside = np.sqrt((np.maximum(offsets, 0.0) ** 2).sum(axis=1))
    return np.asarray(-(outside + np.minimum(offsets.max(axis=1), 0.0)))


def empty_or_infinite(shape: Geometry) -> bool:
    """Whether the box around a shape is empty or has no end."""
    lower, upper = shape.bounds()
    return not all(math.isfinite(lo) and math.isfinite(up) and lo <= up for lo, up in zip(lower, upper, strict=True))
