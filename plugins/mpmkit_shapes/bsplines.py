"""Smooth shape functions: B-splines of degree two and three."""

import mpmkit as mpm


@mpm.kernel
def quadratic_weights(f):
    """Quadratic B-spline of three nodes, for f in [0.5, 1.5)."""
    a, b, c = 1.5 - f, f - 1.0, f - 0.5
    return (0.5 * a * a, 0.75 - b * b, 0.5 * c * c), (-a, -2.0 * b, c)


@mpm.kernel
def cubic_weights(f):
    """Cubic B-spline of four nodes, for f in [1, 2)."""
    u = f - 1.0
    w = 1.0 - u
    sixth, two_thirds = 1.0 / 6.0, 2.0 / 3.0
    weights = (sixth * w * w * w, two_thirds - u * u * (1.0 - 0.5 * u), two_thirds - w * w * (1.0 - 0.5 * w), sixth * u * u * u)
    slopes = (-0.5 * w * w, u * (1.5 * u - 2.0), w * (2.0 - 1.5 * w), 0.5 * u * u)
    return weights, slopes


@mpm.define
class QuadraticBSpline(mpm.ShapeFunction):
    r"""Quadratic B-splines: continuous slopes, three nodes in each direction.

    .. math:: S(r) = \tfrac34 - r^2 \;(|r| \le \tfrac12), \quad \tfrac12 (\tfrac32 - |r|)^2 \;(\tfrac12 < |r| \le \tfrac32)

    with r the distance in cells. Second order in space while the sampling by particles is fine enough. Known to
    fail: two bodies feel each other up to 1.5 cells before they touch unless a contact algorithm tells them apart.
    """

    references = (
        "M. Steffen, R.M. Kirby, M. Berzins (2008), Analysis and reduction of quadrature errors in the MPM, doi:10.1002/nme.2360",
    )
    nodes = 3
    offset = 0.5
    order = 2
    weights = quadratic_weights


@mpm.define
class CubicBSpline(mpm.ShapeFunction):
    r"""Cubic B-splines: continuous curvature, four nodes in each direction.

    .. math:: S(r) = \tfrac23 - r^2 + \tfrac12 |r|^3 \;(|r| \le 1), \quad \tfrac16 (2 - |r|)^3 \;(1 < |r| \le 2)

    with r the distance in cells. Smoother than the quadratic ones and wider: bodies feel each other up to two cells
    away, and a boundary needs two cells of material to be resolved.
    """

    references = (
        "M. Steffen, R.M. Kirby, M. Berzins (2008), Analysis and reduction of quadrature errors in the MPM, doi:10.1002/nme.2360",
    )
    nodes = 4
    offset = 1.0
    order = 3
    weights = cubic_weights
