"""Gravity."""

import mpmkit as mpm


@mpm.kernel
def uniform_acceleration(g):
    """a_i = g at every node."""
    return g


@mpm.define
class Gravity(mpm.Effect):
    """Uniform acceleration of all nodes, (mv)_i += dt m_i g (SAND2002-0482 eq 1-17b)."""

    references = ("Chen and Brannon (2002), SAND2002-0482, eq 1-17b",)
    g: mpm.Vector = mpm.parameter("acceleration, one number per direction", unit="m/s^2", example=(0.0, -9.81))
    acceleration = uniform_acceleration
