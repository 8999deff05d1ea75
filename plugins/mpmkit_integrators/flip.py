"""Fluid implicit particle: the transfer of the original material point method."""

import mpmkit as mpm


@mpm.kernel
def blended_velocity(v, v_grid, dv_grid, blend):
    """v_p = blend (v_p + sum_i dv_i N_i) + (1 - blend) sum_i v_i N_i."""
    return blend * (v + dv_grid) + (1.0 - blend) * v_grid


@mpm.define
class FLIP(mpm.Transfer):
    """FLIP: the particle adds the interpolated change of the grid velocity, v_p += dt sum_i a_i N_i (SAND2002-0482 eqs 3-6, 3-8).

    With ``blend`` < 1 a part of the PIC velocity is mixed in. Keeps energy well; velocities that the grid cannot see
    (the null space of the map) ring on for ever with blend = 1.
    """

    references = (
        "Brackbill and Ruppel (1986), FLIP, J. Comput. Phys. 65, 314-343, doi:10.1016/0021-9991(86)90211-1",
        "Chen and Brannon (2002), SAND2002-0482, eqs 3-6 to 3-8",
    )
    blend: float = mpm.parameter("share of FLIP; the rest is PIC", ge=0.0, le=1.0, default=1.0, example=0.99)
    velocity = blended_velocity
