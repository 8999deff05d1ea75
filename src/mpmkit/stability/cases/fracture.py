"""A bar stretched until its particles are cells apart."""

from __future__ import annotations

import numpy as np

from mpmkit.stability.case import Case, Composition, Figure
from mpmkit.stability.cases._stretched import CELLS, driven, stress
from mpmkit.stability.cases._tools import rounding, run

STRETCH, LOOKS = 3.0, 40


def pull(composition: Composition, particles: int) -> list[Figure]:
    """Stretch to three, or as far as the shape function says that its particles may grow; look at stresses on the way."""
    shape = composition.shape
    grows = shape.particle_size == "current"
    farthest = min(STRETCH, 0.999 * 2.0 * particles * shape.max_half) if grows else STRETCH
    sim, V = driven(composition, particles, farthest)
    error, reversal = 0.0, 0.0
    for stretch in np.linspace(1.0, farthest, LOOKS + 1)[1:]:
        now = run(sim, (stretch - 1.0) * CELLS / V).particles("bar")["stress"][:, 0]
        exact = stress(float(stretch))
        error = max(error, float(np.abs(now / exact - 1.0).max()))
        reversal = max(reversal, float(-now.min() / stress(farthest)))
    told = f"{particles} in a cell, up to a stretch of {farthest:.3g}"
    figures = [Figure(f"stress below zero / largest stress, {told}", max(reversal, 0.0), rounding(composition, 1e-12))]
    return [Figure(f"stress error, {told}", error, 0.02), *figures] if grows else figures


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """With one and with two particles in a cell."""
    return [figure for particles in (1, 2) for figure in pull(composition, particles)]


CASE = Case(
    name="numerical-fracture",
    title="A bar stretched to three times its length",
    failure="Particles that move apart by more than their shape functions reach share no node and lose each other: the bar breaks "
    "where no law of fracture is asked for. Tents and particles of constant size part at a stretch of one to two times the number "
    "of particles in a cell.",
    criterion="Homogeneous stretch to 3 with 1 and 2 particles in a cell, at a tenth of the wave speed: largest stress error below 2 % for "
    "shape functions that follow the size of the particles (as far as they say that particles may grow); for all others no NaN and "
    "no stress reversal.",
    source="Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360; Sadeghirad, Brannon and Burghardt (2011), doi:10.1002/nme.3110",
    dim=1,
    measure=measure,
)
