"""A bar stretched until its particles are cells apart."""

from __future__ import annotations

import numpy as np

from mpmkit.stability.case import Case, Composition, Figure
from mpmkit.stability.cases._stretched import CELLS, driven, stress
from mpmkit.stability.cases._tools import at_most, rounding, run

STRETCH, LOOKS = 3.0, 40
PULL = 4.0  # speed of the end over that of waves: see the failure mode
COURANT = 0.2  # of the source; exp(dt L) of a stretching bar is 1 + dt L only to first order


def pull(composition: Composition, particles: int) -> list[Figure]:
    """Stretch to three, or as far as the shape function says that its particles may grow; look at stresses on the way.

    A shape function that does not follow the particles' size is asked for its stresses until they are as far apart as it reaches, half
    its nodes; beyond, it must only stay finite.
    """
    shape = composition.shape
    grows = shape.particle_size == "current"
    farthest = min(STRETCH, 0.95 * 2.0 * particles * shape.max_half) if grows else STRETCH
    asked = farthest if grows else min(STRETCH, 0.5 * particles * shape.nodes)
    sim, V = driven(at_most(composition, COURANT), particles, farthest, PULL)
    error, reversal = 0.0, 0.0
    for stretch in np.linspace(1.0, farthest, LOOKS + 1)[1:]:
        now = run(sim, (stretch - 1.0) * CELLS / V).particles("bar")["stress"][:, 0]
        if stretch <= asked:
            error = max(error, float(np.abs(now / stress(float(stretch)) - 1.0).max()))
            reversal = max(reversal, float(-now.min() / stress(float(stretch))))
    told = f"{particles} in a cell, up to a stretch of {asked:.3g}"
    figures = [Figure(f"stress below zero / exact stress, {told}", reversal, rounding(composition, 1e-12))] if asked > 1.0 else []
    return [Figure(f"stress error, {told}", error, 0.02), *figures] if grows else figures


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """With one and with two particles in a cell."""
    return [figure for particles in (1, 2) for figure in pull(composition, particles)]


CASE = Case(
    name="numerical-fracture",
    title="A bar stretched to three times its length",
    failure="Particles that move apart by more than their shape functions reach share no node and lose each other: the bar breaks "
    "where no law of fracture is asked for. Tents and particles of constant size part at a stretch of one to two times the number of "
    "particles in a cell. Particles that follow the stretch stay side by side, but every grid that is renewed in each step has a "
    "tensile instability: a gap between two particles carries no stress, and the tension around it pulls it open. It grows from "
    "rounding and cell crossing at a rate of about 0.4 c / h at a stretch of 1.4, whatever the transfer and the time step, so that a "
    "bar pulled at 0.1 c breaks at a stretch of 1.4 (1 in a cell) or 1.8 (2 in a cell). Total-Lagrangian discretizations have "
    "neither.",
    criterion="Homogeneous stretch to 3 with 1 and 2 particles in a cell, the end at 4 wave speeds, before the instability has "
    "grown: largest stress error below 2 % for shape functions that follow the size of the particles (as far as they say that "
    "particles may grow); for all others no stress reversal until particles are as far apart as the function reaches, and no NaN to "
    "the end.",
    source="Steffen, Kirby and Berzins (2008), doi:10.1002/nme.2360; Sadeghirad, Brannon and Burghardt (2011), doi:10.1002/nme.3110",
    dim=1,
    measure=measure,
)
