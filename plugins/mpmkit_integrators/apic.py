"""Affine particle in cell."""

import mpmkit as mpm
from mpmkit_integrators.pic import interpolated_velocity


@mpm.define
class APIC(mpm.Transfer):
    """APIC: PIC with an affine velocity field around each particle, C = (sum_i v_i (x_i - x_p)^T N_i) D^-1.

    D = sum_i N_i (x_i - x_p)(x_i - x_p)^T is constant for B-splines away from the boundary, where angular momentum is
    therefore conserved to rounding. For linear and GIMP functions D varies and C is, or tends to, the velocity
    gradient. Where D vanishes (a particle on an interpolating node) the limit is taken, so C stays bounded; this is
    why C is stored and not B = C D.
    """

    references = (
        "Jiang, Schroeder, Selle, Teran and Stomakhin (2015), The affine particle-in-cell method, doi:10.1145/2766996",
        "Jiang, Schroeder and Teran (2017), An angular momentum conserving affine-particle-in-cell method, doi:10.1016/j.jcp.2017.02.050",
    )
    affine = "moment"
    angular_momentum = True
    velocity = interpolated_velocity
