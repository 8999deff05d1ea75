"""Weakly compressible viscous fluid."""

import mpmkit as mpm
from mpmkit.math import pow, sqrt
from mpmkit.tensor import add_diagonal, ddot, dev, scale, sym


@mpm.kernel
def fluid_stress(J, L, dt, viscous_loss, bulk_modulus, viscosity, gamma):
    """sigma = -p I + 2 mu dev(D), and the energy lost to viscosity so far."""
    p = bulk_modulus / gamma * (pow(J, -gamma) - 1.0)
    D = dev(sym(L))
    return add_diagonal(scale(2.0 * viscosity, D), -p), viscous_loss + 2.0 * viscosity * ddot(D, D) * J * dt


@mpm.kernel
def fluid_energy(J, bulk_modulus, gamma):
    """W = K / gamma [(J^(1 - gamma) - 1) / (gamma - 1) + J - 1], the integral of -p dJ."""
    return bulk_modulus / gamma * ((pow(J, 1.0 - gamma) - 1.0) / (gamma - 1.0) + J - 1.0)


@mpm.kernel
def fluid_dissipation(viscous_loss):
    """The state itself."""
    return viscous_loss


@mpm.kernel
def fluid_wave_speed(J, bulk_modulus, gamma, rho):
    """c^2 = dp / d(rho) = K J^(1 - gamma) / rho0."""
    return sqrt(bulk_modulus * pow(J, 1.0 - gamma) / rho)


@mpm.kernel
def fluid_diffusivity(J, viscosity, rho):
    """4/3 of the kinematic viscosity: the fastest decay is that of longitudinal motion."""
    return (4.0 / 3.0) * viscosity * J / rho


@mpm.define
class NewtonianFluid(mpm.ConstitutiveModel):
    r"""Weakly compressible Newtonian fluid: Murnaghan's (Tait's) pressure and a constant viscosity.

    .. math:: \sigma = -p I + 2 \mu \, \mathrm{dev}\, D , \quad p = \frac{K}{\gamma} ( J^{-\gamma} - 1 ) , \quad J = \rho_0 / \rho

    The flow is nearly incompressible when the speed of sound :math:`\sqrt{K / \rho_0}` is at least ten times the fastest flow (density then
    varies by about 1 %). There is no bulk viscosity and no cut-off: the fluid takes tension down to -K / gamma. Known to fail: J is
    integrated in time, so that it drifts where particles mix for long (uneven density); no cavitation, no free-surface correction.
    """

    references = (
        "F.D. Murnaghan (1944), The compressibility of media under extreme pressures, doi:10.1073/pnas.30.9.244",
        "J.J. Monaghan (1994), Simulating free surface flows with SPH, doi:10.1006/jcph.1994.1034",
    )
    state = (mpm.Field("viscous_loss", "J/m^3", "energy lost to viscosity, per initial volume"),)
    stress = fluid_stress
    energy = fluid_energy
    dissipation = fluid_dissipation
    wave_speed = fluid_wave_speed
    diffusivity = fluid_diffusivity

    rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1000.0)
    bulk_modulus: float = mpm.parameter("bulk modulus at the reference density", unit="Pa", gt=0.0, example=2e6)
    viscosity: float = mpm.parameter("dynamic viscosity", unit="Pa*s", ge=0.0, example=1e-3)
    gamma: float = mpm.parameter("exponent of the pressure law", gt=1.0, default=7.0, example=7.0)
