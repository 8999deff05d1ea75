"""A block in free flight."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import momentum_error, rounding, run, wave_speed, with_material

H, SIDE, TRANSITS = 0.1, 0.4, 20
SPEEDS, DIRECTIONS = (0.01, 0.1, 1.0), (0.0, 30.0, 45.0)  # over the wave speed; degrees


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Fly in three directions at three speeds, in quick runs each speed in one direction."""
    from mpmkit.materials import NeoHookean

    material = with_material(composition, NeoHookean(E=1e4, nu=0.3, rho=1.0))
    c = wave_speed(material, mpm.Grid((0.0, 0.0), (1.0, 1.0), H), composition)
    modulus, until = material.rho * c * c, TRANSITS * SIDE / c
    choices = zip(SPEEDS, DIRECTIONS, strict=True) if quick else ((s, d) for s in SPEEDS for d in DIRECTIONS)
    kinetic = momentum = stress = 0.0
    for speed, degrees in choices:
        v = speed * c * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
        upper = np.ceil((SIDE + v * until) / H + 4.0) * H
        sim = simulation(composition, mpm.Grid((-4.0 * H, -4.0 * H), tuple(upper), H))
        sim += mpm.Body(mpm.Box((0.0, 0.0), (SIDE, SIDE)), material, v=tuple(v), name="block")
        history = run(sim, until).history
        kinetic = max(kinetic, float(np.abs(history["kinetic"] / history["kinetic"][0] - 1.0).max()))
        momentum = max(momentum, momentum_error(sim, speed * c))
        stress = max(stress, float(np.abs(sim.particles("block")["stress"]).max() / modulus))
    return [
        Figure("change of the kinetic energy", kinetic, rounding(composition, 1e-10)),
        Figure("change of the momentum", momentum, rounding(composition, 1e-10)),
        Figure("stress / modulus", stress, rounding(composition, 1e-9)),
    ]


CASE = Case(
    name="free-flight",
    title="A block of 8 x 8 particles flies freely for 20 wave transits",
    failure="At the trailing edge nodes are left with next to no mass. Their accelerations f / m, and with them the strains of the nearest "
    "particles, amplify rounding errors: stress last without a second mapping (USL with limit = 0) makes 10^4 to 10^9 times the "
    "kinetic energy before the block has met anything.",
    criterion="At 0.01, 0.1 and 1 times the wave speed, at 0, 30 and 45 degrees: kinetic energy and momentum constant to 1e-10, "
    "stress below 1e-9 of the P-wave modulus.",
    source="Newton's first law. Blow-up of USL: Bardenhagen (2002), doi:10.1006/jcph.2002.7103; Sulsky, Zhou and Schreyer (1995), "
    "doi:10.1016/0010-4655(94)00170-7",
    dim=2,
    measure=measure,
    material=True,
)
