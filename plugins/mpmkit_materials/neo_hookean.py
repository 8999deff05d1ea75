"""Compressible neo-Hookean rubber, in two forms of the volumetric energy."""

import mpmkit as mpm
from mpmkit.math import log, sqrt
from mpmkit.tensor import add_diagonal, det, largest_eigenvalue_bound, left_cauchy_green, scale, trace
from mpmkit_materials.isotropic import IsotropicElastic


@mpm.kernel
def quadratic_stress(F, lam, mu):
    """sigma = [lam/2 (J^2 - 1) I + mu (b - I)] / J."""
    J = det(F)
    return scale(1.0 / J, add_diagonal(scale(mu, left_cauchy_green(F)), 0.5 * lam * (J * J - 1.0) - mu))


@mpm.kernel
def quadratic_energy(F, lam, mu):
    """W = lam/4 (J^2 - 1) - (lam/2 + mu) ln J + mu/2 (tr b - 3)."""
    J = det(F)
    return 0.25 * lam * (J * J - 1.0) - (0.5 * lam + mu) * log(J) + 0.5 * mu * (trace(left_cauchy_green(F)) - 3.0)


@mpm.kernel
def quadratic_wave_speed(F, J, lam, mu, rho):
    """rho0 c^2 = mu max(l^2) + max(0, mu + lam/2 (J^2 + 1)), l the stretches."""
    longitudinal = max(0.0, mu + 0.5 * lam * (J * J + 1.0))
    return sqrt((mu * largest_eigenvalue_bound(left_cauchy_green(F)) + longitudinal) / rho)


@mpm.kernel
def log_stress(F, lam, mu):
    """sigma = [lam ln J I + mu (b - I)] / J."""
    J = det(F)
    return scale(1.0 / J, add_diagonal(scale(mu, left_cauchy_green(F)), lam * log(J) - mu))


@mpm.kernel
def log_energy(F, lam, mu):
    """W = lam/2 (ln J)^2 - mu ln J + mu/2 (tr b - 3)."""
    log_J = log(det(F))
    return 0.5 * lam * log_J * log_J - mu * log_J + 0.5 * mu * (trace(left_cauchy_green(F)) - 3.0)


@mpm.kernel
def log_wave_speed(F, J, lam, mu, rho):
    """rho0 c^2 = mu max(l^2) + max(0, mu + lam (1 - ln J)), l the stretches."""
    longitudinal = max(0.0, mu + lam * (1.0 - log(J)))
    return sqrt((mu * largest_eigenvalue_bound(left_cauchy_green(F)) + longitudinal) / rho)


KERNELS = {
    "quadratic": {"stress": quadratic_stress, "energy": quadratic_energy, "wave_speed": quadratic_wave_speed},
    "log": {"stress": log_stress, "energy": log_energy, "wave_speed": log_wave_speed},
}


@mpm.define
class NeoHookean(IsotropicElastic):
    r"""Compressible neo-Hookean elasticity for large strains.

    .. math:: W = U(J) - \mu \ln J + \tfrac{\mu}{2} (\mathrm{tr}\, b - 3) , \quad
              \sigma = \frac1J \left[ J U'(J) \, I + \mu (b - I) \right] , \quad b = F F^T

    with :math:`U = \tfrac{\lambda}{4} (J^2 - 1) - \tfrac{\lambda}{2} \ln J` for ``form="quadratic"`` and
    :math:`U = \tfrac{\lambda}{2} (\ln J)^2` for ``form="log"``. The quadratic form is the energy of Guilkey's eq 11; the
    stress printed there as eq 12 is not its derivative (a bracket and a factor 1/J are misplaced, so that it is not zero
    at F = I) and is corrected here, as is the wave speed of eq 19: the acoustic tensor in a state of principal stretches l is

    .. math:: \rho_0 c^2 = \mu \max_a l_a^2 + \max(0, \mu + \lambda (J^2 + 1) / 2) , \quad
              \text{log: } \mu \max_a l_a^2 + \max(0, \mu + \lambda (1 - \ln J)) ,

    exact for the fastest direction; the wave speed takes a bound of the largest l^2, which is exact where the two smaller
    ones are equal. Known to fail: the log form softens without bound under expansion (J > e), and both
    resist compression to zero volume only like ln J.
    """

    references = (
        "J.E. Guilkey, An introduction to the material point method, appendix A, eq 11 (eqs 12 and 19 corrected)",
        "J.C. Simo, K.S. Pister (1984), Remarks on rate constitutive equations, doi:10.1016/0045-7825(84)90062-8",
        "J. Bonet, R.D. Wood (2008), Nonlinear Continuum Mechanics for FEA, 2nd ed., section 6.4.3, doi:10.1017/CBO9780511755446",
    )
    form: str = mpm.parameter(
        "volumetric energy: quadratic or logarithmic", choices=("quadratic", "log"), default="quadratic", example="log"
    )

    @property
    def stress(self):
        """Kernel of the Cauchy stress for this form."""
        return KERNELS[self.form]["stress"]

    @property
    def energy(self):
        """Kernel of the stored energy for this form."""
        return KERNELS[self.form]["energy"]

    @property
    def wave_speed(self):
        """Kernel of the wave speed for this form."""
        return KERNELS[self.form]["wave_speed"]
