"""Planes of symmetry."""

import mpmkit as mpm
from mpmkit_boundaries.faces import FACES, resolve


@mpm.kernel
def hold(v, normal):
    """No normal velocity: v - (v . n) n."""
    v_n = v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2]
    return (v[0] - v_n * normal[0], v[1] - v_n * normal[1], v[2] - v_n * normal[2])


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
