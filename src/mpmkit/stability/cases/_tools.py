"""What the cases share: runs without a word, limits of rounding, fixed steps, and facts about a composition."""

from __future__ import annotations

import warnings
from typing import Any

import attrs
import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Composition, simulation

Array = Any
TRUSTED = 1e-3
"""What even single precision must keep: no limit of rounding is wider than this."""


def rounding(composition: Composition, limit: float) -> float:
    """A limit that stands for so many rounding errors of double precision, as as many of the precision in use; at most `TRUSTED`."""
    return float(min(TRUSTED, limit * np.finfo(composition.precision).eps / np.finfo("float64").eps))


def run(sim: mpm.Simulation, until: float) -> mpm.Simulation:
    """Run without a word: what a case has to say is in its figures."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        sim.run(until=until, quiet=True, threads=1)
    return sim


def fixed(composition: Composition, dt: float) -> Composition:
    """The same composition with a fixed time step."""
    return attrs.evolve(composition, integrator=attrs.evolve(composition.integrator, dt=dt))


def at_most(composition: Composition, cfl: float) -> Composition:
    """The same composition with no longer steps than this Courant number."""
    integrator = composition.integrator
    return attrs.evolve(composition, integrator=attrs.evolve(integrator, cfl=min(cfl, integrator.cfl)))


def step(composition: Composition, h: float, speed: float) -> float:
    """The time step that the composition's own rule would take at this largest speed, c + |v|."""
    return float(composition.integrator.cfl * h / speed)


def with_material(composition: Composition, material: Any) -> Any:
    """The constitutive model under test, or that of the case."""
    return composition.material if composition.material is not None else material


def wave_speed(material: Any, grid: mpm.Grid, composition: Composition) -> float:
    """Speed of waves in a body at rest [m/s], as the time step sees it."""
    sim = simulation(composition, grid)
    middle = 0.5 * (np.array(grid.lower) + np.array(grid.upper))
    sim += mpm.Body.from_arrays(middle[None, :], (0.5 * grid.h) ** grid.dim, material)
    return float(sim.compose().engine.outs[:, 0].max())


def cloud(body: mpm.Body, grid: mpm.Grid) -> tuple[Array, Array, Array]:
    """Positions, volumes and sizes of a body's particles, to place the very same ones elsewhere."""
    points = body.sample(grid)
    return np.array(points.x), np.array(points.V0), np.array(points.size)


def momentum_error(sim: mpm.Simulation, speed: float) -> float:
    """Largest change of the total momentum that no impulse explains, over mass times `speed`.

    Not along the radius of an axisymmetric scene: rings push each other outwards by their hoop stress, and what points away from the axis
    on all sides is no momentum.
    """
    h = sim.history
    axes = "yz" if sim.grid.space == "axisymmetric" else "xyz"
    error = [h[f"momentum_{a}"] - h[f"momentum_{a}"][0] - h[f"impulse_{a}"] - h[f"force_impulse_{a}"] for a in axes]
    return float(np.abs(error).max() / (h["mass"][0] * speed))
