"""Two bodies that press on each other: as one body, in one velocity field, and with contact."""

from __future__ import annotations

import attrs
import numpy as np

import mpmkit as mpm
from mpmkit.exact import Interface, impedance
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import fixed, momentum_error, rounding, run, step
from mpmkit.stability.cases._tubes import MODULUS, RHO, WAVE, pair, rubber

SPEED, LENGTH = 1e-3, 0.5
Z = impedance(MODULUS, RHO)
EXACT = Interface(Z1=Z, Z2=Z).impact_stress(SPEED * WAVE, -SPEED * WAVE)


def pressed(composition: Composition, cells: int) -> mpm.Simulation:
    """Two bars that touch and run into each other, when their waves are at three quarters of their lengths."""
    h = LENGTH / cells
    left = {"ends": (-LENGTH, 0.0), "material": rubber(), "v": SPEED * WAVE}
    right = {"ends": (0.0, LENGTH), "material": rubber(), "v": -SPEED * WAVE}
    sim = pair(fixed(composition, step(composition, h, 1.01 * WAVE)), mpm.Grid(-2.0 * LENGTH, 2.0 * LENGTH, h), left, right)
    return run(sim, 0.75 * LENGTH / WAVE)


def plateau(sim: mpm.Simulation, cells: int) -> float:
    """Mean stress of the left bar between the contact and the front, over the exact one."""
    depth = LENGTH - (np.arange(2 * cells) + 0.5) * LENGTH / (2 * cells)
    h = LENGTH / cells
    behind = (depth > 3.0 * h) & (depth < 0.75 * LENGTH - 4.0 * h)
    return float(sim.particles("left")["stress"][behind, 0].mean() / EXACT)


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """The same impact three times."""
    cells = 100 if quick else 200
    h = LENGTH / cells
    shared = attrs.evolve(composition, contact=None)
    together = pressed(shared, cells)
    apart = pressed(composition, cells) if composition.contact is not None else together
    whole = simulation(fixed(shared, step(shared, h, 1.01 * WAVE)), mpm.Grid(-2.0 * LENGTH, 2.0 * LENGTH, h))
    whole += mpm.Body(mpm.Box(-LENGTH, LENGTH), rubber(), v=lambda x: -np.sign(x) * SPEED * WAVE, particles_per_cell=2, name="whole")
    uncut = run(whole, 0.75 * LENGTH / WAVE).particles("whole")
    cut = together.particles()
    return [
        Figure(
            "two bodies in one field, difference from one body",
            float(np.abs(cut["stress"] - uncut["stress"]).max() / -EXACT),
            rounding(composition, 1e-10),
        ),
        Figure("stress in one field / exact - 1", plateau(together, cells) - 1.0, 0.02),
        Figure("stress with contact / exact - 1", plateau(apart, cells) - 1.0, 0.02),
        Figure("change of the momentum", momentum_error(apart, SPEED * WAVE), rounding(composition, 1e-10)),
    ]


CASE = Case(
    name="one-field-or-contact",
    title="Two bars run into each other: in one velocity field, and with contact",
    failure="Contact that acts twice, or at a wrong distance, changes what it should leave alone: bodies that press on each other "
    "and do not slide are one body.",
    criterion="Two bars in one field are the uncut bar to rounding (1e-10); stress behind the front within 2 % of -Z v, in one field and "
    "with "
    "contact; momentum to rounding.",
    source="One-dimensional waves, Graff (1975), Wave Motion in Elastic Solids, chapter 2",
    dim=1,
    measure=measure,
    contact=True,
)
