"""Shapes that bodies are cut from: primitives, boolean combinations, transformations and clouds of points.

Only `Geometry` itself is there at once; the shapes need numpy, which a plugin that takes a geometry as parameter does not.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from mpmkit.geometry.base import Geometry

if TYPE_CHECKING:
    from mpmkit.geometry.booleans import Difference, Intersection, Union
    from mpmkit.geometry.catalog import GEOMETRIES
    from mpmkit.geometry.cloud import PointCloud
    from mpmkit.geometry.polygon import Polygon
    from mpmkit.geometry.primitives import Box, Cylinder, Disk, HalfSpace, Sphere
    from mpmkit.geometry.transformed import Transformed

_WHERE = {
    "booleans": ("Difference", "Intersection", "Union"),
    "catalog": ("GEOMETRIES",),
    "cloud": ("PointCloud",),
    "polygon": ("Polygon",),
    "primitives": ("Box", "Cylinder", "Disk", "HalfSpace", "Sphere"),
    "transformed": ("Transformed",),
}
_MODULE_OF = {name: module for module, names in _WHERE.items() for name in names}

__all__ = [
    "GEOMETRIES",
    "Box",
    "Cylinder",
    "Difference",
    "Disk",
    "Geometry",
    "HalfSpace",
    "Intersection",
    "PointCloud",
    "Polygon",
    "Sphere",
    "Transformed",
    "Union",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(_MODULE_OF))
