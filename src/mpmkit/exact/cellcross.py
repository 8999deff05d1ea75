"""The spurious nodal force of a uniformly stressed bar: the cell-crossing error of a shape function, exactly.

In an infinite bar with evenly spaced particles of equal volume and stress, the internal force of every node should vanish;
what is left is f / (stress area) = spacing / h * sum over particles of h dN/dx, and depends on where the particles lie.
"""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.exact.solution import Array


@attrs.frozen
class Shape1D:
    """The gradient of a one-dimensional shape function.

    Parameters
    ----------
    gradient : callable
        Takes distances r = (x_p - x_i) / h, float64[n], and returns h dN/dx, float64[n]. Between kinks it must be a polynomial
        of degree two or less.
    kinks : tuple of float
        All r >= 0 where the gradient is not smooth, 0 excepted; the last one ends the support.
    """

    gradient: Callable[[Array], Array]
    kinks: tuple[float, ...]


def _linear(r: Array) -> Array:
    return np.where(np.abs(r) < 1.0, -np.sign(r), 0.0)


def _quadratic(r: Array) -> Array:
    a = np.abs(r)
    return np.select([a < 0.5, a < 1.5], [-2.0 * r, -np.sign(r) * (1.5 - a)], 0.0)


def _cubic(r: Array) -> Array:
    a = np.abs(r)
    return np.asarray(np.sign(r) * np.select([a < 1.0, a < 2.0], [1.5 * a**2 - 2.0 * a, -0.5 * (2.0 - a) ** 2], 0.0))


SHAPES = {
    "linear": Shape1D(_linear, (1.0,)),
    "quadratic B-spline": Shape1D(_quadratic, (0.5, 1.5)),
    "cubic B-spline": Shape1D(_cubic, (1.0, 2.0)),
}
"""Shape functions by name; `gimp` makes that of the generalized interpolation method."""


def gimp(half_size: float) -> Shape1D:
    """The GIMP function of particles that reach `half_size` (over h, in (0, 0.5]) to each side.

    Contiguous particles have half their spacing, uniform GIMP with two particles per cell 0.25 whatever the spacing is now.

    References
    ----------
    Bardenhagen and Kober (2004), Comput. Model. Eng. Sci. 5, 477.

    Raises
    ------
    ParameterError
        If half_size is out of range.
    """
    if not 0.0 < half_size <= 0.5:
        raise ParameterError(f"gimp: half_size must be > 0, <= 0.5 (in cells), got {half_size:g}; use more particles per cell")

    def gradient(r: Array) -> Array:
        a = np.abs(r)
        slope = [a / half_size, np.ones_like(a), (1.0 + half_size - a) / (2.0 * half_size)]
        return np.asarray(-np.sign(r) * np.select([a < half_size, a < 1.0 - half_size, a < 1.0 + half_size], slope, 0.0))

    return Shape1D(gradient, (half_size, 1.0 - half_size, 1.0 + half_size))


def nodal_force(shape: Shape1D | str, spacing: float, offsets: Array) -> Array:
    """Spurious force over stress and area [1], float64[n], if a particle lies at `offsets` * spacing right of the node.

    Parameters
    ----------
    shape : Shape1D or str
        The shape function, or its name in ``SHAPES``.
    spacing : float
        Distance of particles over that of nodes, > 0.
    offsets : float64[n]
        In units of the spacing.

    Raises
    ------
    ParameterError
        If the name is unknown or the spacing not positive.
    """
    shape = _checked(shape, spacing)
    reach = int(np.ceil(shape.kinks[-1] / spacing)) + 1
    k = np.arange(-reach, reach + 1)
    offsets = np.asarray(offsets, dtype=np.float64) % 1.0
    r = (k[None, :] + offsets[:, None]) * spacing
    return np.asarray(spacing * shape.gradient(r.ravel()).reshape(r.shape).sum(axis=1))


def cell_crossing_force(shape: Shape1D | str, spacing: float) -> float:
    """Largest spurious force over stress and area [1], over all positions of the particles relative to the node.

    It is exact but for rounding: between the positions where some particle passes a kink, the force is a polynomial of
    degree two in the offset, which three values determine.

    Parameters
    ----------
    shape : Shape1D or str
        The shape function, or its name in ``SHAPES``.
    spacing : float
        Distance of particles over that of nodes, > 0.

    Examples
    --------
    ``cell_crossing_force("linear", 1 / 1.1)`` is 1 / 1.1: the node loses a whole particle.
    """
    shape = _checked(shape, spacing)
    edges = np.array([0.0, 1.0, *(s * kink / spacing % 1.0 for kink in shape.kinks for s in (-1.0, 1.0))])
    edges = np.unique(edges)
    # Pieces as short as rounding are not pieces.
    edges = edges[np.concatenate([[True], np.diff(edges) > 1e-9])]
    left, width = edges[:-1], np.diff(edges)
    f1, f2, f3 = (nodal_force(shape, spacing, left + s * width) for s in (0.25, 0.5, 0.75))
    # Parabola in z = -1 .. 1 through its values at -1/2, 0 and 1/2.
    slope, bend = f3 - f1, 2.0 * (f1 - 2.0 * f2 + f3)
    candidates = [f2 - slope + bend, f2 + slope + bend]
    turns = np.abs(bend) > 1e-12
    z = np.where(turns, -slope / np.where(turns, 2.0 * bend, 1.0), 0.0)
    candidates.append(np.where(np.abs(z) < 1.0, f2 + z * (slope + bend * z), 0.0))
    return float(np.max(np.abs(candidates)))


def _checked(shape: Shape1D | str, spacing: float) -> Shape1D:
    if not spacing > 0.0:
        raise ParameterError(f"spacing must be > 0 (particle spacing over cell size), got {spacing:g}")
    if isinstance(shape, Shape1D):
        return shape
    if shape not in SHAPES:
        raise ParameterError(f"no shape function named {shape!r}{did_you_mean(shape, SHAPES)}; known: {', '.join(SHAPES)}")
    return SHAPES[shape]
