"""Elasticity in rate form, with Jaumann's rate of the Cauchy stress."""

import mpmkit as mpm
from mpmkit_materials.isotropic import IsotropicElastic
from mpmkit_materials.rate_form import bar_rate_energy, bar_rate_wave_speed, jaumann_step, rate_energy, rate_wave_speed


@mpm.kernel
def hypoelastic_stress(stress, L, dt, lam, mu):
    """sigma + dt (W sigma - sigma W + C : D), second order in dt."""
    return jaumann_step(stress, L, dt, lam, mu)


@mpm.kernel
def bar_hypoelastic_stress(stress, L, dt, E):
    """sigma_xx + dt E D_xx."""
    return (stress[0] + E * dt * L[0], 0.0, 0.0, 0.0, 0.0, 0.0)


@mpm.define
class HypoelasticJaumann(IsotropicElastic):
    r"""Hypoelasticity: the Jaumann rate of the Cauchy stress is linear in the rate of deformation.

    .. math:: \dot\sigma = W \sigma - \sigma W + \lambda \, \mathrm{tr}(D) I + 2 \mu D , \quad
              D = \mathrm{sym}\, L , \; W = \mathrm{skew}\, L

    For small elastic strains with any rotation. Known to fail: in simple shear by g the stress oscillates,
    :math:`\sigma_{12} = \mu \sin g`, :math:`\sigma_{11} = \mu (1 - \cos g)`; a closed path of large strain leaves a stress behind, since no
    energy function exists. The stored energy J sigma : S : sigma / 2 is an estimate, right to first order in the strain.

    The wave speed is a bound: the acoustic tensor is :math:`(\lambda + \mu) n \otimes n + \mu I` and a part from the rotation of the
    stress whose symmetric part is :math:`\tfrac12 [(n \cdot \sigma n) I - \sigma]`, at most half the difference of two principal stresses.
    """

    references = (
        "C. Truesdell (1955), The simplest rate theory of pure elasticity, doi:10.1002/cpa.3160080109",
        "T.J.R. Hughes, J. Winget (1980), Finite rotation effects in numerical integration of rate equations, doi:10.1002/nme.1620151210",
        "J.K. Dienes (1979), On the analysis of rotation and stress rate in deforming bodies, simple shear, doi:10.1007/BF01379008",
    )
    stress = hypoelastic_stress
    energy = rate_energy
    wave_speed = rate_wave_speed
    bar_stress = bar_hypoelastic_stress
    bar_energy = bar_rate_energy
    bar_wave_speed = bar_rate_wave_speed
