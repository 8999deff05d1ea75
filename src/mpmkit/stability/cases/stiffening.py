"""A rubber bar that becomes stiffer as it is stretched: the stable time step shrinks on the way."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.errors import StabilityError
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._stretched import CELLS, RHO, driven, modulus, rubber
from mpmkit.stability.cases._tools import at_most, fixed, run

STRETCH, FROZEN, PULL = 3.0, 0.9, 0.1
SNAPPED = 0.4  # time until all strain energy has become motion, in lengths of the stretched bar over c0
COURANT = 0.2  # of the source; the error of the energy is proportional to the time step


def released(composition: Composition, cells: int) -> tuple[float, float]:
    """Energy gained and lost, over that at the start, by a bar that is let go at a stretch of three, held at its left end."""
    from mpmkit.boundaries import Symmetry

    h, particles = 1.0 / cells, 2 * cells
    x = (np.arange(particles) + 0.5) * h / 2.0
    sim = simulation(at_most(composition, COURANT), mpm.Grid(0.0, 1.5, h))
    F = np.diag([STRETCH, 1.0, 1.0])
    sim += mpm.Body.from_arrays(x, h / 2.0 / STRETCH, rubber(), F=F, size=(h / 4.0 / STRETCH,), name="bar")
    sim += Symmetry("xmin")
    energy = run(sim, SNAPPED / np.sqrt(modulus() / RHO)).history["energy"]
    return max(0.0, float(energy.max() / energy[0] - 1.0)), max(0.0, float(1.0 - energy.min() / energy[0]))


def unnoticed(composition: Composition) -> float:
    """1 if a time step of 0.9 h / c0 goes through the stretching and the whole release unnoticed, else 0."""
    c0 = float(np.sqrt(modulus() / RHO))
    sim, V = driven(fixed(composition, FROZEN / c0), 6, STRETCH, PULL)
    try:
        run(sim, (STRETCH - 1.0) * CELLS / V)
    except StabilityError:
        return 0.0
    return 1.0


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Release with the composition's own step; stretch with a frozen one."""
    gained, lost = released(composition, 20 if quick else 80)
    return [
        Figure("energy gained", gained, 0.01),
        Figure("energy lost", lost, 0.01),
        Figure("frozen time step goes unnoticed (1: yes)", unnoticed(composition), 0.5),
    ]


CASE = Case(
    name="stiffening",
    title="Rubber stretched to J = 3 and let go",
    failure="In uniaxial strain the speed of waves grows to c0 sqrt((1 + J^2) / 2) = 2.236 c0. A time step from the speed at the "
    "start, or from current volume and mass with the moduli at rest, sqrt(J) c0 = 1.73 c0, is above the limit.",
    criterion="Let go at J = 3: energy within 1 % of its start value until all of it has become motion, with the automatic step at a "
    "Courant number of at most 0.2. Fixed step of 0.9 h / c0: refused, or reported, before the bar is stretched to J = 3.",
    source="Acoustic tensor of the neo-Hookean law; J.E. Guilkey, An introduction to the material point method, appendix A, eqs 11 and 19",
    dim=1,
    measure=measure,
)
