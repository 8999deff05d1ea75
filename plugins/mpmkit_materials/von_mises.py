"""Metal plasticity: von Mises yield with linear isotropic hardening."""

import mpmkit as mpm
from mpmkit.errors import ParameterError
from mpmkit.math import fabs
from mpmkit.tensor import add, add_diagonal, dev, scale, trace, von_mises
from mpmkit_materials.isotropic import IsotropicElastic
from mpmkit_materials.rate_form import bar_rate_energy, bar_rate_wave_speed, elastic_increment, jaumann_step, rate_energy, rate_wave_speed


def radial_return(trial, eps_p, mu, yield_stress, hardening):
    """Bring a trial stress back to the yield surface along its deviator; exact for linear hardening."""
    q = von_mises(trial)
    step = max(q - yield_stress - hardening * eps_p, 0.0) / (3.0 * mu + hardening)
    kept = 1.0 - 3.0 * mu * step / max(q, yield_stress)  # q >= yield stress whenever step > 0
    return add_diagonal(scale(kept, dev(trial)), (1.0 / 3.0) * trace(trial)), eps_p + step


@mpm.kernel
def finite_stress(stress, L, dt, eps_p, lam, mu, yield_stress, hardening):
    """Trial stress by the Jaumann rate, then radial return."""
    return radial_return(jaumann_step(stress, L, dt, lam, mu), eps_p, mu, yield_stress, hardening)


@mpm.kernel
def small_stress(stress, L, dt, eps_p, lam, mu, yield_stress, hardening):
    """Trial stress sigma + dt C : D without rotation, then radial return."""
    return radial_return(add(stress, elastic_increment(L, dt, lam, mu)), eps_p, mu, yield_stress, hardening)


@mpm.kernel
def plastic_work(eps_p, yield_stress, hardening):
    """Y eps_p + H eps_p^2 / 2."""
    return (yield_stress + 0.5 * hardening * eps_p) * eps_p


@mpm.kernel
def yield_function(stress, eps_p, yield_stress, hardening):
    """sqrt(3/2 s : s) - Y - H eps_p."""
    return von_mises(stress) - yield_stress - hardening * eps_p


@mpm.kernel
def bar_stress(stress, L, dt, eps_p, E, yield_stress, hardening):
    """The return in uniaxial stress: elastic modulus E, tangent modulus E H / (E + H) when yielding."""
    trial = stress[0] + E * dt * L[0]
    step = max(fabs(trial) - yield_stress - hardening * eps_p, 0.0) / (E + hardening)
    kept = 1.0 - E * step / max(fabs(trial), yield_stress)
    return (kept * trial, 0.0, 0.0, 0.0, 0.0, 0.0), eps_p + step


KERNELS = {"finite": finite_stress, "small": small_stress}


@mpm.define
class VonMises(IsotropicElastic):
    r"""Elastic-plastic metal: isotropic elasticity, von Mises yield, linear isotropic hardening or perfect plasticity.

    .. math:: \sqrt{\tfrac32 s : s} \le Y + H \bar\varepsilon_p , \quad
              D_p = \dot{\bar\varepsilon}_p \, \frac{3 s}{2 \sqrt{\frac32 s : s}} , \quad H = \frac{E E_t}{E - E_t}

    with s the stress deviator and :math:`E_t` the slope of the uniaxial stress-strain curve after yield (0: perfectly plastic). The
    elastic part is in rate form with a radial return: ``strain="finite"`` uses the Jaumann rate of the Cauchy stress and is objective,
    ``strain="small"`` adds C : D dt without rotation, as in SAND2002-0482. The return is exact for linear hardening: a yielding point
    lies on the surface to rounding.

    Valid for small elastic strains (Y much less than E); plastic strain may be large. The law does not depend on rate, temperature or
    the sign of the load (no Bauschinger effect). Known to fail: ``strain="small"`` under rotation.

    All plastic work, :math:`Y \bar\varepsilon_p + H \bar\varepsilon_p^2 / 2` per initial volume, is counted as dissipated, the part
    that hardening stores in the lattice included. The wave speed is that of the elastic law (plastic waves are slower), bounded as in
    `HypoelasticJaumann`.
    """

    references = (
        "M.L. Wilkins (1964), Calculation of elastic-plastic flow, Methods in Computational Physics 3, 211-263",
        "J.C. Simo, T.J.R. Hughes (1998), Computational Inelasticity, box 3.2 and section 8.3, doi:10.1007/b98904",
        "SAND2002-0482, elastic-plastic bars, Figs 13-20",
    )
    state = (mpm.Field("eps_p", "1", "equivalent plastic strain, accumulated"),)
    expected_failures = {'objectivity[strain="small"]': "the small-strain form does not rotate the stress"}  # noqa: RUF012
    energy = rate_energy
    dissipation = plastic_work
    wave_speed = rate_wave_speed
    yield_function = yield_function
    bar_stress = bar_stress
    bar_energy = bar_rate_energy
    bar_dissipation = plastic_work
    bar_wave_speed = bar_rate_wave_speed

    yield_stress: float = mpm.parameter("uniaxial stress at first yield", unit="Pa", gt=0.0, example=2e4)
    tangent_modulus: float = mpm.parameter(
        "slope of the uniaxial curve after yield; 0 is perfectly plastic", unit="Pa", ge=0.0, default=0.0, example=2e6
    )
    strain: str = mpm.parameter("finite (objective) or small strain", choices=("finite", "small"), default="finite", example="small")

    def check(self):
        """The tangent modulus must be below Young's modulus."""
        if self.tangent_modulus >= self.E:
            raise ParameterError(
                f"{type(self).__name__}.tangent_modulus must be < E = {self.E:g} Pa, got {self.tangent_modulus:g} (slope of the "
                "uniaxial curve after yield); without yield use LinearElastic or HypoelasticJaumann"
            )

    @property
    def hardening(self):
        """Plastic modulus H [Pa]: slope of the yield stress over the plastic strain."""
        return self.E * self.tangent_modulus / (self.E - self.tangent_modulus)

    @property
    def stress(self):
        """Kernel of the stress for this measure of strain."""
        return KERNELS[self.strain]
