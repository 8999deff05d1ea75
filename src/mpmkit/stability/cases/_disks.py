"""Two rubber disks that fly at each other, with the same particles wherever the grid lies."""

from __future__ import annotations

from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Composition, simulation
from mpmkit.stability.cases._tools import cloud, fixed, step

E, NU, RHO, R = 1000.0, 0.3, 1000.0, 0.2
WAVE = float(np.sqrt(E * (1.0 - NU) / (1.0 + NU) / (1.0 - 2.0 * NU) / RHO))
SPEED = float(np.hypot(0.1, 0.1))
CENTRAL = (((0.2, 0.2), (0.1, 0.1)), ((0.8, 0.8), (-0.1, -0.1)))
"""Centre and velocity of each disk, head-on: the data of Sulsky, Chen and Schreyer (1994)."""
GLANCING = (((0.2, 0.29), (0.1, 0.1)), ((0.8, 0.73), (-0.1, -0.07)))
"""Without any symmetry."""

Map = Any
"""Takes positions or velocities float64[n, 2] to others of the same shape."""


def same(points: Any) -> Any:
    """As they are."""
    return points


def disks(
    composition: Composition,
    grid: mpm.Grid,
    h: float,
    start: Any,
    *,
    fastest: float = SPEED,
    place: Map = same,
    turn: Map = same,
    order: Map = same,
) -> mpm.Simulation:
    """Two disks with the particles of an unshifted grid of cells h, placed by `place`, with velocities turned by `turn`, in an `order`.

    The time step is fixed, that of the composition's rule at the speed `fastest`, so that runs can be compared step by step.
    """
    from mpmkit.materials import NeoHookean

    rubber = NeoHookean(E=E, nu=NU, rho=RHO)
    sim = simulation(fixed(composition, step(composition, h, WAVE + fastest)), grid)
    for (center, velocity), name in zip(start, ("left", "right"), strict=True):
        x, V, size = cloud(mpm.Body(mpm.Disk(center, R), rubber), mpm.Grid((0.0, 0.0), (1.0, 1.0), h))
        v = turn(np.tile(velocity, (len(x), 1)))
        sim += mpm.Body.from_arrays(order(place(x)), order(V), rubber, v=order(v), size=order(size), name=name)
    if composition.contact is not None:
        sim += composition.contact
    return sim


def internal_energy(sim: mpm.Simulation) -> Any:
    """Energy in the frame of the centre of mass over its first value, at every row of the history."""
    history = sim.history
    carried = sum(history[f"momentum_{a}"] ** 2 for a in "xyz") / (2.0 * history["mass"])
    energy = history["kinetic"] - carried + history["stored"]
    return energy / energy[0]
