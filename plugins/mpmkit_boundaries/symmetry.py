"""Planes of symmetry."""

import mpmkit as mpm
from mpmkit_boundaries.faces import FACES, resolve
from mpmkit_boundaries.wall import hold


@mpm.define
class Symmetry(mpm.BoundaryLayer):
    """A plane of symmetry on faces of the domain: v . n = 0 whatever the sign, tangential motion free (a roller).

    Needed on the axis (xmin) of an axisymmetric domain that begins at r = 0.
    """

    references = ("Chen and Brannon (2002), SAND2002-0482, section 2, essential boundary conditions",)
    faces: tuple[str, ...] = mpm.parameter("faces of the domain", choices=("all", *FACES), example="xmin")
    constrain = hold

    def faces_of(self, grid):
        return resolve(self.faces, grid, "Symmetry.faces")
