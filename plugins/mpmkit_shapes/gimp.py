"""GIMP with particles that keep their initial size."""

import mpmkit as mpm
from mpmkit_shapes.particle_average import share_below


@mpm.kernel
def gimp_weights(f, half):
    """Tent functions averaged over [f - half, f + half], for f in [0.5, 1.5) and half <= 0.5."""
    left = share_below(1.0, f, half)  # share of the particle in the first of the two cells
    right = 1.0 - left
    x_left = f + half * (left - 1.0)  # centre of that share, from its cell's left node
    x_right = f + half * left - 1.0
    weights = (left * (1.0 - x_left), left * x_left + right * (1.0 - x_right), right * x_right)
    return weights, (-left, left - right, right)


@mpm.define
class GIMP(mpm.ShapeFunction):
    r"""Uniform GIMP: tent functions averaged over a particle of constant size (undeformed, axis-aligned box).

    .. math:: S_{ip} = \frac{1}{2 l} \int_{x_p - l}^{x_p + l} \max(0, 1 - |x - x_i| / h) \, dx , \quad l \le h / 2

    Written as shares of the particle in the cells it covers, which stays accurate for any small half size l. The
    slope is continuous, so crossing a cell is smooth. Known to fail: a body stretched until gaps open between its
    particles' boxes (numerical fracture), and overlapping boxes under strong compression; see ContiguousGIMP.
    Averaging over an area is not right for rings, so axisymmetric scenes are refused (Nairn & Guilkey 2015).
    """

    references = (
        "S.G. Bardenhagen, E.M. Kober (2004), The generalized interpolation material point method, doi:10.3970/cmes.2004.005.477",
        "J.A. Nairn, J.E. Guilkey (2015), Axisymmetric form of the generalized interpolation material point method, doi:10.1002/nme.4792",
    )
    spaces = ("1D", "plane strain", "3D")
    nodes = 3
    offset = 0.5
    order = 1
    particle_size = "initial"
    max_half = 0.5
    weights = gimp_weights
