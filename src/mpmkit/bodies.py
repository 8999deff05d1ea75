"""Bodies: a shape filled with particles of one material, and their state at the start."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpmkit._core.sampling import estimated_count, lattice_points, lattice_side
from mpmkit.errors import CompositionError, ParameterError, shown
from mpmkit.geometry import Geometry, PointCloud
from mpmkit.grid import Grid
from mpmkit.initial import as_constant, initial_values, same
from mpmkit.interfaces import ConstitutiveModel
from mpmkit.parameters import Value, define, parameter, specs

Array = NDArray[np.float64]
_IDENTITY = np.eye(3)


@attrs.frozen(eq=False)
class Points:
    """The particles of one body at the start, as arrays of equal length.

    Attributes
    ----------
    x : float64[n, dim]
        Positions [m].
    V0 : float64[n]
        Volumes [m^3]: length times unit area in 1D, area times unit thickness in plane strain, full rings 2 pi r A when axisymmetric.
    size : float64[n, dim]
        Half edge lengths [m].
    v : float64[n, dim]
        Velocities [m/s].
    F : float64[n, 3, 3] or None
        Deformation gradients; None means the identity.
    stress : float64[n, 6] or None
        Cauchy stresses xx yy zz xy yz xz [Pa]; None means zero.
    """

    x: Array
    V0: Array
    size: Array
    v: Array
    F: Array | None = None
    stress: Array | None = None

    @property
    def n(self) -> int:
        """Number of particles."""
        return len(self.x)

    @property
    def dim(self) -> int:
        """Number of space dimensions."""
        return int(self.x.shape[1])


@define
class Body:
    """A shape made of one material, with its velocity at the start.

    The shape is filled with particles on a regular lattice; a particle belongs to the body if its centre lies inside. With
    lattice="grid" the lattice divides the cells of the grid, with "body" it starts at the lower corner of the box around the
    shape, and its spacing is adjusted so that a whole number of particles fits that box. With conserve="volume" (and so
    the exact mass) the particles' volumes are scaled to the exact volume of the shape; their sizes are not.

    `v`, `F` and `stress` may be constants, formulas of x, y, z, or functions that are called once with all positions
    float64[n, dim]. They may return values of all particles or one for all: v as (n, dim), F as (n, 3, 3), stress as (n, 6).
    """

    geometry: Geometry = parameter("shape, or cloud of points")
    material: ConstitutiveModel = parameter("what it is made of")
    v: Value = parameter("velocity at the start: numbers, formulas, or a function of position", unit="m/s", default=0.0)
    particles_per_cell: int | None = parameter(
        "number of particles in a full cell, n^dim; 2^dim if not given", ge=1, default=None, kw_only=True
    )
    name: str | None = parameter("name in messages and results", default=None, kw_only=True)
    lattice: str = parameter("what the lattice of particles is aligned to", choices=("grid", "body"), default="grid", kw_only=True)
    conserve: str = parameter(
        "what the particles together have exactly as the shape", choices=("none", "volume"), default="none", kw_only=True
    )
    F: Any = parameter("deformation gradient at the start, 3 x 3", default=None, kw_only=True)
    stress: Any = parameter("Cauchy stress at the start, xx yy zz xy yz xz", unit="Pa", default=None, kw_only=True)

    def __attrs_post_init__(self) -> None:
        dim = self.geometry.dim
        if self.name is not None and not self.name.strip():
            raise ParameterError("Body.name must not be empty; leave it out to have one chosen")
        if self.name is not None and (not self.name.isprintable() or "/" in self.name or not self.name.strip(".")):
            # files keep arrays by the names of bodies
            raise ParameterError(f"Body.name must be printable text without '/' and not only dots, got {shown(self.name)}")
        if self.particles_per_cell is not None:
            lattice_side(self.particles_per_cell, dim)
        if isinstance(self.geometry, PointCloud):
            given = [
                n for n, default in (("particles_per_cell", None), ("lattice", "grid"), ("conserve", "none")) if getattr(self, n) != default
            ]
            if given:
                raise ParameterError(f"Body.{given[0]} has no meaning for a body given by its particles; leave it out")
        # Constants are checked now, so that a mistake is reported where it is made; the rest when the positions are known.
        count = len(self.geometry.x) if isinstance(self.geometry, PointCloud) else None
        for field, shape in (("v", (dim,)), ("F", (3, 3)), ("stress", (6,))):
            unit = specs(Body)[field][1].unit
            object.__setattr__(self, field, as_constant(getattr(self, field), shape, f"Body.{field}", dim, count, unit))

    @classmethod
    def from_arrays(
        cls,
        x: ArrayLike,
        V: ArrayLike,
        material: ConstitutiveModel,
        v: Any = 0.0,
        *,
        name: str | None = None,
        F: Any = None,
        stress: Any = None,
        size: ArrayLike | None = None,
    ) -> Body:
        """A body from the positions and volumes of its particles, which are copied (see `mpmkit.geometry.PointCloud`).

        Parameters
        ----------
        x : float[n, dim]
            Positions [m]; float[n] in 1D.
        V : float[n] or float
            Volumes [m^3]; full rings in an axisymmetric grid.
        material : ConstitutiveModel
            What it is made of.
        v, F, stress
            As for `Body`, or arrays with one row for each particle.
        name : str, optional
            Name in messages and results.
        size : float[n, dim] or float[dim], optional
            Half edge lengths [m]; by default those of a square or cube of the particle's volume.

        Raises
        ------
        ParameterError
            If lengths disagree, a volume or size is not positive, or a number is not finite; names the row.
        """
        if isinstance(v, (list, tuple)) and any(np.ndim(row) for row in v if not isinstance(row, str)):
            v = np.asarray(v, dtype=np.float64)
        return cls(PointCloud(x, V, size), material, v, name=name, F=F, stress=stress)

    @property
    def label(self) -> str:
        """How messages call this body."""
        return f"body {self.name!r}" if self.name else f"body of {type(self.geometry).__name__} and {type(self.material).__name__}"

    def sample(self, grid: Grid) -> Points:
        """Fill the shape with particles.

        Raises
        ------
        CompositionError
            If no particle lies inside the shape, the body is partly outside the domain, or the dimensions differ.
        ParameterError
            If the initial state has a wrong shape or is not finite, or the exact volume is asked for and not known.
        """
        if grid.dim != self.geometry.dim:
            raise CompositionError(
                f"{self.label}: its geometry {self.geometry} has {self.geometry.dim} dimensions, the grid has {grid.dim}"
            )
        if isinstance(self.geometry, PointCloud):
            x, V0, size = self._of_cloud(grid, self.geometry)
        else:
            x, V0, size = self._on_lattice(grid)
        values = {
            field: initial_values(getattr(self, field), x, shape, f"{self.label}: {field}")
            for field, shape in (("v", (grid.dim,)), ("F", (3, 3)), ("stress", (6,)))
        }
        self._check_deformation(values["F"])
        v = values["v"]
        return Points(x, V0, size, np.broadcast_to(0.0, x.shape) if v is None else v, values["F"], values["stress"])

    def estimated_count(self, grid: Grid) -> int:
        """About how many particles `sample` would make, to some percent, in no time and memory."""
        if grid.dim != self.geometry.dim:
            return 0  # `sample` refuses it
        if isinstance(self.geometry, PointCloud):
            return len(self.geometry.x)
        return estimated_count(self.geometry, grid, self._side(grid), self.lattice, self.label)

    def _side(self, grid: Grid) -> int:
        return lattice_side(2**grid.dim if self.particles_per_cell is None else self.particles_per_cell, grid.dim)

    def _of_cloud(self, grid: Grid, cloud: PointCloud) -> tuple[Array, Array, Array]:
        outside = np.flatnonzero(~grid.contains(cloud.x))
        if len(outside):
            raise CompositionError(
                f"{self.label}: {len(outside)} of {len(cloud.x)} particles lie outside the domain {grid.lower} to {grid.upper} m, "
                f"first particle {outside[0]} at {tuple(cloud.x[outside[0]].tolist())}; move it or enlarge the grid"
            )
        x = np.clip(cloud.x, grid.lower, grid.upper)  # what rounding has put outside is on the face
        if grid.space != "axisymmetric":
            return x, cloud.V, cloud.half_edges()
        if (x[:, 0] <= 0.0).any():
            row = int(np.flatnonzero(x[:, 0] <= 0.0)[0])
            raise CompositionError(f"{self.label}: particle {row} lies on the axis r = 0, where a ring has no volume; move it to r > 0")
        rings = PointCloud(cloud.x, cloud.V / (2.0 * np.pi * cloud.x[:, 0]), cloud.size)  # as areas, for the edges
        return x, cloud.V, rings.half_edges()

    def _on_lattice(self, grid: Grid) -> tuple[Array, Array, Array]:
        x, step = lattice_points(self.geometry, grid, self._side(grid), self.lattice, self.label)
        V0 = np.broadcast_to(step.prod(), len(x))  # equal values take no memory
        if grid.space == "axisymmetric":
            V0 = V0 * 2.0 * np.pi * x[:, 0]  # exact for a ring of rectangular section, by Pappus's theorem
        if self.conserve == "volume":
            V0 = V0 * (self._exact_volume(grid) / V0.sum())
        return x, V0, np.broadcast_to(0.5 * step, x.shape)

    def _exact_volume(self, grid: Grid) -> float:
        moments = self.geometry.moments()
        if moments is None:
            raise ParameterError(
                f"{self.label}: conserve='volume' needs a shape whose exact volume is known, {self.geometry} has none; "
                "leave conserve out, or use one of the basic shapes or combinations of shapes that are apart or nested"
            )
        return 2.0 * np.pi * moments[1][0] if grid.space == "axisymmetric" else moments[0]

    def _check_deformation(self, F: Array | None) -> None:
        if F is not None:
            bad = np.flatnonzero(np.linalg.det(F) <= 0.0)
            if len(bad):
                raise ParameterError(
                    f"{self.label}: F must have a determinant > 0, got {np.linalg.det(F[bad[0]]):g} at particle {bad[0]} "
                    f"({len(bad)} such particles)"
                )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Body):
            return NotImplemented
        return all(same(getattr(self, name), getattr(other, name)) for name in specs(Body))

    def __hash__(self) -> int:
        return hash((self.geometry, self.material, self.name))


def overlapping(a: Points, b: Points) -> NDArray[np.int_]:
    """Particles of `a` that share space with a particle of `b`.

    Two particles count if their centres are no further apart, along every axis, than the mean of their half edges: then
    wherever two bodies overlap by a cell or more such a pair exists, and none where they merely touch.

    Parameters
    ----------
    a, b : Points
        Of two bodies on one grid.

    Returns
    -------
    int[k]
        Their numbers in `a`, ascending; empty if the bodies are apart.
    """
    none = np.zeros(0, dtype=np.int_)
    reach = 0.5 * (a.size.max(axis=0) + b.size.max(axis=0)) * (1.0 + 1e-9)
    near = ((a.x >= b.x.min(axis=0) - reach) & (a.x <= b.x.max(axis=0) + reach)).all(axis=1)
    if not near.any():
        return none
    from scipy.spatial import cKDTree  # type: ignore[import-untyped,unused-ignore]

    rows = np.flatnonzero(near)
    count = min(8, b.n)  # of several neighbours, because the nearest one may be smaller than the next
    distance, found = cKDTree(b.x / reach).query(a.x[rows] / reach, k=count, p=np.inf, distance_upper_bound=1.0 + 1e-9)
    distance, found = distance.reshape(len(rows), count), found.reshape(len(rows), count)
    hit = np.zeros(len(rows), dtype=bool)
    for k in range(count):
        there = np.flatnonzero(np.isfinite(distance[:, k]))
        mean = 0.5 * (a.size[rows[there]] + b.size[found[there, k]]) * (1.0 + 1e-9)
        hit[there] |= (np.abs(a.x[rows[there]] - b.x[found[there, k]]) <= mean).all(axis=1)
    return rows[hit]
