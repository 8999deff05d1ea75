"""Size of a particle whose box follows the material: the same rule as text for the loops and in numpy.

The deformed particle is a parallelepiped with the half edges F_ab l_b. The weights take a box along the axes, so it gets the box with the
same second moment along each axis: the half size along a is (sum_b (F_ab l_b)^2)^(1/2). Pure stretch along the axes gives |F_aa| l_a, as in
Bardenhagen and Kober (2004); a rigid rotation leaves square boxes as they are, turns oblong ones, and never makes a size zero, as
the diagonal of F does after a quarter of a turn. The sum of squares is the diagonal of the left Cauchy-Green tensor, which does
not know of rotations before the stretch.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit._core.composing.source import ParticleLoop


def half_size(loop: ParticleLoop, a: int) -> str:
    """Text of the present half size along axis a [m]; declares the fields that it reads."""
    size, F = loop.field("size"), loop.field("F")
    if loop.dim == 1:
        return f"{size}[0] * {F}[0]"  # det F > 0 is guarded
    squares = [f"({size}[{b}] * {F}[{3 * a + b}]) * ({size}[{b}] * {F}[{3 * a + b}])" for b in range(loop.dim)]
    return f"sqrt({' + '.join(squares)})"


def half_sizes(size: Any, F: Any) -> Any:
    """Present half sizes [m], float64[n, dim], from the initial ones, float64[n, dim], and F, float64[n, 9]."""
    dim = np.shape(size)[1]
    edges = np.asarray(F).reshape(-1, 3, 3)[:, :dim, :dim] * np.asarray(size)[:, None, :]
    return np.sqrt((edges**2).sum(axis=2))
