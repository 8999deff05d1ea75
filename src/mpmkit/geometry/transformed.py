"""A shape that is scaled, turned and moved."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from mpmkit.errors import ParameterError
from mpmkit.geometry.base import Array, Geometry, Moments, check_dims
from mpmkit.geometry.primitives import Box
from mpmkit.parameters import Vector, define, parameter


@define
class Transformed(Geometry):
    """A shape scaled, then rotated, both about one point, and then moved.

    In 2D ``rotate=30`` turns counter-clockwise; in 3D ``rotate=30, axis=(0, 0, 1)`` turns by the right-hand rule.
    """

    shape: Geometry = parameter("the shape to transform", example=Box((0.4, 0.4), (0.6, 0.6)))
    rotate: float = parameter("angle of rotation", unit="deg", default=0.0, example=30.0)
    axis: Vector | None = parameter("direction of the axis of rotation, in 3D only", default=None)
    translate: Vector | None = parameter("displacement, after scaling and rotation", unit="m", default=None)
    scale: Vector = parameter(
        "factor of length: one number, or one for each axis before rotation", gt=0.0, lt=math.inf, default=(1.0,), example=1.0
    )
    about: Vector | None = parameter(
        "the point that scaling and rotation leave where it is; the origin if not given", unit="m", default=None
    )

    def check(self) -> None:
        dim = self.shape.dim
        check_dims("Transformed.scale", self.scale, (1, dim))
        for name in ("translate", "about"):
            if getattr(self, name) is not None:
                check_dims(f"Transformed.{name}", getattr(self, name), (dim,))
        if not math.isfinite(self.rotate):
            raise ParameterError(f"Transformed.rotate must be finite, got {self.rotate} [deg]")
        if self.axis is not None:
            if dim != 3:
                raise ParameterError(f"Transformed.axis is for shapes in 3D, {type(self.shape).__name__} has {dim}; leave it out")
            check_dims("Transformed.axis", self.axis, (3,))
            if not math.hypot(*self.axis) > 0.0:
                raise ParameterError(f"Transformed.axis must not be zero, got {self.axis}")
        elif dim == 3 and self.rotate != 0.0:
            raise ParameterError("Transformed.rotate needs an axis in 3D: give for example axis=(0, 0, 1)")
        elif dim == 1 and self.rotate != 0.0:
            raise ParameterError("Transformed.rotate has no meaning in 1D; leave it out")

    @property
    def dim(self) -> int:
        return self.shape.dim

    @property
    def tight_bounds(self) -> bool:  # type: ignore[override]
        return self.shape.tight_bounds and self.rotate == 0.0

    @property
    def matrix(self) -> Array:
        """R S: scale, then rotate; float64[dim, dim]."""
        return self._rotation() @ np.diag(np.broadcast_to(self.scale, self.dim))

    def _rotation(self) -> Array:
        c, s = _cos_sin(self.rotate)
        if self.dim == 2:
            return np.array(((c, -s), (s, c)))
        if self.dim == 1 or self.axis is None:
            return np.eye(self.dim)
        u = np.asarray(self.axis) / math.hypot(*self.axis)
        skew = np.array(((0.0, -u[2], u[1]), (u[2], 0.0, -u[0]), (-u[1], u[0], 0.0)))
        return c * np.eye(3) + s * skew + (1.0 - c) * np.outer(u, u)  # Rodrigues' formula

    def _vector(self, value: Vector | None) -> Array:
        return np.zeros(self.dim) if value is None else np.asarray(value)

    def _forward(self, x: Array) -> Array:
        about = self._vector(self.about)
        return (x - about) @ self.matrix.T + about + self._vector(self.translate)

    def bounds(self) -> tuple[Vector, Vector]:
        lower, upper = self.shape.bounds()
        if not np.isfinite((lower, upper)).all():
            if self.rotate == 0.0:  # infinite ends stay infinite; no matrix, which would multiply infinity by zero
                about, move, scale = self._vector(self.about), self._vector(self.translate), np.broadcast_to(self.scale, self.dim)
                ends = [(np.asarray(corner) - about) * scale + about + move for corner in (lower, upper)]
                return tuple(ends[0].tolist()), tuple(ends[1].tolist())
            return (-math.inf,) * self.dim, (math.inf,) * self.dim
        corners = self._forward(np.array(list(product(*zip(lower, upper, strict=True)))))
        return tuple(corners.min(axis=0).tolist()), tuple(corners.max(axis=0).tolist())

    def depth(self, x: Array) -> Array:
        about = self._vector(self.about)
        local = (x - about - self._vector(self.translate)) @ np.linalg.inv(self.matrix).T + about
        return self.shape.depth(local) * min(self.scale)  # the smallest factor keeps it a lower bound of the distance

    def moments(self) -> Moments | None:
        inner = self.shape.moments()
        if inner is None:
            return None
        size = inner[0] * float(np.prod(np.broadcast_to(self.scale, self.dim)))
        if inner[0] == 0.0:
            return 0.0, (0.0,) * self.dim
        center = self._forward(np.asarray(inner[1])[None, :] / inner[0])[0]
        return size, tuple((size * center).tolist())


def _cos_sin(degrees: float) -> tuple[float, float]:
    """Cosine and sine, exact for multiples of 90 degrees."""
    quarter, rest = divmod(degrees, 90.0)
    c, s = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(quarter) % 4):
        c, s = -s, c
    return c, s
