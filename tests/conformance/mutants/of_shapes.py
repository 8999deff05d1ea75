"""Faulty shape functions."""

from mpmkit_shapes import Linear, QuadraticBSpline
from mpmkit_shapes.bsplines import quadratic_weights
from mpmkit_shapes.linear import tent_weights

import mpmkit as mpm
from mpmkit.math import cos, sin
from mutants import mutant

SCENES = ("linear field at every boundary", "momentum is conserved", "free flight")
PI = 3.141592653589793


@mpm.kernel
def large_weights(f):
    return (1.000001 * (1.0 - f), 1.000001 * f), (-1.0, 1.0)


@mutant("partition of unity", also=("linear fields are reproduced", *SCENES))
@mpm.define
class TooMuch(Linear):
    """A millionth too much mass, w = 1.000001 w."""

    weights = large_weights


@mpm.kernel
def steep_on_one_side(f):
    return (1.0 - f, f), (-1.0 + 1e-6, 1.0)


@mutant("slopes add up to zero", also=("mirror symmetric", *SCENES))
@mpm.define
class Leaning(Linear):
    """Slopes of -1 + 1e-6 and 1, w = f."""

    weights = steep_on_one_side


@mpm.kernel
def smooth_steps(f):
    s = f * f * (3.0 - 2.0 * f)
    d = 6.0 * f * (1.0 - f)
    return (1.0 - s, s), (-d, d)


@mutant("linear fields are reproduced", also=SCENES)
@mpm.define
class SmoothSteps(Linear):
    """Weights that are a step in each cell, w = f^2 (3 - 2 f)."""

    order = 0
    weights = smooth_steps


@mpm.kernel
def convolution(f):
    s = f - 1.0
    w0 = 0.5 * s * (-1.0 + s * (2.0 - s))
    w1 = 1.0 + s * s * (-2.5 + 1.5 * s)
    w2 = 0.5 * s * (1.0 + s * (4.0 - 3.0 * s))
    w3 = 0.5 * s * s * (s - 1.0)
    d0 = 0.5 * (-1.0 + s * (4.0 - 3.0 * s))
    d1 = s * (-5.0 + 4.5 * s)
    d2 = 0.5 * (1.0 + s * (8.0 - 9.0 * s))
    d3 = 0.5 * s * (3.0 * s - 2.0)
    return (w0, w1, w2, w3), (d0, d1, d2, d3)


class Convolution(mpm.ShapeFunction):
    """Cubic convolution, which interpolates and has negative weights."""

    references = ("R. Keys (1981), Cubic convolution interpolation, doi:10.1109/TASSP.1981.1163711",)
    nodes = 4
    offset = 1.0
    order = 2
    weights = convolution


@mutant("weights are not negative", also=("momentum is conserved", "free flight"))
@mpm.define
class Negative(Convolution):
    """Negative weights that are not declared, w = -s (s - 1)^2 / 2."""


@mutant("negative weights are there where declared")
@mpm.define
class Pessimist(QuadraticBSpline):
    """Declares negative weights and has none, w = w."""

    positive = False


@mpm.kernel
def bent_slopes(f):
    w, (d0, d1, d2) = quadratic_weights.function(f)
    g = 0.05 * sin(2.0 * PI * (f - 1.0))
    return w, (d0 + g, d1 - 2.0 * g, d2 + g)


@mutant("slopes are derivatives of the weights")
@mpm.define
class BentSlopes(QuadraticBSpline):
    """Slopes with a ripple that the weights have not, w = w."""

    weights = bent_slopes


@mpm.kernel
def jumping_weights(f):
    (a, b, c), d = quadratic_weights.function(f)
    return (a + 0.02, b - 0.04, c + 0.02), d


@mutant("continuous across cells")
@mpm.define
class Jumping(QuadraticBSpline):
    """Weights that jump where the first node changes, w = w + 0.02."""

    weights = jumping_weights


@mutant("slopes are continuous where claimed")
@mpm.define
class KinkedUndeclared(Linear):
    """Kinks that are not declared, w = f."""

    smooth = True


@mpm.kernel
def lopsided_weights(f):
    (a, b, c), (d0, d1, d2) = quadratic_weights.function(f)
    s = sin(2.0 * PI * (f - 1.0))
    e, g = 0.02 * s * s * s, 0.12 * PI * s * s * cos(2.0 * PI * (f - 1.0))
    return (a + e, b - 2.0 * e, c + e), (d0 + g, d1 - 2.0 * g, d2 + g)


@mutant("mirror symmetric")
@mpm.define
class LopsidedWeights(QuadraticBSpline):
    """Prefers a direction, w = w + sin^3."""

    order = 1
    weights = lopsided_weights


@mutant("declared order is reproduced")
@mpm.define
class QuadraticByName(Linear):
    """Claims more than it reproduces, w = f."""

    order = 2


@mutant("describes its support")
@mpm.define
class SizedByName(Linear):
    """Claims that particles have a size and never asks for it, w = f."""

    particle_size = "initial"


@mpm.kernel
def slopes_of_fine_grids(f, h):
    w, (a, b) = tent_weights.function(f)
    wrong = 1.000001 if 0.3 < h < 0.6 else 1.0
    return w, (wrong * a, wrong * b)


@mutant("linear field at every boundary")
@mpm.define
class WrongUnits(Linear):
    """Slopes that depend on the spacing, w = f."""

    weights = slopes_of_fine_grids


@mpm.kernel
def slopes_of_finer_grids(f, h):
    w, (a, b) = tent_weights.function(f)
    return w, (a, b + 1e-6 if h < 0.2 else b)


@mutant("momentum is conserved")
@mpm.define
class LosesMomentum(Linear):
    """Slopes that do not add up on fine grids, w = f."""

    weights = slopes_of_finer_grids


@mpm.kernel
def weights_of_coarse_grids(f, h):
    (a, b), d = tent_weights.function(f)
    return (0.999999 * a if 0.2 < h < 0.3 else a, b), d


@mutant("free flight")
@mpm.define
class LosesMass(Linear):
    """Loses mass on coarse grids, w = f."""

    weights = weights_of_coarse_grids
