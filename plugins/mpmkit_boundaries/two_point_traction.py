"""Traction at the boundary itself, by a vector from the boundary particle to the boundary."""

import mpmkit as mpm
from mpmkit_boundaries.faces import FACES
from mpmkit_boundaries.layers import face_layer, selection


@mpm.kernel
def boundary_force(traction, area, F, arm0):
    """The traction acts at x_p + F arm0, the material point on the boundary."""
    force = (area * traction[0], area * traction[1], area * traction[2])
    arm = (
        F[0] * arm0[0] + F[1] * arm0[1] + F[2] * arm0[2],
        F[3] * arm0[0] + F[4] * arm0[1] + F[5] * arm0[2],
        F[6] * arm0[0] + F[7] * arm0[1] + F[8] * arm0[2],
    )
    return force, arm


@mpm.define
class TwoPointTraction(mpm.BoundaryLayer):
    """Traction at the boundary, with fields that vary linearly between the boundary particle and the boundary.

    The "alternative method" of SAND2002-0482 section 2: each boundary particle is endowed with a vector s to the
    boundary, carried as F s; the work of the traction is done on the velocity v_p + L_p s there, so that
    f_i = A t (N_i + s . grad N_i). Force and torque are exact wherever the particle stands in its cell, and the stress
    next to the loaded end is the traction itself.

    ``traction`` is a vector, texts of formulas, or a scalar Python function of any of ``x``, ``X``, ``t``.
    """

    references = ("Chen and Brannon (2002), SAND2002-0482, section 2, Alternative methods",)
    body: str = mpm.parameter("name of the loaded body", example="bar")
    traction: mpm.Value = mpm.parameter("force per area", unit="Pa", example=(1.0,))
    face: str = mpm.parameter("the body's face that is loaded", choices=FACES, example="xmax")
    load = boundary_force

    def select(self, points, grid):
        axis = "xyz".index(self.face[0])
        chosen, normals, arms = face_layer(points, self.face, None, "TwoPointTraction")
        area = points.V0[chosen] / (2.0 * points.size[chosen, axis])
        if grid.space == "axisymmetric":  # the ring at the boundary is not that through the particle's centre
            area = area * (points.x[chosen, 0] + arms[:, 0]) / points.x[chosen, 0]
        return selection(chosen, area, normals, arms)
