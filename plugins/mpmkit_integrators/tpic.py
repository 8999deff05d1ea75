"""Taylor particle in cell."""

import mpmkit as mpm
from mpmkit_integrators.pic import interpolated_velocity


@mpm.define
class TPIC(mpm.Transfer):
    """TPIC: PIC with a first-order Taylor expansion around each particle, C = sum_i v_i grad N_i.

    Like APIC, with the velocity gradient in place of the first moment.
    """

    references = ("Nakamura, Matsumura and Mizutani (2023), Taylor particle-in-cell transfer, doi:10.1016/j.cma.2022.115720",)
    affine = "gradient"
    velocity = interpolated_velocity
