"""The shapes a scene file can name; a `PointCloud` is made from arrays in a script."""

from __future__ import annotations

from mpmkit.geometry.base import Geometry
from mpmkit.geometry.booleans import Difference, Intersection, Union
from mpmkit.geometry.polygon import Polygon
from mpmkit.geometry.primitives import Box, Cylinder, Disk, HalfSpace, Sphere
from mpmkit.geometry.transformed import Transformed

GEOMETRIES: dict[str, type[Geometry]] = {
    c.__name__: c for c in (Box, Disk, Sphere, Cylinder, Polygon, HalfSpace, Union, Intersection, Difference, Transformed)
}
"""Shapes by class name."""
