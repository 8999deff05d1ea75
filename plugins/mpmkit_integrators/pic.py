"""Particle in cell."""

import mpmkit as mpm


@mpm.kernel
def interpolated_velocity(v_grid):
    """v_p = sum_i v_i N_i(x_p)."""
    return v_grid


@mpm.define
class PIC(mpm.Transfer):
    """Particle in cell: the particle takes the interpolated velocity of the grid, v_p = sum_i v_i N_i(x_p).

    Very stable and very dissipative: every step filters the velocities once more, so angular momentum and kinetic
    energy are lost at a rate that grows with the number of steps.
    """

    references = ("Harlow (1964), The particle-in-cell computing method for fluid dynamics, Methods in Computational Physics 3, 319-343",)
    velocity = interpolated_velocity
