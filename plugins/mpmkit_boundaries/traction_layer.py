"""Traction carried by a layer of particles."""

import mpmkit as mpm
from mpmkit.geometry import Geometry
from mpmkit_boundaries.faces import FACES
from mpmkit_boundaries.layers import face_layer, selection


@mpm.kernel
def layer_force(traction, area):
    """M_p c_p / h = (V0_p / h) traction, at the particle itself (eq 1-16)."""
    return (area * traction[0], area * traction[1], area * traction[2]), (0.0 * area, 0.0 * area, 0.0 * area)


@mpm.define
class TractionLayer(mpm.BoundaryLayer):
    """Traction carried by the particles of a boundary layer of thickness h, f_i = sum_p (V_p / h) t N_i (SAND2002-0482 eq 1-16).

    The particles of the layer are chosen at the start and carry the traction as they move (a force per initial
    area). The force acts at the particles' centres, below the surface, so the stress in the loaded cell is less than
    the traction: with linear functions at rest it is 1 - thickness / 2 (in cells) of it, so 1/2 for the default of one
    cell and 3/4 for half a cell (two particles per cell). Thinner layers reduce the error and `TwoPointTraction` cures it.

    ``traction`` is a vector, texts of formulas, or a scalar Python function of any of ``x``, ``X``, ``t``.
    """

    references = ("Chen and Brannon (2002), SAND2002-0482, eqs 1-5 and 1-16, section 2",)
    body: str = mpm.parameter("name of the loaded body", example="bar")
    traction: mpm.Value = mpm.parameter("force per area", unit="Pa", example=(1.0,))
    face: str | None = mpm.parameter("the body's face that is loaded", choices=FACES, default=None, example="xmax")
    region: Geometry | None = mpm.parameter("particles inside this shape, in place of a face; needs a thickness", default=None)
    thickness: float | None = mpm.parameter("thickness h of the layer; one cell if not given", unit="m", gt=0.0, default=None)
    load = layer_force

    def check(self):
        if (self.face is None) == (self.region is None):
            raise mpm.ParameterError("TractionLayer needs either a face or a region, for example face='xmax'")
        if self.region is not None and self.thickness is None:
            raise mpm.ParameterError("TractionLayer.thickness is required with a region: the force is V0 / thickness times the traction")

    def select(self, points, grid):
        import numpy as np

        if self.region is not None:
            chosen = np.flatnonzero(self.region.contains(points.x))
            if chosen.size == 0:
                raise mpm.CompositionError(f"TractionLayer: no particle of body {self.body!r} lies in the region")
            nothing = np.zeros((chosen.size, 3))
            return selection(chosen, points.V0[chosen] / self.thickness, nothing, nothing.copy())
        axis = "xyz".index(self.face[0])
        h = self.thickness if self.thickness is not None else (grid.spacing[axis] if axis < grid.dim else None)
        chosen, normals, arms = face_layer(points, self.face, h, "TractionLayer")
        return selection(chosen, points.V0[chosen] / h, normals, arms)
