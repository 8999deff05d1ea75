"""One particle in a cell beside nine."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.exact import Interface, impedance
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import momentum_error, rounding, run
from mpmkit.stability.cases._tubes import MODULUS, RHO, WAVE, rubber

SPEED, LENGTH = 1e-3, 0.5
SIDES = {"one": 1, "nine": 9}
Z = impedance(MODULUS, RHO)
EXACT = Interface(Z1=Z, Z2=Z).impact_stress(SPEED * WAVE, 0.0)


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Waves on both sides of the place where the numbers of particles change, at three quarters of their ways."""
    cells = 100 if quick else 400
    h, t = LENGTH / cells, 0.75 * LENGTH / WAVE
    sim = simulation(composition, mpm.Grid(-1.5 * LENGTH, 1.5 * LENGTH, h))
    sim += mpm.Body(mpm.Box(-LENGTH, 0.0), rubber(), v=SPEED * WAVE, particles_per_cell=1, name="one")
    sim += mpm.Body(mpm.Box(0.0, LENGTH), rubber(), particles_per_cell=9, name="nine")
    start = {name: np.abs(sim.particles(name)["x"][:, 0]) for name in SIDES}
    run(sim, t)
    figures = []
    for name in SIDES:
        behind = (start[name] > 3.0 * h) & (start[name] < WAVE * t - 4.0 * h)
        stress = sim.particles(name)["stress"][behind, 0] / EXACT
        figures.append(Figure(f"stress with {name} in a cell / exact - 1", float(stress.mean() - 1.0), 0.02))
    energy = sim.history["energy"]
    return [
        *figures,
        Figure("energy gained", max(0.0, float(energy[-1] / energy[0] - 1.0)), 0.005),
        Figure("change of the momentum", momentum_error(sim, SPEED * WAVE), rounding(composition, 1e-10)),
    ]


CASE = Case(
    name="uneven-particles",
    title="A bar with one particle in a cell pushes a bar with nine",
    failure="Particles of a ninth of the mass beside whole ones: rules that know one particle mass or size are wrong on one side, and the "
    "seam reflects waves that should not notice it.",
    criterion="Stress behind both fronts within 2 % of Z v / 2; no energy gained (0.5 %); momentum to rounding.",
    source="The bodies are of one material: there is no interface",
    dim=1,
    measure=measure,
)
