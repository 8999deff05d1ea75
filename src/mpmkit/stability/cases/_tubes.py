"""Bars of rubber in uniaxial strain: the law, its plane shock, and two bars that touch."""

from __future__ import annotations

from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit.exact import lame
from mpmkit.stability.case import Composition, simulation

E, NU, RHO = 1e4, 0.3, 1.0
LAM, MU = lame(E, NU)
MODULUS = LAM + 2.0 * MU
WAVE = float(np.sqrt(MODULUS / RHO))
"""Speed of small waves in uniaxial strain [m/s]."""


def rubber(stiffness: float = 1.0, density: float = 1.0) -> Any:
    """The law of these bars, with E and rho as multiples of theirs."""
    from mpmkit.materials import NeoHookean

    return NeoHookean(E=stiffness * E, nu=NU, rho=density * RHO)


def shock(speed: float) -> tuple[float, float, float]:
    """Plane shock that takes rubber at rest to `speed` [m/s]: J behind it, stress there [Pa], its speed in the reference [m/s].

    With P = (M / 2) (J - 1 / J), mass and momentum across the front, rho0 U (1 - J) = rho0 v and rho0 U v = -P, leave
    (v / c)^2 = (1 - J)^2 (1 + J) / (2 J), c^2 = M / rho0.
    """
    roots = np.roots([1.0, -1.0, -1.0 - 2.0 * (speed / WAVE) ** 2, 1.0])  # (1 - J)^2 (1 + J) - 2 J (v / c)^2
    J = float(min(r.real for r in roots if abs(r.imag) < 1e-9 and 0.0 < r.real <= 1.0))
    return J, 0.5 * MODULUS * (J - 1.0 / J), speed / (1.0 - J)


def pair(composition: Composition, grid: mpm.Grid, left: dict[str, Any], right: dict[str, Any], per_cell: int = 2) -> mpm.Simulation:
    """Two bars with ``ends``, ``material`` and ``v`` each, with the contact of the composition."""
    sim = simulation(composition, grid)
    for name, bar in (("left", left), ("right", right)):
        sim += mpm.Body(mpm.Box(*bar["ends"]), bar["material"], v=bar["v"], particles_per_cell=per_cell, name=name)
    if composition.contact is not None:
        sim += composition.contact
    return sim


def drift(sim: mpm.Simulation, period: float) -> float:
    """Mean energy in the last period over that in the first - 1: without the half step by which velocities lag.

    That half step makes the energy swing by w dt / 2, twice in a period: rows of the history must be closer than a tenth of one.
    """
    t, energy = sim.history["t"], sim.history["energy"]

    def mean(begin: float) -> float:
        inside = t[(t > begin) & (t < begin + period)]
        at = np.concatenate(([begin], inside, [begin + period]))
        return float(np.trapezoid(np.interp(at, t, energy), at) / period)

    return mean(float(t[-1]) - period) / mean(float(t[0])) - 1.0
