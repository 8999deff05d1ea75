"""Faulty constitutive models."""

import itertools
import threading

from mpmkit_materials import HypoelasticJaumann, LinearElastic, NeoHookean, NewtonianFluid, VonMises
from mpmkit_materials.linear_elastic import bar_hooke_energy, bar_hooke_stress, bar_hooke_wave_speed
from mpmkit_materials.neo_hookean import quadratic_energy, quadratic_stress, quadratic_wave_speed
from mpmkit_materials.newtonian_fluid import fluid_diffusivity
from mpmkit_materials.rate_form import rate_energy
from mpmkit_materials.von_mises import plastic_work

import mpmkit as mpm
from mpmkit.math import log, sin
from mpmkit.tensor import scale, von_mises
from mutants import EVERYTHING, mutant

WAVES = "wave speed bounds the acoustic tensor"


class Soft(mpm.ConstitutiveModel):
    """A neo-Hookean law that the faulty ones derive from, W = W(F)."""

    references = ("none",)
    stress = quadratic_stress
    energy = quadratic_energy
    wave_speed = quadratic_wave_speed
    lam = 2e6
    mu = 1e6


def rho():
    return mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1000.0)


# --- energy and dissipation ----------------------------------------------------------------------------------------
@mpm.kernel
def slightly_more_energy(F, lam, mu):
    return 1.01 * quadratic_energy.function(F, lam, mu)


@mutant("stress is the derivative of the energy")
@mpm.define
class MoreEnergy(Soft):
    """One per cent too much energy, W = 1.01 W(F)."""

    rho: float = rho()
    energy = slightly_more_energy


@mpm.kernel
def half_the_energy(stress, J, lam, mu):
    return 0.5 * rate_energy.function(stress, J, lam, mu)


@mutant("work is stored or dissipated")
@mpm.define
class LosesWork(HypoelasticJaumann):
    """Half of the work is nowhere, W = W / 2."""

    energy = half_the_energy


@mpm.kernel
def wobbling_work(eps_p, stress, yield_stress, hardening):
    return plastic_work.function(eps_p, yield_stress, hardening) + 1e-5 * von_mises(stress)


@mutant("dissipation never decreases")
@mpm.define
class GivesBack(VonMises):
    """A little of what was dissipated comes back, D = W_p + q / 1e5."""

    dissipation = wobbling_work


@mutant("bar dissipation never decreases")
@mpm.define
class BarGivesBack(VonMises):
    """The same for the bar, D = W_p + q / 1e5."""

    bar_dissipation = wobbling_work


@mpm.kernel
def narrow_surface(stress, eps_p, yield_stress, hardening):
    return von_mises(stress) - 0.99 * (yield_stress + hardening * eps_p)


@mutant("stays on or inside the yield surface")
@mpm.define
class Outside(VonMises):
    """Its stress is outside of the surface it declares, q <= Y."""

    yield_function = narrow_surface


# --- stress --------------------------------------------------------------------------------------------------------
@mpm.kernel
def stress_with_offset(F, lam, mu):
    xx, yy, zz, xy, yz, xz = quadratic_stress.function(F, lam, mu)
    return (xx + 1e-3, yy, zz, xy, yz, xz)


@mutant("stress-free at the start")
@mpm.define
class Prestressed(Soft):
    """A milli-Pascal at the start, W = W(F)."""

    rho: float = rho()
    stress = stress_with_offset


@mpm.kernel
def stress_of_five(F, lam, mu):
    return quadratic_stress.function(F, lam, mu)[:5]


@mutant("returns stress and state", also=EVERYTHING)
@mpm.define
class FiveComponents(Soft):
    """One component is missing, W = W(F)."""

    rho: float = rho()
    stress = stress_of_five


@mutant("objectivity")
@mpm.define
class SmallUndeclared(LinearElastic):
    """Hooke's law, sigma = C : eps, that does not say it is not objective."""

    expected_failures = {}  # noqa: RUF012


@mpm.kernel
def fragile_energy(F, J, lam, mu):
    return quadratic_energy.function(F, lam, mu) + 0.0 * log(2.7 - J)


@mutant("finite over the declared range", also=(WAVES,))
@mpm.define
class Fragile(Soft):
    """No number at the largest of the stretches it declares, W = W(F)."""

    rho: float = rho()
    energy = fragile_energy


@mpm.kernel
def refusing_speed(F, J, lam, mu, rho):
    if J <= 0.0:
        raise RuntimeError("cannot be")
    return quadratic_wave_speed.function(F, J, lam, mu, rho)


@mutant("inversion is refused")
@mpm.define
class Raises(Soft):
    """A kernel that raises in place of the guard, W = W(F)."""

    rho: float = rho()
    wave_speed = refusing_speed


