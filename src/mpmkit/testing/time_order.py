"""Order of the error in the time step, observed on one grid."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import attrs
import numpy as np

from mpmkit.testing.collect import expect
from mpmkit.testing.element import Array
from mpmkit.testing.scenes import plain_python

STEPS = (8, 16, 32, 64)
LENGTH = 1.0


def check_time_order(claimed: int, **choices: Any) -> None:
    """Successive differences of the end state of a vibrating bar fall as dt^order.

    The bar is 6 cells long, quadratic B-splines if the shape function is free, and its particles stay in their cells, so that only the
    time step differs. With the error C dt^p the difference of two runs with dt and dt/2 falls by 2^p each time.
    """
    ends = [_end(steps, **choices) for steps in STEPS]
    errors = [float(np.abs(fine - coarse).max()) for coarse, fine in pairwise(ends)]
    orders = [float(np.log2(a / b)) for a, b in pairwise(errors)]
    told = f"differences {', '.join(f'{e:.3g}' for e in errors)} for {', '.join(map(str, STEPS))} steps"
    expect(max(orders[-1], min(orders)) >= claimed - 0.1, f"observed order in time {orders[-1]:.2f}, claimed {claimed} ({told})")


def _end(steps: int, **choices: Any) -> Array:
    """Velocities, positions and stresses after an eighth of the period of the bar, each in units of its size."""
    import mpmkit as mpm
    from mpmkit import boundaries, materials, shapes

    E, rho, v0, h = 1.0e4, 1.0, 0.1, LENGTH / 6.0
    T = 0.5 * LENGTH / 100.0
    for name, component in choices.items():
        choices[name] = attrs.evolve(component, dt=T / steps)
    if "integrator" in choices:
        choices = {"shape": shapes.QuadraticBSpline()} | choices
    with plain_python():
        sim = mpm.Simulation(mpm.Grid(0.0, LENGTH + h, h), **choices)
        law = materials.NeoHookean(E=E, nu=0.0, rho=rho)
        sim += mpm.Body(mpm.Box(0.0, LENGTH), law, f"{v0}*sin({np.pi / 2 / LENGTH!r}*x)", particles_per_cell=1, name="bar")
        sim += boundaries.Wall("xmin", condition="no slip")
        sim.run(until=T, quiet=True, threads=1)
    p = sim.particles()
    c = (E / rho) ** 0.5
    return np.concatenate([p["v"][:, 0] / v0, p["x"][:, 0] * c / (v0 * LENGTH), p["stress"][:, 0] / (rho * c * v0)])
