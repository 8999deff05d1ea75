"""A column at rest under its weight, of which gravity changes a little."""

from __future__ import annotations

from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit.exact import Column, SuddenColumn
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import fixed, momentum_error, rounding, run, step

CHANGE = 0.01
SETTLED = Column(H=50.0, E=1e5, rho=80.0, g=0.0981)  # strains up to 0.4 %
ADDED = SuddenColumn(H=50.0, modulus=1e5, rho=80.0, g=CHANGE * SETTLED.g)
SWING = 2.0 * CHANGE * SETTLED.rho * SETTLED.g * SETTLED.H
"""The most that stress at the base changes by: twice the static change [Pa]."""


def column(composition: Composition, cells: int, g: float) -> mpm.Simulation:
    """The column as it rests under gravity before the change, under gravity g."""
    from mpmkit.boundaries import Symmetry
    from mpmkit.effects import Gravity
    from mpmkit.materials import NeoHookean

    h = SETTLED.H / cells
    Y = heights(cells)
    F = np.tile(np.eye(3), (len(Y), 1, 1))
    F[:, 0, 0] = SETTLED.stretch(Y)
    sim = simulation(fixed(composition, step(composition, h, 1.01 * ADDED.c)), mpm.Grid(0.0, SETTLED.H + 2.0 * h, h))
    material = NeoHookean(E=SETTLED.E, nu=SETTLED.nu, rho=SETTLED.rho)
    sim += mpm.Body.from_arrays(Y + SETTLED.displacement(Y), h / 2.0, material, F=F, size=(h / 4.0,), name="column")
    sim += Symmetry("xmin"), Gravity((-g,))
    return sim


def heights(cells: int) -> Any:
    """Where two particles in a cell are before loading [m]."""
    return (np.arange(2 * cells) + 0.5) * SETTLED.H / (2 * cells)


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """The column with the change and, beside it, without: what the change has done to the stresses, against the exact wave."""
    cells, periods = (50, 1) if quick else (100, 3)
    Y = heights(cells)
    left, changed = (column(composition, cells, g) for g in (SETTLED.g, (1.0 + CHANGE) * SETTLED.g))
    lowest = overshoot = noise = unrest = 0.0
    for t in np.linspace(0.0, periods * ADDED.period, 20 * periods + 1)[1:]:
        a, b = run(left, float(t)).particles("column"), run(changed, float(t)).particles("column")
        lowest = min(lowest, float((b["x"] - a["x"]).mean()))
        difference = b["stress"][:, 0] - a["stress"][:, 0]
        overshoot = max(overshoot, float(-difference.min()) / SWING)
        noise = max(noise, float(np.abs(difference - ADDED.stress(Y, t)).max()) / SWING)
        unrest = max(unrest, float(np.abs(a["stress"][:, 0] - SETTLED.stress(Y)).max()) / (SETTLED.rho * SETTLED.g * SETTLED.H / cells))
    static = float(ADDED.displacement(Y, 0.5 * ADDED.period).mean())
    return [
        Figure("largest mean displacement / exact - 1", lowest / static - 1.0, 0.05),
        Figure("largest change of stress / exact - 1", max(0.0, overshoot - 1.0), 0.1),
        Figure("change of stress, deviation from the exact one / largest", noise, 0.2),
        Figure("stress without the change, deviation / weight of a cell", unrest, 1.0),
        Figure("change of the momentum", momentum_error(changed, ADDED.c), rounding(composition, 1e-10)),
    ]


CASE = Case(
    name="changed-gravity",
    title="A column at rest under its weight, and one per cent more gravity",
    failure="A state of rest that is none on the grid rings by itself; a mild change sets off noise that grows to NaN.",
    criterion="One per cent more: mean displacement at most twice the static change, within 5 %; no stress changes by more than twice the "
    "static change at the base, plus 10 %; none is off the exact wave by more than 20 % of that. Without the change, no stress is off by "
    "more than the weight of a cell.",
    source="d'Alembert's solution, exact overshoot 2; thread 749 of cb-geo/mpm",
    dim=1,
    measure=measure,
)
