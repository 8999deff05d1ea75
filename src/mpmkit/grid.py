"""The domain and its regular background grid."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpmkit.errors import ParameterError, shown
from mpmkit.parameters import Vector, define, parameter

AXES = ("x", "y", "z")
_WHOLE = 1e-9  # how far, in cells, a domain may be from a whole number of cells


@define
class Grid:
    """A box-shaped domain divided into equal cells.

    One to three numbers in `lower` and `upper` decide the number of space dimensions. In 2D, "cartesian" means plane
    strain with unit thickness and "axisymmetric" means (r, z) with the axis at r = 0; volumes are then those of full rings.
    In 1D, lateral="strain" is a column that cannot widen, "stress" a slender bar whose sides are free.

    Raises
    ------
    ParameterError
        If the lengths disagree, a side is not a whole number of cells (the nearest upper corner is proposed), a side has fewer than
        two cells, or the coordinates do not fit the dimension.
    """

    lower: Vector = parameter("lower corner of the domain", unit="m", example=(0.0, 0.0))
    upper: Vector = parameter("upper corner of the domain", unit="m", example=(1.0, 1.0))
    spacing: Vector = parameter("edge of a cell: one number, or one for each axis", unit="m", gt=0.0, example=0.05)
    coordinates: str = parameter("meaning of the axes in 2D", choices=("cartesian", "axisymmetric"), default="cartesian")
    lateral: str = parameter("what the sides of a 1D bar do: no strain, or no stress", choices=("strain", "stress"), default="strain")

    def __attrs_post_init__(self) -> None:
        dim = len(self.lower)
        if not 1 <= dim <= 3:
            raise ParameterError(f"Grid.lower must have 1, 2 or 3 numbers, got {dim}: {shown(self.lower)}")
        if len(self.upper) != dim:
            raise ParameterError(f"Grid.upper must have {dim} numbers like lower {self.lower}, got {len(self.upper)}: {shown(self.upper)}")
        if len(self.spacing) not in (1, dim):
            raise ParameterError(
                f"Grid.spacing must be one number or {dim}, one for each axis, got {len(self.spacing)}: {shown(self.spacing)}"
            )
        for name in ("lower", "upper", "spacing"):
            if not all(math.isfinite(c) for c in getattr(self, name)):
                raise ParameterError(f"Grid.{name} must be finite, got {getattr(self, name)}")
        if len(self.spacing) != dim:
            object.__setattr__(self, "spacing", self.spacing * dim)  # frozen: one number stands for all axes
        for axis in range(dim):
            self._check_side(axis)
        self._check_coordinates()

    def _check_side(self, axis: int) -> None:
        low, up, h, name = self.lower[axis], self.upper[axis], self.spacing[axis], AXES[axis]
        if up <= low:
            raise ParameterError(f"Grid.upper must be > Grid.lower in {name}, got lower {low:g} and upper {up:g} [m]")
        count = (up - low) / h
        if count > 2**31:
            raise ParameterError(
                f"Grid.spacing {h:g} m divides the side in {name} ({up - low:g} m) into {count:.3g} cells; at most 2^31 are possible"
            )
        whole = max(2, round(count))
        if abs(count - round(count)) > max(_WHOLE, 4 * np.finfo(float).eps * count):
            raise ParameterError(
                f"Grid: the side in {name} from {low:g} to {up:g} m is {count:.9g} cells of {h:g} m, not a whole number; "
                f"set upper in {name} to {low + whole * h:.12g}, or spacing to {(up - low) / whole:.12g}"
            )
        if round(count) < 2:
            raise ParameterError(
                f"Grid: the side in {name} has {round(count)} cell; at least 2 are needed: set spacing to at most {(up - low) / 2:.12g} m"
            )

    def _check_coordinates(self) -> None:
        if self.coordinates == "axisymmetric":
            if self.dim != 2:
                raise ParameterError(f"Grid.coordinates 'axisymmetric' needs 2 numbers (r, z) in lower and upper, got {self.dim}")
            if self.lower[0] < 0.0:
                raise ParameterError(
                    f"Grid.lower: the radius must be >= 0 in axisymmetric coordinates, got {self.lower[0]:g}; the axis is at r = 0"
                )
        if self.lateral == "stress" and self.dim != 1:
            raise ParameterError(
                f"Grid.lateral 'stress' (a slender bar) works in 1D only, this grid has {self.dim} dimensions; leave it out"
            )

    @property
    def dim(self) -> int:
        """Number of space dimensions."""
        return len(self.lower)

    @property
    def cells(self) -> tuple[int, ...]:
        """Number of cells along each axis."""
        return tuple(round((u - lo) / h) for lo, u, h in zip(self.lower, self.upper, self.spacing, strict=True))

    @property
    def nodes(self) -> tuple[int, ...]:
        """Number of nodes along each axis."""
        return tuple(n + 1 for n in self.cells)

    @property
    def n_nodes(self) -> int:
        """Number of nodes in all."""
        return math.prod(self.nodes)

    @property
    def n_cells(self) -> int:
        """Number of cells in all."""
        return math.prod(self.cells)

    @property
    def h(self) -> float:
        """Smallest spacing [m]."""
        return min(self.spacing)

    @property
    def space(self) -> str:
        """One of `mpmkit.interfaces.SPACES`."""
        if self.dim == 2:
            return "axisymmetric" if self.coordinates == "axisymmetric" else "plane strain"
        return "1D" if self.dim == 1 else "3D"

    @property
    def faces(self) -> tuple[str, ...]:
        """Names of the faces of the domain: "xmin", "xmax", "ymin" ..."""
        return tuple(f"{AXES[axis]}{end}" for axis in range(self.dim) for end in ("min", "max"))

    def node_positions(self) -> NDArray[np.float64]:
        """Positions of all nodes, float64[n_nodes, dim] [m]; the last axis runs fastest."""
        ticks = [lo + h * np.arange(n) for lo, h, n in zip(self.lower, self.spacing, self.nodes, strict=True)]
        return np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, self.dim)

    def contains(self, x: ArrayLike) -> NDArray[np.bool_]:
        """Which of the points float[n, dim] lie in the domain; its faces belong to it, to 1e-9 of a cell. Returns bool[n]."""
        points = as_points(x, self.dim)
        slack = _WHOLE * np.asarray(self.spacing)
        inside = (points >= np.asarray(self.lower) - slack) & (points <= np.asarray(self.upper) + slack)
        return np.asarray(inside.all(axis=1))


def as_points(x: Any, dim: int) -> NDArray[np.float64]:
    """Points as float64[n, dim]; in 1D also from float[n].

    Raises
    ------
    ParameterError
        If the shape is another one.
    """
    points = np.asarray(x, dtype=np.float64)
    if points.ndim == 1 and dim == 1:
        points = points[:, None]
    if points.ndim != 2 or points.shape[1] != dim:
        raise ParameterError(f"positions must have the shape (n, {dim}), got {points.shape}")
    return points