# --- time step -----------------------------------------------------------------------------------------------------
@mpm.kernel
def half_speed(F, J, lam, mu, rho):
    return 0.5 * quadratic_wave_speed.function(F, J, lam, mu, rho)


@mutant(WAVES)
@mpm.define
class Slow(Soft):
    """The wave speed is too low, W = W(F)."""

    rho: float = rho()
    wave_speed = half_speed


@mpm.kernel
def threefold_speed(F, J, lam, mu, rho):
    return 3.0 * quadratic_wave_speed.function(F, J, lam, mu, rho)


@mutant(WAVES)
@mpm.define
class Fast(Soft):
    """The wave speed wastes time steps, W = W(F)."""

    rho: float = rho()
    wave_speed = threefold_speed


@mpm.kernel
def endless(J):
    return 1e300 * 1e300 * J


@mutant("diffusivity is finite and not negative", also=("inversion is refused", "results have the form of the hook"))
@mpm.define
class Endless(NewtonianFluid):
    """An infinite diffusivity, nu = 1 / 0."""

    diffusivity = endless


@mpm.kernel
def tenth_of_diffusivity(J, viscosity, rho):
    return 0.1 * fluid_diffusivity.function(J, viscosity, rho)


@mutant("diffusivity bounds the viscous stress")
@mpm.define
class Thin(NewtonianFluid):
    """A diffusivity that is too small for its stress, nu = nu / 10."""

    diffusivity = tenth_of_diffusivity


# --- bars ----------------------------------------------------------------------------------------------------------
@mpm.kernel
def double_bar_stress(F, E):
    return scale(2.0, bar_hooke_stress.function(F, E))


@mpm.kernel
def double_bar_energy(F, E):
    return 2.0 * bar_hooke_energy.function(F, E)


@mpm.kernel
def double_bar_speed(F, J, E, rho):
    return 2.0 * bar_hooke_wave_speed.function(F, J, E, rho)


@mutant("bar has Young's modulus of the law")
@mpm.define
class StiffBar(LinearElastic):
    """Twice as stiff as a bar, sigma = 2 E eps."""

    bar_stress = double_bar_stress
    bar_energy = double_bar_energy
    bar_wave_speed = double_bar_speed


@mutant("bar stores or dissipates the work")
@mpm.define
class StoringBar(LinearElastic):
    """Stores twice the work of a bar, W = E eps^2."""

    bar_energy = double_bar_energy


@mpm.kernel
def half_bar_speed(F, J, E, rho):
    return 0.5 * bar_hooke_wave_speed.function(F, J, E, rho)


@mutant("bar wave speed bounds the slope")
@mpm.define
class SlowBar(LinearElastic):
    """Half the wave speed of a bar, c = c / 2."""

    bar_wave_speed = half_bar_speed


@mpm.kernel
def fragile_bar_speed(F, J, E, rho):
    return bar_hooke_wave_speed.function(F, J, E, rho) + 0.0 * log(1.3 - F[0])


@mutant("bar is finite over the declared range")
@mpm.define
class FragileBar(LinearElastic):
    """No wave speed at the largest stretch of a bar, c = c + 0."""

    bar_wave_speed = fragile_bar_speed


# --- checks of all kinds, on constitutive models -------------------------------------------------------------------
@mutant("parameters are documented")
@mpm.define
class Undocumented(Soft):
    """Parameter without a meaning, and with a unit that is none, W = W(F)."""

    rho: float = mpm.parameter("", unit="kg/furlongs_", gt=0.0, example=1000.0)


@mutant("bad values are refused")
@mpm.define
class OpenRange(Soft):
    """Declares a range and then accepts what is outside, W = W(F)."""

    rho: float = rho()

    def __init__(self, rho):
        object.__setattr__(self, "rho", rho if isinstance(rho, float) else 1.0)


@mutant("repr rebuilds it")
@mpm.define
class Laconic(Soft):
    """Its repr says nothing, W = W(F)."""

    rho: float = rho()

    def __repr__(self):
        return "<a law>"


@mutant("pickles")
@mpm.define
class Heavier(Soft):
    """Twice as heavy after pickling, W = W(F)."""

    rho: float = rho()

    def __reduce__(self):
        return (type(self), (2.0 * self.rho,))


def thawed(cls):
    cls.__setattr__ = object.__setattr__
    return cls


@mutant("is frozen")
@thawed
@mpm.define
class Thawed(Soft):
    """Its parameters can be assigned, W = W(F)."""

    rho: float = rho()


@mutant("docstring has equation and reference")
@mpm.define
class WithoutReference(Soft):
    """No source, W = W(F)."""

    references = ()
    rho: float = rho()


