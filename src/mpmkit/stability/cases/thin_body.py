"""A strip that is thinner than a cell."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import momentum_error, rounding, run
from mpmkit.stability.cases._tubes import NU, RHO, WAVE, E, rubber

THICKNESS, LENGTH, ALONG, ACROSS = 0.5, 16.0, 1e-3, 0.05  # cells; speeds over the wave speed
ACROSS_IT = 4
"""Particles across the thickness: with one there is no difference of velocities across it, and FLIP leaves it laterally rigid."""
PLATE = float(np.sqrt(E / (1.0 - NU**2) / RHO))
"""Speed of waves in a thin plate whose faces are free [m/s]."""
PERIOD = 0.05
"""Halfway between the two strips that can be confused: free to become thinner, and held at its thickness, whose waves run at `WAVE` and
whose period is shorter by 1 - PLATE / WAVE = 9.7 %."""


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Its lowest mode along its length, while it flies across the cells."""
    periods = 2 if quick else 4
    size = THICKNESS / ACROSS_IT
    n = int(LENGTH / size)
    X = np.tile((np.arange(n) + 0.5) * size, ACROSS_IT)
    Y = np.repeat((np.arange(ACROSS_IT) + 0.5) * size, n)
    x = np.stack([2.0 + X, 4.3 + Y], axis=1)
    mode = np.cos(np.pi * X / LENGTH)
    v = np.stack([ALONG * WAVE * mode, np.full(len(X), ACROSS * WAVE)], axis=1)
    period = 2.0 * LENGTH / PLATE
    upper = float(np.ceil(10.0 + ACROSS * WAVE * (periods + 1) * period))
    sim = simulation(composition, mpm.Grid((0.0, 0.0), (20.0, upper), 1.0))
    sim += mpm.Body.from_arrays(x, size**2, rubber(), v=v, size=(size / 2, size / 2), name="strip")
    around = (periods - 0.25 + np.linspace(-0.15, 0.15, 7)) * period
    part = [float((run(sim, float(t)).particles("strip")["v"][:, 0] * mode).sum()) for t in around]
    passed = float(np.interp(0.0, part, around)) if part[0] < 0.0 < part[-1] else np.inf
    history = sim.history
    vibration = history["energy"] - 0.5 * history["momentum_y"] ** 2 / history["mass"]
    return [
        Figure("period / exact - 1", passed / ((periods - 0.25) * period) - 1.0, PERIOD),
        Figure("energy of vibration gained", max(0.0, float(vibration.max() / vibration[0] - 1.0)), 0.05),
        Figure("change of the momentum", momentum_error(sim, ACROSS * WAVE), rounding(composition, 1e-10)),
    ]


CASE = Case(
    name="thin-body",
    title="A strip half a cell thin vibrates along its length and flies across the cells",
    failure="There are a few particles across the thickness and hardly a node between them: the stress across it must vanish by the "
    "motion of nodes that have "
    "little mass whenever the strip passes a row of nodes.",
    criterion="Period of the lowest mode within 5 % of that of a thin plate, 2 L sqrt(rho (1 - nu^2) / E), and a strip that is held at its "
    "thickness would be 9.7 % below; energy of the vibration does not grow by more than 5 %, of which 3.4 % are the half step by which "
    "velocities lag, w dt / 2; momentum to rounding.",
    source="Graff (1975), Wave Motion in Elastic Solids, chapter 8 (long waves in plates)",
    dim=2,
    measure=measure,
)
