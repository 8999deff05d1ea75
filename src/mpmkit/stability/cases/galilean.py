"""The same impact seen from a moving grid, and with the grid elsewhere."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure
from mpmkit.stability.cases._disks import CENTRAL, SPEED, WAVE, R, disks, internal_energy
from mpmkit.stability.cases._tools import momentum_error, rounding, run

UNTIL, CELLS_PER_SECOND, OFFSET, WHOLE = 3.5, np.array([10.0, -7.0]), 0.37, np.array([9.0, -5.0])


def smoothly(composition: Composition, quick: bool) -> list[Figure]:
    """In one velocity field: what is left is what shape functions and transfers do when particles cross cells."""
    return compared(composition, quick, lambda h: 0.005 if composition.shape.smooth else 0.03)


def layer(h: float) -> float:
    """Share of the energy that half a layer of cells has at the place of contact.

    Contact begins at nodes: bodies that close on each other at a node leave it with one velocity, which takes the energy of the relative
    motion from a layer of about a cell. Where the grid lies decides when, so this layer is known to half a cell. The disks are flattened
    by R v / c, the strain that a wave of this speed makes, over a half-width of R sqrt(2 v / c).
    """
    return float(R * np.sqrt(2.0 * SPEED / WAVE) * h / (np.pi * R * R))


def touching(composition: Composition, quick: bool) -> list[Figure]:
    """With the contact of the composition."""
    return compared(composition, quick, layer)


def compared(composition: Composition, quick: bool, largest: Callable[[float], float]) -> list[Figure]:
    """One run as it is, one with the grid offset by 0.37 h, one in flight, one whole cells away; twice as fine in full."""
    h = 1 / 20 if quick else 1 / 40
    flight = 0.05 * CELLS_PER_SECOND  # of cells of 1/20, in the fine grid too
    grid = mpm.Grid((-0.5, -2.0), (3.5, 1.5), h)
    fastest = SPEED + float(np.linalg.norm(flight))
    loss, error, ends = {}, 0.0, {}
    for name, offset, drift in (
        ("still", np.zeros(2), np.zeros(2)),
        ("offset", np.full(2, OFFSET * h), np.zeros(2)),
        ("flying", np.zeros(2), flight),
        ("whole", WHOLE * h, np.zeros(2)),
    ):
        sim = disks(composition, grid, h, CENTRAL, fastest=fastest, place=lambda x, o=offset: x + o, turn=lambda v, d=drift: v + d)
        loss[name] = 1.0 - internal_energy(run(sim, UNTIL))[-1]
        error = max(error, momentum_error(sim, SPEED + float(np.linalg.norm(drift))))
        now = sim.particles()
        ends[name] = (now["x"] - offset) / h, now["stress"] / np.abs(now["stress"]).max()
    limit = largest(h)
    shifted = max(float(np.abs(a - b).max()) for a, b in zip(ends["whole"], ends["still"], strict=True))
    return [
        Figure("change of the momentum", error, rounding(composition, 1e-12)),
        Figure("energy loss with the grid offset by 0.37 h, difference", loss["offset"] - loss["still"], limit),
        Figure("energy loss at 10, -7 cells per second, difference", loss["flying"] - loss["still"], limit),
        Figure("positions and stresses whole cells away, difference", shifted, rounding(composition, 1e-10)),
    ]


FAILURE = (
    "Particles that cross cells at other instants, and a grid that holds bodies back, make the result depend on where the grid "
    "lies and how fast it moves relative to the bodies; neither is in the equations."
)
REST = "momentum to 1e-12; the grid shifted by whole cells changes positions and stresses by less than 1e-10."
CASES = (
    Case(
        name="galilean",
        title="Two disks meet in one velocity field, with the grid offset and with the whole scene in flight",
        failure=FAILURE,
        criterion="Energy lost until 3.5 s (in the frame of the centre of mass, over the first) the same within 0.5 % with the grid offset "
        "by 0.37 h and at (10, -7) cells per second more (3 % for shape functions whose slope jumps); " + REST,
        source="Galilean invariance. The disks, in one velocity field: Sulsky, Chen and Schreyer (1994), doi:10.1016/0045-7825(94)90112-0",
        dim=2,
        measure=smoothly,
    ),
    Case(
        name="galilean-contact",
        title="Two disks meet with contact, with the grid offset and with the whole scene in flight",
        failure=FAILURE + " Contact is found at nodes: bodies touch earlier or later, by a part of a cell.",
        criterion="Energy lost until 3.5 s the same within what half a layer of cells has at the place of contact, "
        "R sqrt(2 v / c) h / (pi R^2), 3.9 % with h = 1/20 and half of it with half the cells; " + REST,
        source="Galilean invariance; contact at nodes is an impact of nodal masses that stick together for an instant: Bardenhagen, "
        "Brackbill and Sulsky (2000), doi:10.1016/S0045-7825(99)00338-2",
        dim=2,
        measure=touching,
        contact=True,
        applies=lambda composition: "" if composition.contact is not None else "the bodies share one velocity field: see galilean",
    ),
)
