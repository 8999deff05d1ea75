"""A heavy and a light body in one velocity field."""

from __future__ import annotations

import attrs
import numpy as np

import mpmkit as mpm
from mpmkit.exact import Interface, impedance
from mpmkit.stability.case import Case, Composition, Figure
from mpmkit.stability.cases._tools import momentum_error, rounding, run
from mpmkit.stability.cases._tubes import MODULUS, RHO, WAVE, pair, rubber

RATIO, SPEED, LENGTH = 1000.0, 1e-3, 0.5
EXACT = Interface(Z1=impedance(MODULUS, RATIO * RHO), Z2=impedance(MODULUS, RHO))


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """The wave in the light bar at three quarters of its way."""
    cells = 50 if quick else 200
    h, V, t = LENGTH / cells, SPEED * WAVE, 0.75 * LENGTH / WAVE
    left = {"ends": (-LENGTH, 0.0), "material": rubber(1.0, RATIO), "v": V}
    right = {"ends": (0.0, LENGTH), "material": rubber(), "v": 0.0}
    sim = pair(attrs.evolve(composition, contact=None), mpm.Grid(-1.5 * LENGTH, 1.5 * LENGTH, h), left, right)
    light = run(sim, t).particles("right")
    depth = (np.arange(2 * cells) + 0.5) * h / 2.0
    behind = (depth > 3.0 * h) & (depth < WAVE * t - 4.0 * h)
    energy = sim.history["energy"]
    return [
        Figure("stress in the light bar / exact - 1", float(light["stress"][behind, 0].mean() / EXACT.impact_stress(V, 0.0) - 1.0), 0.05),
        Figure("its velocity / exact - 1", float(light["v"][behind, 0].mean() / EXACT.impact_velocity(V, 0.0) - 1.0), 0.05),
        Figure("energy gained", max(0.0, float(energy[-1] / energy[0] - 1.0)), 0.001),
        Figure("change of the momentum", momentum_error(sim, V), rounding(composition, 1e-10)),
    ]


CASE = Case(
    name="density-jump",
    title="A heavy bar pushes a bar of a thousandth of its density, in one velocity field",
    failure="Nodes between the bodies have the mass of the heavy one; what is measured in particle masses, such as a limit for light "
    "nodes, "
    "takes all nodes of the light body for nearly empty.",
    criterion="Stress and velocity in the light bar behind the front within 5 % of the exact ones; no energy gained (0.1 %); momentum to "
    "rounding.",
    source="Impact of two impedances, Graff (1975), Wave Motion in Elastic Solids, chapter 2",
    dim=1,
    measure=measure,
)
