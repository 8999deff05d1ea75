"""A small body in free flight, simulated as plain Python: what any composition must leave alone."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from mpmkit.testing.collect import expect, expect_close

VELOCITY = (0.8, -0.4)
"""Of the body [m/s]; it crosses cells in both directions."""


@contextmanager
def plain_python() -> Iterator[None]:
    """Compose without compilation: a few particles and steps are done before a compiler has started."""
    before = os.environ.get("NUMBA_DISABLE_JIT")
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["NUMBA_DISABLE_JIT"]
        else:
            os.environ["NUMBA_DISABLE_JIT"] = before


def check_free_flight(*, shape: Any = None, integrator: Any = None) -> None:
    """A body that nothing acts on keeps its velocity, stays without stress and conserves mass and momentum.

    Parameters
    ----------
    shape : ShapeFunction, optional
        Quadratic B-splines if not given.
    integrator : Integrator, optional
        MUSL if not given.

    Notes
    -----
    Tolerance (rounding): 1e-12 of velocity and of modulus; some twenty steps, each with rounding of a few machine epsilons.
    """
    import mpmkit as mpm
    from mpmkit import integrators, materials, shapes

    E = 1e4
    shape = shapes.QuadraticBSpline() if shape is None else shape
    integrator = integrators.MUSL() if integrator is None else integrator
    with plain_python(), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of the ledger; the velocities below say more
        sim = mpm.Simulation(mpm.Grid(lower=(0.0, 0.0), upper=(1.0, 1.0), spacing=0.25), shape=shape, integrator=integrator)
        sim += mpm.Body(mpm.Box((0.3, 0.3), (0.6, 0.55)), materials.NeoHookean(E=E, nu=0.3, rho=1000.0), v=VELOCITY)
        results = sim.run(until=0.2, quiet=True)
    first, last = results.frames[0], results.frames[-1]
    steps = int(results.history["step"][-1])
    expect(steps > 5, f"the flight took only {steps} steps")
    wanted = np.zeros_like(last["v"])
    wanted[:, :2] = VELOCITY
    expect_close(last["v"], wanted, 1e-12, "velocity of the particles after a free flight")
    expect_close(last["x"] - first["x"], 0.2 * wanted, 1e-12, "displacement of the particles after a free flight")
    expect_close(last["stress"], np.zeros_like(last["stress"]), 1e-12 * E * steps, "stress of the particles after a free flight")
    expect_close(last["m"].sum(), first["m"].sum(), 0.0, "mass of the body after a free flight")
