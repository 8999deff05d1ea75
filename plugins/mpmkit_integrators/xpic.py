"""Extended particle in cell of order m."""

import mpmkit as mpm


@mpm.kernel
def filtered_velocity(v_smooth, dv_grid):
    """v_p = sum_i (v*_i + dv_i) N_i."""
    return v_smooth + dv_grid


@mpm.kernel
def picard_velocity(v_grid):
    """XPIC(1) is PIC: v_p = sum_i v_i N_i."""
    return v_grid


@mpm.define
class XPIC(mpm.Transfer):
    """XPIC(m): filters only what the grid cannot see, V <- [I - (I - S S+)^m] V + dt S a.

    S interpolates from nodes to particles, S+ maps from particles to nodes. m = 1 is PIC, m -> infinity FLIP without
    its null space. The velocity v* = sum_r (-1)^(r+1) binom(m, r) (S+ S)^(r-1) v costs m - 1 further passes between
    particles and nodes in each step; boundary layers act on what comes out of each, so that a half with a plane of symmetry is
    filtered as the whole would be. High orders amplify rounding; m above about 10 gains nothing.
    """

    references = ("Hammerquist and Nairn (2017), A new method for material point method particle updates, doi:10.1016/j.cma.2017.01.035",)
    order: int = mpm.parameter("number of passes m", ge=1, le=20, default=2, example=3)

    @property
    def passes(self) -> int:
        return self.order

    @property
    def velocity(self) -> mpm.interfaces.integrator.Kernel:
        return filtered_velocity if self.order > 1 else picard_velocity
