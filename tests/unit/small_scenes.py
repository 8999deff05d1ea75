"""Scenes of a few particles, which run as plain Python in a fraction of a second, and lists of components from the registry."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit._core.registry import registry
from mpmkit.materials import NeoHookean
from mpmkit.parameters import example_arguments
from mpmkit.shapes import Linear, QuadraticBSpline

EPS = float(np.finfo(float).eps)
SPACES = mpm.interfaces.SPACES
RUBBER = NeoHookean(E=100.0, nu=0.3, rho=2.0)
"""Sound travels 8 m/s in it."""


def components(*kinds: str) -> list[type]:
    """All registered component classes of these kinds, by name."""
    return [e.component for _, e in sorted(registry().of(*kinds).items())]


def example(cls: type, **given: Any) -> Any:
    """A component from the examples of its required parameters."""
    return cls(**(example_arguments(cls) | given))


def fits(transfer: Any, shape: Any) -> bool:
    """Whether these may be composed: gradients from moments need three nodes in each direction."""
    return transfer.gradient == "shape" or shape.nodes > 2


def grid(space: str, cells: int = 8, h: float = 0.25, lower: float = 0.0) -> mpm.Grid:
    """A domain of equal sides; the axisymmetric one begins at r = 1, away from the axis."""
    dim = {"1D": 1, "3D": 3}.get(space, 2)
    low = [lower] * dim
    if space == "axisymmetric":
        low[0] = 1.0
    return mpm.Grid(
        tuple(low), tuple(x + cells * h for x in low), h, coordinates="axisymmetric" if space == "axisymmetric" else "cartesian"
    )


def box(space: str, low: float, high: float) -> mpm.Box:
    """A cube in `grid`, with coordinates counted from its lower corner."""
    g = grid(space)
    return mpm.Box(tuple(x + low for x in g.lower), tuple(x + high for x in g.lower))


def simulation(g: mpm.Grid, *parts: Any, shape: Any = None, integrator: Any = None, **more: Any) -> mpm.Simulation:
    """A simulation with everything added; quadratic B-splines and MUSL if not given."""
    from mpmkit.integrators import MUSL

    if "discretization" not in more:
        shape, integrator = shape or QuadraticBSpline(), integrator or MUSL()
    sim = mpm.Simulation(g, shape=shape, integrator=integrator, **more)
    for part in parts:
        sim += part
    return sim


def run(sim: mpm.Simulation, until: float) -> mpm.Simulation:
    """Run without a word; the energy created by a coarse scene is not what these tests are about."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="energy is being created")
        sim.run(until=until, quiet=True)
    return sim


def bar(*parts: Any, n: int = 8, L: float = 1.0, v: Any = 0.0, E: float = 1.0, room: float = 0.5, **more: Any) -> mpm.Simulation:
    """A slender bar of `n` cells with one particle each, at the left end of a domain that is longer by `room`; wave speed sqrt(E)."""
    from mpmkit.materials import LinearElastic

    h = L / n
    g = mpm.Grid(0.0, L + h * round(room / h), h, lateral="stress")
    body = mpm.Body(mpm.Box(0.0, L), LinearElastic(E=E, nu=0.0, rho=1.0), v, particles_per_cell=1, name="bar")
    return simulation(g, body, *parts, shape=more.pop("shape", Linear()), **more)
