"""The scene of waves_study.toml and precision_study.toml: a manufactured solution needs functions for its body force and its start."""

import numpy as np

import mpmkit as mpm
from mpmkit.boundaries import Symmetry
from mpmkit.effects import BodyForce
from mpmkit.exact import AxisAligned
from mpmkit.integrators import FLIP, MUSL
from mpmkit.materials import NeoHookean


def solution(A):
    """Waves along x and y between rollers."""
    return AxisAligned(A=A)


def scene(N, shape, A, precision="float64"):
    """N cells a side, four particles in each; a period of the waves."""
    exact = solution(A)
    wave = np.sqrt((exact.lame[0] + 2 * exact.lame[1]) / exact.rho)
    dt = exact.period / 20 / np.ceil(exact.period / 20 * wave * N / 0.3)  # a whole number of steps between the instants
    grid, integrator = mpm.Grid((0, 0), (1, 1), 1 / N), MUSL(FLIP(), dt=dt)
    sim = mpm.Simulation(grid, shape=shape, integrator=integrator, precision=precision, until=exact.period)
    material = NeoHookean(E=exact.E, nu=exact.nu, rho=exact.rho, form="log")
    sim += mpm.Body(mpm.Box((0, 0), (1, 1)), material, v=lambda X: exact.velocity(X, 0.0), particles_per_cell=4, name="body")
    sim += BodyForce(exact.body_force_kernel()), Symmetry("all")
    return sim
