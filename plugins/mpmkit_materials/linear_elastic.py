"""Hooke's law in small strain."""

import mpmkit as mpm
from mpmkit.math import sqrt
from mpmkit.tensor import add_diagonal, ddot, largest_eigenvalue_bound, left_cauchy_green, scale, sym, trace
from mpmkit_materials.isotropic import IsotropicElastic


def small_strain(F):
    """Small strain sym(F - I), six components."""
    return add_diagonal(sym(F), -1.0)


@mpm.kernel
def hooke_stress(F, lam, mu):
    """sigma = lam tr(eps) I + 2 mu eps."""
    eps = small_strain(F)
    return add_diagonal(scale(2.0 * mu, eps), lam * trace(eps))


@mpm.kernel
def hooke_energy(F, lam, mu):
    """W = lam/2 tr(eps)^2 + mu eps : eps."""
    eps = small_strain(F)
    return 0.5 * lam * trace(eps) * trace(eps) + mu * ddot(eps, eps)


@mpm.kernel
def hooke_wave_speed(F, J, lam, mu, rho):
    """Bound over all directions: rho0 c^2 / J = (lam + 2 mu) l, l the largest stretch."""
    stretch = sqrt(largest_eigenvalue_bound(left_cauchy_green(F)))
    return sqrt((max(lam, 0.0) + 2.0 * mu) * stretch * J / rho)


@mpm.kernel
def bar_hooke_stress(F, E):
    """sigma_xx = E (F_xx - 1)."""
    return (E * (F[0] - 1.0), 0.0, 0.0, 0.0, 0.0, 0.0)


@mpm.kernel
def bar_hooke_energy(F, E):
    """W = E/2 (F_xx - 1)^2."""
    return 0.5 * E * (F[0] - 1.0) * (F[0] - 1.0)


@mpm.kernel
def bar_hooke_wave_speed(F, J, E, rho):
    """c^2 = E F_xx J / rho0."""
    return sqrt(E * F[0] * J / rho)


@mpm.define
class LinearElastic(IsotropicElastic):
    r"""Hooke's law for small strains: the stress is linear in the displacement gradient.

    .. math:: \sigma = \lambda \, \mathrm{tr}(\varepsilon) I + 2 \mu \varepsilon , \quad \varepsilon = \tfrac12 (F + F^T) - I

    For strains and rotations up to about 1e-2. Known to fail: under a large rotation it sees strain where there is
    none (it is not objective), and the stored energy matches the work of the Cauchy stress only to first order in
    the strain.

    The wave speed is a bound: a plane wave with normal n in the state F has the acoustic tensor
    :math:`\lambda n \otimes m + \mu (m \cdot n \, I + m \otimes n)`, :math:`m = F^T n`, whose eigenvalues are at most
    :math:`(\lambda + 2 \mu) |m|` (2 mu |m| if lambda < 0); it is attained along the axis of the largest stretch if F is symmetric.
    """

    references = (
        "S.P. Timoshenko, J.N. Goodier (1970), Theory of Elasticity, 3rd ed., section 6",
        "SAND2002-0482, elastic bars, Figs 1-12",
    )
    finite_strain = False
    expected_failures = {"objectivity": "a small-strain measure is not objective under large rotation"}  # noqa: RUF012
    stress = hooke_stress
    energy = hooke_energy
    wave_speed = hooke_wave_speed
    bar_stress = bar_hooke_stress
    bar_energy = bar_hooke_energy
    bar_wave_speed = bar_hooke_wave_speed
