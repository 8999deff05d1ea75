"""Bodies that fly out of the domain: through an open side, and through the corner."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit.errors import StabilityError
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import momentum_error, rounding, run, wave_speed, with_material

H, SIDE, GAP, SPEED = 0.1, 0.4, 0.55, 0.5  # speed over the wave speed


def thrown(composition: Composition, material: Any, direction: tuple[float, float]) -> tuple[mpm.Simulation, float]:
    """A block on its way to the upper corner of the domain, or to a side of it; and the wave speed."""
    c = wave_speed(material, mpm.Grid((0.0, 0.0), (1.0, 1.0), H), composition)
    v = SPEED * c * np.array(direction)
    lower = -10.0 * H * (1.0 - np.array(direction))
    upper = SIDE + GAP - 0.05 + 10.0 * H * (1.0 - np.array(direction))
    sim = simulation(composition, mpm.Grid(tuple(lower), tuple(upper), H))
    sim += mpm.Body(mpm.Box((0.0, 0.0), (SIDE, SIDE)), material, v=tuple(v), name="block")
    return sim, c


def stopped(composition: Composition, direction: tuple[float, float]) -> list[Figure]:
    """Fly out; read the message, and look at the state that was kept."""
    from mpmkit.materials import NeoHookean

    material = with_material(composition, NeoHookean(E=1e4, nu=0.3, rho=1.0))
    sim, c = thrown(composition, material, direction)
    first = (GAP - 0.05 + 0.25 * H) / (SPEED * c)  # when the foremost particle's centre is on the face
    message = ""
    try:
        run(sim, 4.0 * first)
    except StabilityError as error:
        message = str(error)
    named = re.search(r"particle \d+ of body 'block' .*it left the domain: x = \(.*t = (\S+) s", message)
    dt = composition.integrator.cfl * H / (c * (1.0 + SPEED))
    late = (float(named.group(1)) - first) / dt if named else np.inf
    block = sim.particles("block")
    fields = ("x", "v", "stress", "F")
    wrong = sum(int((~np.isfinite(block[f])).sum()) for f in fields) + int((block["x"] > np.array(sim.grid.upper)).any())
    return [
        Figure("steps until it is named", late, 2.0),
        Figure("numbers in the kept state that are not finite, or outside", wrong, 0.0),
        Figure("change of the momentum before", momentum_error(sim, SPEED * c), rounding(composition, 1e-10)),
        Figure("stress / modulus before", float(np.abs(block["stress"]).max() / (material.rho * c * c)), rounding(composition, 1e-9)),
    ]


def side(composition: Composition, quick: bool) -> list[Figure]:
    """Through the upper side in x."""
    return stopped(composition, (1.0, 0.0))


def corner(composition: Composition, quick: bool) -> list[Figure]:
    """Through the upper corner: out of both sides in the same step."""
    return stopped(composition, (1.0, 1.0))


FAILURE = (
    "Nodes around a particle outside do not exist: without a check, arrays are written out of bounds, or the particle comes in again "
    "from the other side."
)
CRITERION = (
    "The run stops at most 2 steps after the first particle's centre has passed the face, and the message names body, particle, place "
    "and time; what is kept is finite, inside, with its momentum (1e-10) and no stress (1e-9)."
)
SOURCE = "What is documented: a particle that leaves stops the run; the last good state is kept."
CASES = (
    Case(
        name="shot-out",
        title="A block is shot out through an open side",
        failure=FAILURE,
        criterion=CRITERION,
        source=SOURCE,
        dim=2,
        measure=side,
        material=True,
    ),
    Case(
        name="corner-shot",
        title="A block is thrown out at the corner of the grid",
        failure=FAILURE + " At a corner both happen at once.",
        criterion=CRITERION,
        source=SOURCE,
        dim=2,
        measure=corner,
        material=True,
    ),
)
