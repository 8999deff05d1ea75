"""Box, disk, sphere, cylinder and half-space."""

from __future__ import annotations

import math

import numpy as np

from mpmkit.errors import ParameterError
from mpmkit.geometry.base import Array, Geometry, Moments, box_depth, check_dims
from mpmkit.parameters import Vector, define, parameter


@define
class Box(Geometry):
    """An interval in 1D, a rectangle in 2D, a cuboid in 3D, with edges along the axes."""

    lower: Vector = parameter("lower corner", unit="m", example=(0.0, 0.0))
    upper: Vector = parameter("upper corner", unit="m", example=(1.0, 0.5))

    def check(self) -> None:
        check_dims("Box.lower", self.lower, (1, 2, 3))
        check_dims("Box.upper", self.upper, (len(self.lower),))
        for axis, low, up in zip("xyz", self.lower, self.upper, strict=False):
            if up <= low:
                raise ParameterError(f"Box.upper must be > Box.lower in {axis}, got lower {low:g} and upper {up:g} [m]")

    @property
    def dim(self) -> int:
        return len(self.lower)

    def bounds(self) -> tuple[Vector, Vector]:
        return self.lower, self.upper

    def depth(self, x: Array) -> Array:
        return box_depth(np.maximum(np.asarray(self.lower) - x, x - np.asarray(self.upper)))

    def moments(self) -> Moments:
        size = math.prod(up - low for low, up in zip(self.lower, self.upper, strict=True))
        return size, tuple(0.5 * size * (low + up) for low, up in zip(self.lower, self.upper, strict=True))


class _Ball(Geometry):
    """What disk and sphere have in common."""

    center: Vector
    radius: float

    def bounds(self) -> tuple[Vector, Vector]:
        return tuple(c - self.radius for c in self.center), tuple(c + self.radius for c in self.center)

    def depth(self, x: Array) -> Array:
        return np.asarray(self.radius - np.sqrt(((x - np.asarray(self.center)) ** 2).sum(axis=1)))

    def moments(self) -> Moments:
        size = math.pi * self.radius**2 if self.dim == 2 else 4.0 / 3.0 * math.pi * self.radius**3
        return size, tuple(size * c for c in self.center)


@define
class Disk(_Ball):
    """A disk in 2D."""

    center: Vector = parameter("centre", unit="m", example=(0.5, 0.5))
    radius: float = parameter("radius", unit="m", gt=0.0, lt=math.inf, example=0.2)

    def check(self) -> None:
        check_dims("Disk.center", self.center, (2,))

    @property
    def dim(self) -> int:
        return 2


@define
class Sphere(_Ball):
    """A ball in 3D."""

    center: Vector = parameter("centre", unit="m", example=(0.5, 0.5, 0.5))
    radius: float = parameter("radius", unit="m", gt=0.0, lt=math.inf, example=0.2)

    def check(self) -> None:
        check_dims("Sphere.center", self.center, (3,))

    @property
    def dim(self) -> int:
        return 3


@define
class Cylinder(Geometry):
    """A circular cylinder in 3D between the centres of its two end faces."""

    start: Vector = parameter("centre of one end face", unit="m", example=(0.5, 0.5, 0.1))
    end: Vector = parameter("centre of the other end face", unit="m", example=(0.5, 0.5, 0.9))
    radius: float = parameter("radius", unit="m", gt=0.0, lt=math.inf, example=0.2)

    def check(self) -> None:
        check_dims("Cylinder.start", self.start, (3,))
        check_dims("Cylinder.end", self.end, (3,))
        if self.start == self.end:
            raise ParameterError(f"Cylinder.end must differ from Cylinder.start, both are {self.start} [m]")

    @property
    def dim(self) -> int:
        return 3

    @property
    def length(self) -> float:
        """Distance between the end faces [m]."""
        return math.dist(self.start, self.end)

    @property
    def direction(self) -> Array:
        """Unit vector from start to end, float64[3]."""
        return np.subtract(self.end, self.start) / self.length

    def bounds(self) -> tuple[Vector, Vector]:
        # The rim of an end face reaches radius * sqrt(1 - a_k^2) from its centre along axis k.
        reach = self.radius * np.sqrt(np.maximum(1.0 - self.direction**2, 0.0))
        lower, upper = np.minimum(self.start, self.end) - reach, np.maximum(self.start, self.end) + reach
        return tuple(lower.tolist()), tuple(upper.tolist())

    def depth(self, x: Array) -> Array:
        middle = 0.5 * np.add(self.start, self.end)
        offset = x - middle
        along = offset @ self.direction
        across = np.sqrt(((offset - along[:, None] * self.direction) ** 2).sum(axis=1))
        return box_depth(np.stack((np.abs(along) - 0.5 * self.length, across - self.radius), axis=1))

    def moments(self) -> Moments:
        size = math.pi * self.radius**2 * self.length
        return size, tuple(0.5 * size * (a + b) for a, b in zip(self.start, self.end, strict=True))


@define
class HalfSpace(Geometry):
    """All points behind a plane (a line in 2D, a point in 1D): (x - point) . normal <= 0. It has no end.

    A body made of it alone ends at the domain.
    """

    tight_bounds = False

    point: Vector = parameter("a point of the plane", unit="m", example=(0.0, 0.5))
    normal: Vector = parameter("direction out of the half-space, of any length", example=(0.0, 1.0))

    def check(self) -> None:
        check_dims("HalfSpace.point", self.point, (1, 2, 3))
        check_dims("HalfSpace.normal", self.normal, (len(self.point),))
        if not math.hypot(*self.normal) > 0.0:
            raise ParameterError(f"HalfSpace.normal must not be zero, got {self.normal}")

    @property
    def dim(self) -> int:
        return len(self.point)

    @property
    def unit_normal(self) -> Array:
        """Unit vector out of the half-space, float64[dim]."""
        return np.asarray(self.normal) / math.hypot(*self.normal)

    def bounds(self) -> tuple[Vector, Vector]:
        lower, upper = [-math.inf] * self.dim, [math.inf] * self.dim
        along = [axis for axis, n in enumerate(self.normal) if n != 0.0]
        if len(along) == 1:  # only a plane across an axis bounds anything
            (axis,) = along
            (upper if self.normal[axis] > 0.0 else lower)[axis] = self.point[axis]
        return tuple(lower), tuple(upper)

    def depth(self, x: Array) -> Array:
        return np.asarray((np.asarray(self.point) - x) @ self.unit_normal)
