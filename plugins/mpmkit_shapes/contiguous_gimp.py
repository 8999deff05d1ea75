"""GIMP with particles that stretch with the material along the axes."""

import mpmkit as mpm
from mpmkit_shapes.particle_average import centre, share_below


@mpm.kernel
def weights_reach_1(f, half):
    """Tent functions averaged over [f - half, f + half], for f in [1, 2) and half <= 1."""
    c1 = share_below(1.0, f, half)
    c2 = share_below(2.0, f, half)
    p0, p1, p2 = c1, c2 - c1, 1.0 - c2  # shares of the particle in the cells 0-1, 1-2, 2-3
    x0 = centre(0.0, c1, f, half)
    x1 = centre(c1, c2, f, half) - 1.0
    x2 = centre(c2, 1.0, f, half) - 2.0
    weights = (p0 * (1.0 - x0), p0 * x0 + p1 * (1.0 - x1), p1 * x1 + p2 * (1.0 - x2), p2 * x2)
    return weights, (-p0, p0 - p1, p1 - p2, p2)


@mpm.kernel
def weights_reach_2(f, half):
    """Tent functions averaged over [f - half, f + half], for f in [2, 3) and half <= 2."""
    c1 = share_below(1.0, f, half)
    c2 = share_below(2.0, f, half)
    c3 = share_below(3.0, f, half)
    c4 = share_below(4.0, f, half)
    p0, p1, p2, p3, p4 = c1, c2 - c1, c3 - c2, c4 - c3, 1.0 - c4
    x0 = centre(0.0, c1, f, half)
    x1 = centre(c1, c2, f, half) - 1.0
    x2 = centre(c2, c3, f, half) - 2.0
    x3 = centre(c3, c4, f, half) - 3.0
    x4 = centre(c4, 1.0, f, half) - 4.0
    weights = (
        p0 * (1.0 - x0),
        p0 * x0 + p1 * (1.0 - x1),
        p1 * x1 + p2 * (1.0 - x2),
        p2 * x2 + p3 * (1.0 - x3),
        p3 * x3 + p4 * (1.0 - x4),
        p4 * x4,
    )
    return weights, (-p0, p0 - p1, p1 - p2, p2 - p3, p3 - p4, p4)


KERNELS = {1: weights_reach_1, 2: weights_reach_2}


@mpm.define
class ContiguousGIMP(mpm.ShapeFunction):
    r"""Contiguous-particle GIMP: tent functions averaged over a particle that stretches and turns with the material.

    .. math:: S_{ip} = \frac{1}{2 l_a} \int_{x_p - l_a}^{x_p + l_a} \max(0, 1 - |x - x_i| / h) \, dx , \quad
        l_a = \Big( \sum_b (F_{ab} \, l_{0b})^2 \Big)^{1/2}

    The box stays along the axes (Wallstedt and Guilkey 2008), with the second moment that the deformed particle
    has along each of them. Stretch along the axes gives the published :math:`l_a = F_{aa} l_{0a}`, and keeps the particles of a body side
    by side, without gaps or overlap. The diagonal of F itself is no size of a body that turns: a quarter of a turn makes it zero.
    ``reach`` is the largest half size in cells: 1 allows a particle of half a cell to grow fourfold. Known to be inaccurate: large
    shear, and stretched bodies that lie across the axes, whose boxes overlap; use a B-spline there. Refused in axisymmetric scenes
    like GIMP.
    """

    references = (
        "S.G. Bardenhagen, E.M. Kober (2004), The generalized interpolation material point method, doi:10.3970/cmes.2004.005.477",
        "P.C. Wallstedt, J.E. Guilkey (2008), Explicit time integration schemes for use with GIMP, doi:10.1016/j.jcp.2008.07.019",
        "J.A. Nairn, J.E. Guilkey (2015), Axisymmetric form of the generalized interpolation material point method, doi:10.1002/nme.4792",
    )
    spaces = ("1D", "plane strain", "3D")
    order = 1
    particle_size = "current"
    reach: int = mpm.parameter("largest half size of a particle in cells", choices=(1, 2), default=1, example=1)

    @property
    def nodes(self):
        """Nodes in one direction."""
        return 2 * self.reach + 2

    @property
    def offset(self):
        """Distance from the first node to the start of the middle cell."""
        return float(self.reach)

    @property
    def max_half(self):
        """Largest half size of a particle [cells]."""
        return float(self.reach)

    @property
    def weights(self):
        """The kernel for this reach; a kernel returns tuples of fixed length, so there is one for each."""
        return KERNELS[self.reach]
