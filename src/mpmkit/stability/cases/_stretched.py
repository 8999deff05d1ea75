"""A bar in uniaxial strain that is stretched homogeneously: every material point keeps its velocity, the exact solution."""

from __future__ import annotations

from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Composition, simulation

CELLS = 10  # of the bar at the start
E, NU, RHO = 1000.0, 0.3, 1.0


def rubber() -> Any:
    """Neo-Hookean with the quadratic volumetric energy: P = (lam / 2 + mu) (J - 1 / J) in uniaxial strain."""
    from mpmkit.materials import NeoHookean

    return NeoHookean(E=E, nu=NU, rho=RHO)


def modulus() -> float:
    """P-wave modulus [Pa]."""
    return E * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))


def stress(stretch: float) -> float:
    """Axial Cauchy stress [Pa], which is the nominal one."""
    return 0.5 * modulus() * (stretch - 1.0 / stretch)


def driven(composition: Composition, particles: int, largest: float, pull: float) -> tuple[mpm.Simulation, float]:
    """Bar 0 <= x <= `CELLS` that is stretched up to `largest` at `pull` wave speeds, and the velocity of its end.

    All particles start with v = V X / L; the plane x = 0 is held, and nodes in the last cell before the moving end and beyond it have the
    same field, v = V x / (L + V t).
    """
    from mpmkit.boundaries import PrescribedVelocity, Symmetry

    L = float(CELLS)
    grid = mpm.Grid(0.0, np.ceil(largest * L) + 6.0, 1.0)
    V = pull * float(np.sqrt(modulus() / RHO))
    sim = simulation(composition, grid)
    sim += mpm.Body(mpm.Box(0.0, L), rubber(), v=lambda X: V / L * X, particles_per_cell=particles, name="bar")
    sim += Symmetry("xmin")
    field = (f"{V!r} * x / ({L!r} + {V!r} * t)",)
    sim += PrescribedVelocity(velocity=field, region=mpm.Box(L - 1.0 - 1e-9, 10.0 * grid.upper[0]), moving=(V,))
    return sim, V
