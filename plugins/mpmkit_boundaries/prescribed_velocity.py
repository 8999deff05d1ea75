"""Prescribed velocities, on faces or in a region."""

import mpmkit as mpm
from mpmkit.geometry import Geometry
from mpmkit_boundaries.faces import FACES, resolve


@mpm.kernel
def all_components(v, velocity):
    """v = V."""
    return (velocity[0] + 0.0 * v[0], velocity[1] + 0.0 * v[0], velocity[2] + 0.0 * v[0])


@mpm.kernel
def normal_component(v, velocity, normal):
    """v . n = V . n, tangential components free."""
    d = (velocity[0] - v[0]) * normal[0] + (velocity[1] - v[1]) * normal[1] + (velocity[2] - v[2]) * normal[2]
    return (v[0] + d * normal[0], v[1] + d * normal[1], v[2] + d * normal[2])


@mpm.kernel
def tangential_components(v, velocity, normal):
    """v - (v . n) n = V - (V . n) n, the normal component free."""
    d = (v[0] - velocity[0]) * normal[0] + (v[1] - velocity[1]) * normal[1] + (v[2] - velocity[2]) * normal[2]
    return (velocity[0] + d * normal[0], velocity[1] + d * normal[1], velocity[2] + d * normal[2])


@mpm.kernel
def x_component(v, velocity):
    """v_x = V_x, the other components free."""
    return (velocity[0] + 0.0 * v[0], v[1], v[2])


@mpm.kernel
def y_component(v, velocity):
    """v_y = V_y, the other components free."""
    return (v[0], velocity[1] + 0.0 * v[0], v[2])


@mpm.kernel
def z_component(v, velocity):
    """v_z = V_z, the other components free."""
    return (v[0], v[1], velocity[2] + 0.0 * v[0])


CHOICES = {
    "all": all_components,
    "normal": normal_component,
    "tangential": tangential_components,
    "x": x_component,
    "y": y_component,
    "z": z_component,
}


@mpm.define
class PrescribedVelocity(mpm.BoundaryLayer):
    """Prescribed velocity v = V(x, t) of nodes on faces of the domain or in a region: all components, the normal or the tangential ones.

    ``velocity`` is a vector, texts of formulas in x, y, z, t, or a scalar Python function of any of ``x``, ``t``. A
    ``region`` rests, or moves with ``moving`` (a constant velocity of the region).
    """

    references = ("Chen and Brannon (2002), SAND2002-0482, section 2: prescribed normal and tangential velocity",)
    velocity: mpm.Value = mpm.parameter("velocity", unit="m/s", example=(1.0, 0.0))
    faces: tuple[str, ...] = mpm.parameter("faces of the domain", choices=("all", *FACES), default=(), example="xmax")
    region: Geometry | None = mpm.parameter("nodes inside this shape, in place of faces", default=None)
    components: str = mpm.parameter("which components are prescribed", choices=tuple(CHOICES), default="all")
    moving: mpm.Vector | None = mpm.parameter("velocity of the region", unit="m/s", default=None)

    def check(self):
        if bool(self.faces) == (self.region is not None):
            raise mpm.ParameterError("PrescribedVelocity needs either faces or a region")
        if self.region is not None and self.components in ("normal", "tangential"):
            raise mpm.ParameterError("PrescribedVelocity.components: a region has no normal; use 'all', 'x', 'y' or 'z'")
        if self.moving is not None and self.region is None:
            raise mpm.ParameterError("PrescribedVelocity.moving needs a region; faces of the domain rest")

    @property
    def constrain(self):
        return CHOICES[self.components]

    def faces_of(self, grid):
        return resolve(self.faces, grid, "PrescribedVelocity.faces")

    def nodes_in(self, x, t):
        if self.region is None:
            return None
        if self.moving is not None:
            x = x - t * _array(self.moving)
        return self.region.contains(x)

    def speed(self):
        value = self.velocity
        numbers = value if isinstance(value, tuple) else (value,)
        return max((abs(n) for n in numbers if isinstance(n, float)), default=0.0)


def _array(v):
    import numpy as np

    return np.asarray(v)