@mpm.kernel
def counting_stress(F, kinetic, lam, mu):
    return quadratic_stress.function(F, lam, mu), kinetic


@mutant("declared facts are known words", "results come back from a record")
@mpm.define
class TakenName(Soft):
    """A state field with the name of a column of the history, W = W(F)."""

    rho: float = rho()
    state = (mpm.Field("kinetic", doc="nothing"),)
    stress = counting_stress


@mpm.kernel
def asks_for_what_is_not(F, lam, mu, nobody_knows):
    return quadratic_stress.function(F, lam, mu)


@mutant("kernel arguments resolve", also=EVERYTHING)
@mpm.define
class Misspelt(Soft):
    """A kernel asks for what is not there, W = W(F)."""

    rho: float = rho()
    stress = asks_for_what_is_not


CALLS = [0]


@mpm.kernel
def bookkeeping_stress(F, lam, mu):
    CALLS[0] = 1
    return quadratic_stress.function(F, lam, mu)


@mutant("kernels write nothing")
@mpm.define
class Bookkeeper(Soft):
    """Keeps books in a list of its module, W = W(F)."""

    rho: float = rho()
    stress = bookkeeping_stress


COUNTER = itertools.count()


@mpm.kernel
def aging_stress(F, lam, mu):
    return scale(1.0 + 1e-12 * next(COUNTER), quadratic_stress.function(F, lam, mu))


@mutant("same input gives the same bits")
@mpm.define
class Aging(Soft):
    """Stiffens with each call, W = W(F)."""

    rho: float = rho()
    stress = aging_stress


@mpm.kernel
def overflowing_speed(F, J, lam, mu, rho):
    n = 4611686018427387904  # 4 n is 2^64 in Python and 0 in 64 bits
    n = n * 4
    c = quadratic_wave_speed.function(F, J, lam, mu, rho)
    return c if n > 0 else 1.1 * c


@mutant("compiled equals plain Python")
@mpm.define
class Overflowing(Soft):
    """Whole numbers that compiled code cannot hold, W = W(F)."""

    rho: float = rho()
    wave_speed = overflowing_speed


@mpm.kernel
def whole_numbers(F, lam, mu):
    xx, yy, zz, xy, yz, xz = quadratic_stress.function(F, lam, mu)
    return (xx, yy, zz, xy, yz, xz / 3 * 3)


@mutant("single precision stays single")
@mpm.define
class DoublePrecision(Soft):
    """An integer constant makes double precision, W = W(F)."""

    rho: float = rho()
    stress = whole_numbers


@mpm.kernel
def rippled_speed(F, J, lam, mu, rho):
    return quadratic_wave_speed.function(F, J, lam, mu, rho) * (1.2 + 0.1 * sin(1e5 * J))


@mutant("single precision is close to double")
@mpm.define
class Rippled(Soft):
    """Ripples that single precision cannot resolve, W = W(F)."""

    rho: float = rho()
    wave_speed = rippled_speed


@mpm.kernel
def spatial_speed(F, J, dim, lam, mu, rho):
    return quadratic_wave_speed.function(F, J, lam, mu, rho) + 0.0 * log(dim - 1.5)


@mutant("runs in every declared space")
@mpm.define
class NotInOneDimension(Soft):
    """Declares all spaces and has no number in 1D, W = W(F)."""

    rho: float = rho()
    wave_speed = spatial_speed


@mpm.kernel
def stress_of_a_thread(F, lam, mu):
    here = 1.0 + 1e-7 if any(t.name.startswith("mpmkit-") for t in threading.enumerate()) else 1.0
    return scale(here, quadratic_stress.function(F, lam, mu))


@mutant("one thread equals two")
@mpm.define
class Threaded(Soft):
    """Knows whether there are threads, W = W(F)."""

    rho: float = rho()
    stress = stress_of_a_thread


@mutant("a scene file keeps it")
@mpm.define
class OnlyInScripts(Soft):
    """A parameter that no file can hold, W = W(F)."""

    rho: float = rho()
    note: object = mpm.parameter("anything", default=None, example=frozenset({1}))


# --- what is declared ----------------------------------------------------------------------------------------------
@mutant("examples construct")
@mpm.define
class BadExample(Soft):
    """The example is refused, W = W(F)."""

    rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=-1.0)


@mutant("objectivity")
@mpm.define
class DeclaredForNothing(NeoHookean):
    """An objective law, W = W(b), that says it is not."""

    expected_failures = {"objectivity": "said without reason"}  # noqa: RUF012


@mutant("known failures are checks")
@mpm.define
class UnknownFailure(NeoHookean):
    """Declares a failure of a check that does not exist, W = W(b)."""

    expected_failures = {"objectivety": "misspelt"}  # noqa: RUF012
