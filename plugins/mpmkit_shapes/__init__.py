"""Bundled shape functions, one per file."""

import mpmkit as mpm
from mpmkit_shapes.bsplines import CubicBSpline, QuadraticBSpline
from mpmkit_shapes.contiguous_gimp import ContiguousGIMP
from mpmkit_shapes.gimp import GIMP
from mpmkit_shapes.linear import Linear


@mpm.hookimpl
def mpmkit_components():
    """Shape functions of this package."""
    return [Linear, GIMP, ContiguousGIMP, QuadraticBSpline, CubicBSpline]
