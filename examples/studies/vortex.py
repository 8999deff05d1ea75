"""The scene of vortex_study.toml: the ring of the generalized vortex, turned by its body force and held by nothing else."""

import numpy as np

import mpmkit as mpm
from mpmkit.effects import BodyForce
from mpmkit.exact import Vortex
from mpmkit.integrators import FLIP, MUSL
from mpmkit.materials import NeoHookean

COURANT, LOOKS = 0.1, 20


def solution():
    """The middle of the ring turns by up to 0.2 rad and back, a shear of 1.4."""
    return Vortex(A=0.2)


def scene(N, shape, ppc):
    """N cells along a metre, `ppc` particles in each."""
    exact = solution()
    wave = np.sqrt((exact.lame[0] + 2 * exact.lame[1]) / exact.rho)
    dt = exact.T / LOOKS / np.ceil(exact.T / LOOKS * wave * N / COURANT)  # a whole number of steps between the instants
    sim = mpm.Simulation(mpm.Grid((-1.5, -1.5), (1.5, 1.5), 1 / N), shape=shape, integrator=MUSL(FLIP(), dt=dt), until=exact.T)
    ring = mpm.Disk((0.0, 0.0), Vortex.outer) - mpm.Disk((0.0, 0.0), Vortex.inner)
    material = NeoHookean(E=exact.E, nu=exact.nu, rho=exact.rho, form="log")
    sim += mpm.Body(ring, material, v=lambda X: exact.velocity(X, 0.0), particles_per_cell=ppc, name="ring")
    sim += BodyForce(exact.body_force_kernel())
    return sim
