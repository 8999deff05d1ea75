"""The vectors of `simd` in plain Python: same names, same rules, checked bounds."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Flat = NDArray[Any]


def _binary(op: Callable[[Any, Any], Any]) -> tuple[Callable[[Any, Any], Any], Callable[[Any, Any], Any]]:
    """An operator of vectors and its reflected form."""

    def forward(self: Vector, other: Any) -> Vector:
        return Vector(op(self.lanes, self.matched(other)))

    def reflected(self: Vector, other: Any) -> Vector:
        return Vector(op(self.matched(other), self.lanes))

    return forward, reflected


class Vector:
    """Lanes with the operators of `simd`; a value like a number: += makes a new one."""

    __slots__ = ("lanes",)
    __array_ufunc__ = None  # a numpy scalar on the left leaves the operation to this class

    def __init__(self, lanes: Flat) -> None:
        assert lanes.ndim == 1 and lanes.size in (1, 2, 4, 8, 16, 32), f"{lanes.shape} lanes"
        self.lanes = lanes

    def matched(self, other: Any) -> Any:
        """The other operand in the type of these lanes."""
        if not isinstance(other, Vector):
            return self.lanes.dtype.type(other)
        if other.lanes.dtype != self.lanes.dtype or other.lanes.size != self.lanes.size:
            raise TypeError(f"vectors of {self} and {other} do not mix")
        return other.lanes

    def __repr__(self) -> str:
        return f"{self.lanes.size} lanes of {self.lanes.dtype}"

    def __neg__(self) -> Vector:
        return Vector(-self.lanes)

    __add__, __radd__ = _binary(operator.add)
    __sub__, __rsub__ = _binary(operator.sub)
    __mul__, __rmul__ = _binary(operator.mul)
    __truediv__, __rtruediv__ = _binary(operator.truediv)


def _range(a: Flat, i: int, n: int) -> slice:
    i = int(i)
    if i < 0 or i + n > a.size:
        raise IndexError(f"lanes {i} to {i + n} of an array of {a.size}")
    return slice(i, i + n)


def load(a: Flat, i: int, n: int) -> Vector:
    """The vector a[i : i + n]."""
    return Vector(a[_range(a, i, n)].copy())


def store(a: Flat, i: int, v: Vector) -> None:
    """a[i : i + n] = v."""
    if a.dtype != v.lanes.dtype:
        raise TypeError(f"{v} do not go into an array of {a.dtype}")
    a[_range(a, i, v.lanes.size)] = v.lanes


def splat(s: Any, n: int) -> Vector:
    """n lanes of a scalar."""
    return Vector(np.full(n, s, np.result_type(s)))


def tiled(v: Vector, n: int) -> Vector:
    """n lanes, v repeated."""
    return Vector(np.tile(v.lanes, n // v.lanes.size))


def spread(s: tuple[Any, ...], c: int, n: int) -> Vector:
    """n lanes, each scalar of a tuple c times, then zeros."""
    lanes = np.zeros(n, np.result_type(s[0]))
    lanes[: c * len(s)] = np.repeat(np.array(s, lanes.dtype), c)
    return Vector(lanes)


def mixed(a: Vector, b: Vector, mask: int) -> Vector:
    """Lanes of b where a bit of the mask is set, else of a."""
    chosen = (mask >> np.arange(a.lanes.size)) & 1
    return Vector(np.where(chosen == 1, a.matched(b), a.lanes))


def summed(v: Vector, c: int) -> Vector:
    """c lanes, the sum of the groups of c lanes; halves are added, as when compiled."""
    lanes = v.lanes
    while lanes.size > c:
        lanes = lanes[: lanes.size // 2] + lanes[lanes.size // 2 :]
    return Vector(lanes)


def transpose(src: Flat, s: int, step: int, dst: Flat, d: int, stride: int) -> None:
    """dst[d + stride j + i] = src[s + step i + j] for i, j in 0..7."""
    row, column = np.arange(8)[:, None], np.arange(8)
    dst[int(d) + int(stride) * column + row] = src[int(s) + int(step) * row + column]


def prefetch(a: Flat, i: int) -> None:
    """Nothing: a hint for compiled code."""


def wide() -> None:
    """Nothing: a hint for compiled code."""


def tiny_to_zero() -> int:
    """Nothing: numpy keeps numbers below the normal range."""
    return 0


def as_before(mode: int) -> None:
    """Nothing, see `tiny_to_zero`."""
