"""Whether one shape lies within another, or apart from it: sufficient tests, for exact volumes of combinations."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from mpmkit.geometry.base import ROUNDING, Geometry, empty_or_infinite
from mpmkit.geometry.primitives import Box, Cylinder, Disk, HalfSpace, Sphere

_CONVEX = (Box, Disk, Sphere, Cylinder, HalfSpace)


def disjoint(a: Geometry, b: Geometry) -> bool:
    """True if a and b surely share no volume; False if they may."""
    (low_a, up_a), (low_b, up_b) = a.bounds(), b.bounds()
    ends = [abs(c) for c in (*low_a, *up_a, *low_b, *up_b) if math.isfinite(c)]
    slack = ROUNDING * max(ends, default=0.0)  # faces that touch up to rounding share no volume
    if any(ua <= lb + slack or ub <= la + slack for la, ua, lb, ub in zip(low_a, up_a, low_b, up_b, strict=True)):
        return True
    if isinstance(a, (Disk, Sphere)) and isinstance(b, (Disk, Sphere)):
        return math.dist(a.center, b.center) >= a.radius + b.radius
    return False


def encloses(a: Geometry, b: Geometry) -> bool:
    """True if b surely lies within a; False if it may not."""
    if a == b:
        return True
    if isinstance(a, (Disk, Sphere)) and isinstance(b, (Disk, Sphere)):
        return math.dist(a.center, b.center) + b.radius <= a.radius
    if isinstance(a, Cylinder) and isinstance(b, Cylinder) and np.abs(np.cross(a.direction, b.direction)).max() == 0.0:
        return _cylinder_in_cylinder(a, b)
    if isinstance(a, _CONVEX) and not empty_or_infinite(b):
        corners = np.array(list(product(*zip(*b.bounds(), strict=True))))
        return bool(a.contains(corners).all())
    return False


def _cylinder_in_cylinder(a: Cylinder, b: Cylinder) -> bool:
    """For parallel axes."""
    offsets = np.subtract((b.start, b.end), a.start)
    along = offsets @ a.direction
    across = np.linalg.norm(offsets - along[:, None] * a.direction, axis=1)
    slack = 1e-12 * a.length
    return bool((along >= -slack).all() and (along <= a.length + slack).all() and across.max() + b.radius <= a.radius)
