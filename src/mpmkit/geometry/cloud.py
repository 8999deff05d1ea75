"""A body given by its particles rather than by a shape."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpmkit.errors import ParameterError
from mpmkit.geometry.base import Array, Geometry, Moments


def frozen_array(values: ArrayLike, name: str, shape: tuple[int | None, ...]) -> Array:
    """A read-only float64 copy of `values` with the given shape (None: any length); all numbers must be finite.

    Raises
    ------
    ParameterError
        Naming the shape, or the first row that is not finite.
    """
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{name} must be numbers: {error}") from None
    if array.ndim != len(shape) or any(want is not None and want != got for want, got in zip(shape, array.shape, strict=True)):
        wanted = ", ".join("n" if s is None else str(s) for s in shape)
        raise ParameterError(f"{name} must have the shape ({wanted}{',' if len(shape) == 1 else ''}), got {array.shape}")
    rows = np.atleast_1d(array)
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=tuple(range(1, rows.ndim))))
    if len(bad):
        raise ParameterError(f"{name} must be finite, got {rows[bad[0]].tolist()} in row {bad[0]} ({len(bad)} such rows)")
    array.setflags(write=False)
    return array


@attrs.frozen(eq=False, slots=False, init=False)
class PointCloud(Geometry):
    """Particles given by arrays, which are copied.

    Parameters
    ----------
    x : float[n, dim]
        Positions [m]; float[n] in 1D.
    V : float[n] or float
        Volumes [m^3]: length times unit area in 1D, area times unit thickness in plane strain, full rings when axisymmetric.
    size : float[n, dim] or float[dim], optional
        Half edge lengths [m]; by default those of a square or cube of volume V.
    """

    x: Array
    V: Array
    size: Array | None = None

    def __init__(self, x: ArrayLike, V: ArrayLike, size: ArrayLike | None = None) -> None:
        positions: Any = np.asarray(x)
        positions = frozen_array(positions[:, None] if positions.ndim == 1 else positions, "x", (None, None))
        n, dim = positions.shape
        if n == 0 or not 1 <= dim <= 3:
            raise ParameterError(f"x must have the shape (n, 1), (n, 2) or (n, 3) with n >= 1, got {positions.shape}")
        volumes = frozen_array(np.broadcast_to(V, (n,)) if np.ndim(V) == 0 else V, "V", (n,))
        bad = np.flatnonzero(volumes <= 0.0)
        if len(bad):
            raise ParameterError(f"V must be > 0, got {volumes[bad[0]]:g} m^3 in row {bad[0]} ({len(bad)} such rows)")
        if size is not None:
            size = frozen_array(np.broadcast_to(size, (n, dim)) if np.ndim(size) < 2 else size, "size", (n, dim))
            if (size <= 0.0).any():
                raise ParameterError(f"size must be > 0, got {size.min():g} m")
        self.__attrs_init__(positions, volumes, size)

    @property
    def dim(self) -> int:
        return int(self.x.shape[1])

    def half_edges(self) -> Array:
        """Half edge lengths [m], float64[n, dim]; V as a length, area or volume if no size was given."""
        if self.size is not None:
            return self.size
        return np.repeat(0.5 * self.V[:, None] ** (1.0 / self.dim), self.dim, axis=1)

    def bounds(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The box around the positions."""
        return tuple(self.x.min(axis=0).tolist()), tuple(self.x.max(axis=0).tolist())

    def depth(self, x: Array) -> Array:
        """Depth below the surface of the nearest particle's box."""
        from scipy.spatial import cKDTree  # type: ignore[import-untyped,unused-ignore]

        from mpmkit.geometry.base import box_depth

        _, nearest = cKDTree(self.x).query(x)
        return box_depth(np.abs(x - self.x[nearest]) - self.half_edges()[nearest])

    def moments(self) -> Moments:
        return float(self.V.sum()), tuple((self.V @ self.x).tolist())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, PointCloud):
            return NotImplemented
        return same_arrays(self.x, other.x) and same_arrays(self.V, other.V) and same_arrays(self.size, other.size)

    def __hash__(self) -> int:
        return hash((self.x.shape, self.x.tobytes(), self.V.tobytes()))

    def __repr__(self) -> str:
        return f"PointCloud({len(self.x)} points in {self.dim}D)"


def same_arrays(a: NDArray[Any] | None, b: NDArray[Any] | None) -> bool:
    """Whether two arrays, or two absent ones, are equal."""
    return (a is None and b is None) or (a is not None and b is not None and np.array_equal(a, b))
