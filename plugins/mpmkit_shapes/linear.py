"""The tent function of the original material point method."""

import mpmkit as mpm


@mpm.kernel
def tent_weights(f):
    """(1 - f, f) and their slopes, for f in [0, 1]."""
    return (1.0 - f, f), (-1.0, 1.0)


@mpm.define
class Linear(mpm.ShapeFunction):
    r"""Piecewise linear ("tent") functions: a particle is a mass point in one cell.

    .. math:: S_i(x_p) = \max(0, 1 - |x_p - x_i| / h)

    Valid while particles stay in their cells. The slope jumps at a cell face, so a particle that crosses one changes
    the nodal force suddenly: errors do not fall, and may grow, with refinement once particles cross cells.
    """

    references = (
        "D. Sulsky, Z. Chen, H.L. Schreyer (1994), A particle method for history-dependent materials, doi:10.1016/0045-7825(94)90112-0",
        "J.E. Guilkey, An introduction to the material point method, Fig 2",
    )
    nodes = 2
    offset = 0.0
    order = 1
    smooth = False
    weights = tent_weights
