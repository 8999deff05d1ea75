"""Regular lattices of particles inside a shape."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from mpmkit.errors import CompositionError, ParameterError
from mpmkit.geometry import Geometry
from mpmkit.grid import Grid

Array = NDArray[np.float64]
_CHUNK = 1 << 17  # candidate points that are tested at once, to bound memory
_SLACK = 1e-9  # in lattice spacings
_PROBES = (1024, 128, 32)  # points along an edge of the box around a shape, in 1D, 2D and 3D, from which its particles are estimated


def lattice_side(particles_per_cell: int, dim: int) -> int:
    """Number of particles along one edge of a cell; `ParameterError` unless `particles_per_cell` is its power `dim`."""
    side = max(1, round(math.pow(particles_per_cell, 1.0 / dim)))
    if side**dim != particles_per_cell:
        low = side if side**dim < particles_per_cell else side - 1
        raise ParameterError(
            f"Body.particles_per_cell must be n^{dim} in {dim}D, because the lattice is regular; got {particles_per_cell}, "
            f"the nearest are {low**dim} and {(low + 1) ** dim}"
        )
    return side


def lattice_points(geometry: Geometry, grid: Grid, side: int, lattice: str, label: str) -> tuple[Array, Array]:
    """Lattice points inside a shape.

    Parameters
    ----------
    geometry : Geometry
        The shape. In a direction without end it ends at the domain.
    grid : Grid
        The domain.
    side : int
        Points along an edge of a cell.
    lattice : str
        "grid" or "body", see `mpmkit.Body`.
    label : str
        Name of the body in messages.

    Returns
    -------
    x : float64[n, dim]
        Points [m], the last axis running fastest.
    step : float64[dim]
        Distance between them along each axis [m].
    """
    lower, upper = _finite_bounds(geometry, grid, label)
    base, first, counts, step = _lattice(lower, upper, grid, side, lattice)
    if (counts >= 1).all():
        ticks = [b + (k + 0.5 + np.arange(int(n))) * d for b, k, n, d in zip(base, first, counts, step, strict=True)]
        x = _inside(geometry, ticks)
    else:
        x = np.zeros((0, grid.dim))
    if not len(x):
        raise CompositionError(
            f"{label}: no particle lies inside {geometry}, which reaches from {_text(lower)} to {_text(upper)} m; the "
            "lattice has a spacing of "
            f"{_text(step)} m: refine the grid, raise particles_per_cell, or set lattice='body'"
        )
    _check_inside_domain(x, grid, label)
    return x, step


def estimated_count(geometry: Geometry, grid: Grid, side: int, lattice: str, label: str) -> int:
    """About how many points `lattice_points` would give: few of them tell which share of the box around the shape is inside."""
    lower, upper = _finite_bounds(geometry, grid, label)
    _, _, counts, _ = _lattice(lower, upper, grid, side, lattice)
    if (counts < 1).any():
        return 0
    few = np.minimum(counts, _PROBES[grid.dim - 1])
    ticks = [low + (np.arange(int(n)) + 0.5) * ((high - low) / n) for low, high, n in zip(lower, upper, few, strict=True)]
    points = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, grid.dim)
    return round(math.prod(counts) * float(np.mean(geometry.contains(points))))


def _lattice(lower: Array, upper: Array, grid: Grid, side: int, lattice: str) -> tuple[Array, Array, Array, Array]:
    """Origin of the lattice, number of its first point, numbers of points and distances between them, along each axis."""
    step = np.asarray(grid.spacing) / side
    if lattice == "grid":
        base = np.asarray(grid.lower)
        first = np.ceil((lower - base) / step - 0.5 - _SLACK)
        return base, first, np.floor((upper - base) / step - 0.5 + _SLACK) - first + 1.0, step
    extent = np.maximum(upper - lower, 0.0)
    counts = np.maximum(np.round(extent / step), 1.0)
    return lower, np.zeros(grid.dim), counts, np.where(extent > 0.0, extent / counts, step)


def _finite_bounds(geometry: Geometry, grid: Grid, label: str) -> tuple[Array, Array]:
    corners = [np.asarray(corner, dtype=float) for corner in geometry.bounds()]
    lower = np.where(np.isfinite(corners[0]), corners[0], grid.lower)
    upper = np.where(np.isfinite(corners[1]), corners[1], grid.upper)
    slack = _SLACK * np.asarray(grid.spacing)
    if geometry.tight_bounds and ((lower < grid.lower - slack) | (upper > grid.upper + slack)).any():
        raise CompositionError(
            f"{label} reaches from {_text(lower)} to {_text(upper)} m, outside the domain from {_text(grid.lower)} to "
            f"{_text(grid.upper)} m; "
            "move it, enlarge the grid, or cut it with a Box"
        )
    return lower, upper


def _inside(geometry: Geometry, ticks: list[Array]) -> Array:
    """Points of the lattice inside the shape, slab by slab."""
    layer = math.prod(len(t) for t in ticks[1:])
    slab = max(1, _CHUNK // max(layer, 1))
    found = []
    for k in range(0, len(ticks[0]), slab):
        points = np.stack(np.meshgrid(ticks[0][k : k + slab], *ticks[1:], indexing="ij"), axis=-1).reshape(-1, len(ticks))
        found.append(points[geometry.contains(points)])
    return np.concatenate(found)


def _check_inside_domain(x: Array, grid: Grid, label: str) -> None:
    outside = np.flatnonzero(~grid.contains(x))
    if len(outside):
        raise CompositionError(
            f"{label}: {len(outside)} of {len(x)} particles lie outside the domain from {_text(grid.lower)} to {_text(grid.upper)} m, "
            f"for example at {_text(x[outside[0]])}; move the body, enlarge the grid, or cut it with a Box"
        )


def _text(vector: Array | tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{c:g}" for c in vector) + ")"
