"""Boundary layers: essential conditions on nodes, natural conditions on layers of particles."""

import mpmkit as mpm
from mpmkit_boundaries.prescribed_velocity import PrescribedVelocity
from mpmkit_boundaries.symmetry import Symmetry
from mpmkit_boundaries.traction_layer import TractionLayer
from mpmkit_boundaries.two_point_traction import TwoPointTraction
from mpmkit_boundaries.wall import Wall


@mpm.hookimpl
def mpmkit_components():
    """Return the boundary layers of this plugin."""
    return [PrescribedVelocity, Symmetry, TractionLayer, TwoPointTraction, Wall]
