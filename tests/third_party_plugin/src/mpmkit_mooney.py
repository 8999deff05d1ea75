"""Compressible Mooney-Rivlin rubber for mpmkit."""

import mpmkit as mpm
from mpmkit.math import log, sqrt
from mpmkit.tensor import add, add_diagonal, ddot, det, largest_eigenvalue, left_cauchy_green, matmul, scale, trace, transpose


@mpm.kernel
def stress(F, c10, c01, bulk):
    """sigma = [2 c10 b + 2 c01 (I1 b - b b) + (K J (J - 1) - k) I] / J with k = 2 c10 + 4 c01."""
    J, b = det(F), left_cauchy_green(F)
    bb = left_cauchy_green(matmul(F, transpose(F)))
    shear = add(scale(2.0 * (c10 + c01 * trace(b)), b), scale(-2.0 * c01, bb))
    return scale(1.0 / J, add_diagonal(shear, bulk * J * (J - 1.0) - 2.0 * c10 - 4.0 * c01))


@mpm.kernel
def energy(F, c10, c01, bulk):
    """W = c10 (I1 - 3) + c01 (I2 - 3) - k ln J + K/2 (J - 1)^2."""
    J, b = det(F), left_cauchy_green(F)
    I2 = 0.5 * (trace(b) * trace(b) - ddot(b, b))
    return c10 * (trace(b) - 3.0) + c01 * (I2 - 3.0) - (2.0 * c10 + 4.0 * c01) * log(J) + 0.5 * bulk * (J - 1.0) * (J - 1.0)


@mpm.kernel
def wave_speed(F, J, c10, c01, bulk, rho):
    """Bound over all directions: rho0 c^2 = 2 c10 max(l^2) + 2 c01 I2 + k + K J^2, l the stretches."""
    b = left_cauchy_green(F)
    I2 = 0.5 * (trace(b) * trace(b) - ddot(b, b))
    return sqrt((2.0 * c10 * largest_eigenvalue(b) + 2.0 * c01 * I2 + 2.0 * c10 + 4.0 * c01 + bulk * J * J) / rho)


@mpm.define
class MooneyRivlin(mpm.ConstitutiveModel):
    r"""Compressible Mooney-Rivlin rubber.

    .. math:: W = c_{10} (I_1 - 3) + c_{01} (I_2 - 3) - (2 c_{10} + 4 c_{01}) \ln J + \tfrac K2 (J - 1)^2
    """

    references = ("P.G. Ciarlet (1988), Mathematical Elasticity I, section 4.10",)
    stress, energy, wave_speed = stress, energy, wave_speed
    c10: float = mpm.parameter("first constant", unit="Pa", gt=0.0, example=3e5)
    c01: float = mpm.parameter("second constant", unit="Pa", ge=0.0, example=1e5)
    bulk: float = mpm.parameter("volumetric stiffness K", unit="Pa", ge=0.0, example=5e6)
    rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1000.0)


@mpm.hookimpl
def mpmkit_components():
    return [MooneyRivlin]
