"""Finite elements behind the same composition as the material point method."""

import mpmkit as mpm
from mpmkit_fem.total_lagrangian import FEM


@mpm.hookimpl
def mpmkit_components():
    """Return the discretization of this plugin."""
    return [FEM]
