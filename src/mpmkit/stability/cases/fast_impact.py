"""Two disks that meet at the speed of sound."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._disks import NU, RHO, WAVE, E
from mpmkit.stability.cases._tools import momentum_error, rounding, run

R, SPEED = 0.2, 0.5  # speed of each over the wave speed


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Until they have rebounded, off the centres by half a radius."""
    from mpmkit.materials import NeoHookean

    h = R / 6 if quick else R / 16
    rubber, v = NeoHookean(E=E, nu=NU, rho=RHO), SPEED * WAVE
    side = 36 if quick else 96
    sim = simulation(composition, mpm.Grid((0.0, 0.0), (side * h, side * h), h))
    middle = 0.5 * side * h
    for sign, name in ((-1.0, "left"), (1.0, "right")):
        sim += mpm.Body(mpm.Disk((middle + sign * 1.25 * R, middle + sign * 0.25 * R), R), rubber, v=(-sign * v, 0.0), name=name)
    if composition.contact is not None:
        sim += composition.contact
    least = np.inf
    for t in np.linspace(0.0, 3.0 * R / WAVE, 11)[1:]:
        least = min(least, float(run(sim, float(t)).particles()["J"].min()))
    history = sim.history
    made = history["balance"][history["step"] >= 20]
    return [
        Figure("energy made / largest energy", max(0.0, float(made.max())), 0.02),
        Figure("particles inverted (1: yes)", float(not least > 0.0), 0.0),
        Figure("change of the momentum", momentum_error(sim, v), rounding(composition, 1e-10)),
        Figure("change of the angular momentum", float(np.abs(history["angular_z"] / history["angular_z"][0] - 1.0).max()), 0.03),
    ]


CASE = Case(
    name="fast-impact",
    title="Two rubber disks meet at the speed of sound, off their centres",
    failure="Fronts of one particle, crushed to a fraction of their volume within a few steps; a step that is right before the impact "
    "inverts "
    "particles in it.",
    criterion="No particle inverted; energy made below 2 % of the largest; momentum to rounding, angular momentum within 3 %.",
    source="Conservation laws",
    dim=2,
    measure=measure,
    contact=True,
)
