"""A soft bar that meets a stiff one, a hundred times harder in impedance and more."""

from __future__ import annotations

from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit.exact import Interface, impedance
from mpmkit.stability.case import Case, Composition, Figure
from mpmkit.stability.cases._tools import momentum_error, rounding, run
from mpmkit.stability.cases._tubes import MODULUS, RHO, WAVE, pair, rubber

STIFFNESS, DENSITY, SPEED, LENGTH = 1e4, 10.0, 1e-3, 0.5  # speed over the wave speed in the soft bar
EXACT = Interface(Z1=impedance(MODULUS, RHO), Z2=impedance(STIFFNESS * MODULUS, DENSITY * RHO))
ROUND_TRIP = 2.0 * LENGTH / (WAVE * np.sqrt(STIFFNESS / DENSITY))


def stress(age: Any) -> Any:
    """Stress [Pa] at the contact so long after the impact: less by the factor R whenever the wave in the stiff bar has come back."""
    return EXACT.impact_stress(SPEED * WAVE, 0.0) * EXACT.reflection ** np.floor(age / ROUND_TRIP)


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Stress in the soft bar when its wave has gone three quarters of the way; both bars after they have parted."""
    cells = 50 if quick else 100
    h, V = LENGTH / cells, SPEED * WAVE
    left = {"ends": (0.0, LENGTH), "material": rubber(), "v": V}
    right = {"ends": (LENGTH, 2.0 * LENGTH), "material": rubber(STIFFNESS, DENSITY), "v": 0.0}
    sim = pair(composition, mpm.Grid(-0.5 * LENGTH, 2.5 * LENGTH, h), left, right)
    t = 0.75 * LENGTH / WAVE
    worst = 0.0
    for when in np.linspace(0.0, t, 6)[1:]:
        worst = max(worst, penetration(run(sim, float(when)), h))
    soft = sim.particles("left")
    depth = LENGTH - (np.arange(2 * cells) + 0.5) * h / 2.0  # from the contact, in the bar before impact
    behind = (depth > 3.0 * h) & (depth < WAVE * t - 4.0 * h)
    error = np.mean(soft["stress"][behind, 0]) / np.mean(stress(t - depth[behind] / WAVE)) - 1.0
    trips = int(2.0 * LENGTH / WAVE / ROUND_TRIP)
    impulse = -float(stress((np.arange(trips) + 0.5) * ROUND_TRIP).sum() * ROUND_TRIP)
    impulse -= float(stress(np.array([(trips + 0.5) * ROUND_TRIP]))[0]) * (2.0 * LENGTH / WAVE - trips * ROUND_TRIP)
    run(sim, 3.0 * LENGTH / WAVE)
    stiff = sim.particles("right")
    return [
        Figure("stress in the soft bar / exact - 1", float(error), 0.05),
        Figure("momentum of the stiff bar / exact - 1", float((stiff["m"] * stiff["v"][:, 0]).sum() / impulse - 1.0), 0.05),
        Figure("penetration / cell", max(worst, penetration(sim, h)), 0.5),
        Figure("change of the momentum", momentum_error(sim, V), rounding(composition, 1e-10)),
    ]


def penetration(sim: mpm.Simulation, h: float) -> float:
    """How far the ends of the bars are inside each other, in cells; 0 if they are not."""
    soft, stiff = sim.particles("left"), sim.particles("right")
    end = soft["x"][-1, 0] + 0.25 * h * soft["J"][-1]
    return max(0.0, float(end - stiff["x"][0, 0] + 0.25 * h * stiff["J"][0]) / h)


CASE = Case(
    name="stiff-on-soft",
    title="A soft bar meets a bar of 10^4 times its stiffness and 10 times its density",
    failure="At the shared nodes the stiff body outweighs the soft one: the soft one is squeezed through it, sticks to it, or leaves "
    "with the wrong speed; penalty methods would need a spring that limits the time step.",
    criterion="Impact at a thousandth of the wave speed. Stress in the soft bar, and momentum that the stiff bar has got when both have "
    "parted, within 5 % of the exact ones; penetration below half a cell; momentum to rounding (1e-10).",
    source="Waves at an interface: Graff (1975), Wave Motion in Elastic Solids, chapter 2; a wave goes 16 times through the stiff bar and "
    "back while one goes through the soft bar, each time the contact stress falls by R = (Z2 - Z1) / (Z2 + Z1)",
    dim=1,
    measure=measure,
    contact=True,
)
