"""Faulty effects."""

import itertools

from mpmkit_effects import ArtificialViscosity, Damping, Gravity
from mpmkit_effects.artificial_viscosity import shock_pressure
from mpmkit_effects.damping import drag

import mpmkit as mpm
from mpmkit.math import log
from mpmkit.testing import scenes
from mutants import mutant

SCENES = (
    "acts",
    "impulses are booked",
    "inner forces keep momentum",
    "dissipation never decreases",
    "a scene without it knows nothing of it",
)


@mutant("supplies a hook", also=("acts",))
@mpm.define
class Nothing(mpm.Effect):
    """Has no hook, a = 0."""

    references = ("none",)


@mpm.kernel
def late_failure(x, t):
    return (1.0 + 0.0 * log(0.9 - t), 0.0 * x[0], 0.0 * x[0])


@mutant("finite")
@mpm.define
class LateFailure(mpm.Effect):
    """No number after 0.9 s, b = 1."""

    references = ("none",)
    body_force = late_failure


@mpm.kernel
def always(L, rho, c, h):
    return -0.2 * rho * c * h * (L[0] + L[4] + L[8])


@mutant("viscous pressure only in compression")
@mpm.define
class PullingViscosity(mpm.Effect):
    """Viscous pressure in expansion too, q = -rho c h div v / 5."""

    references = ("none",)
    viscous_pressure = always


@mpm.kernel
def slow_signal(c):
    return 0.9 * c


@mutant("signal is not slower than the wave")
@mpm.define
class SlowSignal(ArtificialViscosity):
    """Lengthens the time step, c = 0.9 c."""

    signal_speed = slow_signal


@mpm.kernel
def leaning_drag(v, rate):
    a = drag.function(v, rate)
    return (a[0] + 1e-6, a[1], a[2])


@mutant("damping brakes")
@mpm.define
class LeaningDrag(Damping):
    """Pulls at what rests, a = -r v + 1e-6."""

    acceleration = leaning_drag


@mutant("rates are rates")
@mpm.define
class NoRate(Gravity):
    """A rate that is no number, a = g."""

    def rates(self):
        return {"gravity": float("nan")}


@mutant("rates keep damping stable")
@mpm.define
class Optimist(Damping):
    """Says a third of its rate, a = -r v."""

    def rates(self):
        return {"damping": self.rate / 3.0}


@mpm.kernel
def no_acceleration(v):
    return (0.0 * v[0], 0.0 * v[1], 0.0 * v[2])


@mutant("acts")
@mpm.define
class Idle(mpm.Effect):
    """Does nothing, a = 0."""

    references = ("none",)
    acceleration = no_acceleration


@mutant("a scene without it knows nothing of it")
@mpm.define
class Leak(Gravity):
    """Changes what the next scene is made of, a = g."""

    def rates(self):
        scenes.MACH *= 1.001
        return {}


@mpm.kernel
def endless_at_first(v, t):
    return (1e300 if t == 0.0 else 0.0, 0.0 * v[0], 0.0 * v[0])


@mutant("impulses are booked", also=SCENES)
@mpm.define
class EndlessAtFirst(mpm.Effect):
    """An acceleration without end in the first step, a = 1e300."""

    references = ("none",)
    acceleration = endless_at_first


@mpm.kernel
def endless_pressure(L, rho, c, h, dt, linear, quadratic):
    return shock_pressure.function(L, rho, c, h, linear, quadratic) * (1e280 if dt < 9e-4 else 1.0)


@mutant("inner forces keep momentum", also=SCENES)
@mpm.define
class EndlessPressure(ArtificialViscosity):
    """A pressure without end in short steps, q = 1e280 q."""

    viscous_pressure = endless_pressure


@mpm.kernel
def tail_wind(v):
    return (10.0 * v[0], 10.0 * v[1], 10.0 * v[2])


@mutant("dissipation never decreases")
@mpm.define
class TailWind(mpm.Effect):
    """Speeds bodies up and counts that as dissipated, b = 10 v."""

    references = ("none",)
    body_force = tail_wind
    work = "dissipated"


CALLS = itertools.count()


@mutant("same scene gives the same bits", "goes on from a checkpoint")
@mpm.define
class Moody(Damping):
    """A rate that is another one with each call, a = -r v."""

    def rates(self):
        return {"damping": 1e4 * (1.0 + next(CALLS) % 5)}
