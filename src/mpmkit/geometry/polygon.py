"""Polygons in the plane."""

from __future__ import annotations

import numpy as np

from mpmkit.errors import ParameterError, shown
from mpmkit.geometry.base import Array, Geometry, Moments, check_dims
from mpmkit.parameters import Vector, define, parameter


@define
class Polygon(Geometry):
    """The inside of a closed line of straight edges in 2D; the last point is joined to the first.

    The points may go round either way. Edges must not cross each other.
    """

    points: tuple[Vector, ...] = parameter("corners in order", unit="m", example=((0.1, 0.1), (0.9, 0.1), (0.5, 0.8)))

    def check(self) -> None:
        for k, point in enumerate(self.points):
            check_dims(f"Polygon.points[{k}]", point, (2,))
        if len(self.points) > 1 and self.points[0] == self.points[-1]:
            object.__setattr__(self, "points", self.points[:-1])  # a line that is closed explicitly
        if len(self.points) < 3:
            raise ParameterError(f"Polygon.points must be at least 3 points, got {len(self.points)}")
        for k, (a, b) in enumerate(zip(*self._edges(), strict=True)):
            if (a == b).all():
                raise ParameterError(f"Polygon.points[{k}] is followed by the same point {tuple(a.tolist())}; leave one out")
        self._check_crossing()
        if self.moments()[0] <= 0.0:
            raise ParameterError(f"Polygon.points: the corners {shown(self.points)} enclose no area")

    def _edges(self) -> tuple[Array, Array]:
        start = np.asarray(self.points)
        return start, np.roll(start, -1, axis=0)

    def _check_crossing(self) -> None:
        a, b = self._edges()
        n = len(a)
        edge, following = b - a, np.roll(b - a, -1, axis=0)
        turned = edge[:, 0] * following[:, 1] - edge[:, 1] * following[:, 0]
        back = np.flatnonzero((turned == 0.0) & ((edge * following).sum(axis=1) < 0.0))
        if len(back):
            raise ParameterError(f"Polygon: the line turns straight back at {self.points[(back[0] + 1) % n]}; leave that point out")
        for i in range(n - 2):
            j = np.arange(i + 2, n - 1 if i == 0 else n)  # not its neighbours, which share a corner with it
            crossing = j[_cross(a[i], b[i], a[j], b[j])]
            if len(crossing):
                first, second = f"points[{i}]-points[{i + 1}]", f"points[{crossing[0]}]-points[{(crossing[0] + 1) % n}]"
                raise ParameterError(f"Polygon: the edges {first} and {second} cross each other; put the corners in order")

    @property
    def dim(self) -> int:
        return 2

    def bounds(self) -> tuple[Vector, Vector]:
        corners = np.asarray(self.points)
        return tuple(corners.min(axis=0).tolist()), tuple(corners.max(axis=0).tolist())

    def depth(self, x: Array) -> Array:
        distance2 = np.full(len(x), np.inf)
        inside = np.zeros(len(x), dtype=bool)
        for a, b in zip(*self._edges(), strict=True):
            edge, offset = b - a, x - a
            part = np.clip(offset @ edge / (edge @ edge), 0.0, 1.0)
            distance2 = np.minimum(distance2, ((offset - part[:, None] * edge) ** 2).sum(axis=1))
            # A ray to +x crosses this edge if the point's y is between its ends and the crossing lies to the right.
            straddles = (a[1] > x[:, 1]) != (b[1] > x[:, 1])
            left = (offset[:, 0] * edge[1] - offset[:, 1] * edge[0]) * (1.0 if edge[1] > 0.0 else -1.0) < 0.0
            inside ^= straddles & left
        return np.asarray(np.where(inside, 1.0, -1.0) * np.sqrt(distance2))

    def moments(self) -> Moments:
        origin = np.asarray(self.points).mean(axis=0)  # near the shape, so that little is lost to cancellation
        a, b = (ends - origin for ends in self._edges())
        double = a[:, 0] * b[:, 1] - b[:, 0] * a[:, 1]
        area = 0.5 * float(double.sum())
        first = ((a + b) * double[:, None]).sum(axis=0) / 6.0
        sign = 1.0 if area >= 0.0 else -1.0
        return sign * area, tuple((sign * (first + area * origin)).tolist())


def _cross(a: Array, b: Array, c: Array, d: Array) -> np.ndarray:
    """Whether the segment a-b meets each of the segments c-d, bool[n]; touching counts."""

    def side(p: Array, q: Array, r: Array) -> Array:
        u, v = q - p, r - p
        return np.sign(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])

    s1, s2, s3, s4 = side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)
    overlap = (np.minimum(a, b) <= np.maximum(c, d)).all(axis=-1) & (np.minimum(c, d) <= np.maximum(a, b)).all(axis=-1)
    return np.asarray((s1 * s2 <= 0.0) & (s3 * s4 <= 0.0) & overlap)
