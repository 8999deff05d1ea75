"""The problem that every program solves: a spinning, falling block of rubber in a box with slippery walls.

A unit box of N^d cells. A neo-Hookean block, 2^d particles in each of its cells on the regular lattice, starts with a translation and a
rigid spin about the middle of the box, under gravity along minus the last axis. Three cases: "apic3" and "apic2" are the form of APIC that
takes gradients by moving least squares (Hu et al. 2018, doi:10.1145/3197517.3201293) with quadratic B-splines in 3D and 2D, "flip3" is FLIP
(0.99) with linear functions in 3D.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

import numpy as np

E, NU, RHO = 1.0e6, 0.3, 1000.0
MU, LAMBDA = E / (2.0 * (1.0 + NU)), E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
TRANSLATION = (2.0, 1.0, 0.5)
OMEGA = 10.0
GRAVITY = 9.81
FLIP = 0.99
WALL = 3
"""Layers of nodes at each face that let nothing through, for programs without a boundary layer of their own."""
LIGHT = 0.05
"""Of linear functions: a node below this share of a particle's mass feels no stress, or it would be thrown out of the box."""
CASES = {"apic3": 3, "flip3": 3, "apic2": 2}
PRECISIONS = ("f64", "f32")
COMPARED_AT = 20
"""Step after which programs are compared."""
LATE = {"apic3": 1, "apic2": 1, "flip3": 0}
"""MLS programs update F when a step begins, from the matrix of the step before: theirs is that of ``COMPARED_AT - 1`` in ours."""


@dataclass(frozen=True)
class Size:
    """Cells along a side, time step, and the block in cells.

    Attributes
    ----------
    cells : int
        Cells along each side of the box.
    dt : float
        Time step [s].
    lower, block : tuple of int
        The block's lower corner and its size, in cells.
    """

    cells: int
    dt: float
    lower: tuple[int, ...]
    block: tuple[int, ...]

    @property
    def dim(self) -> int:
        """Number of space dimensions."""
        return len(self.block)

    @property
    def particles(self) -> int:
        """Number of particles."""
        return prod(self.block) * 2**self.dim

    @property
    def h(self) -> float:
        """Edge of a cell [m]."""
        return 1.0 / self.cells

    @property
    def volume(self) -> float:
        """Volume of a particle [m^d]."""
        return (0.5 * self.h) ** self.dim

    @property
    def mass(self) -> float:
        """Mass of a particle [kg]."""
        return RHO * self.volume


SIZES = {
    (3, "S"): Size(64, 1.0e-4, (16, 16, 16), (32, 32, 32)),
    (3, "L"): Size(128, 5.0e-5, (32, 32, 48), (64, 64, 32)),
    (2, "S"): Size(512, 1.25e-5, (128, 128), (256, 256)),
    (3, "Q"): Size(32, 2.0e-4, (8, 8, 8), (16, 16, 16)),  # quick
    (2, "Q"): Size(128, 5.0e-5, (32, 32), (64, 64)),
    (3, "T"): Size(16, 4.0e-4, (6, 6, 6), (4, 4, 4)),  # of the tests
    (2, "T"): Size(32, 2.0e-4, (10, 10), (12, 12)),
}
"""By dimension and letter; S has 262,144 particles, L 1,048,576."""


def cube(particles: float) -> Size:
    """A cube of about that many particles in the middle of a box of twice its side."""
    side = max(2, round((particles / 8.0) ** (1.0 / 3.0)))
    cells = 2 * side
    return Size(cells, 6.4e-3 / cells, ((cells - side) // 2,) * 3, (side,) * 3)


def start(size: Size) -> tuple[np.ndarray, np.ndarray]:
    """Positions and velocities at the start, float64[n, d], the particles of one cell one after the other."""
    cells = np.indices(size.block).reshape(size.dim, -1).T + np.array(size.lower)
    places = (np.indices((2,) * size.dim).reshape(size.dim, -1).T + 0.5) / 2.0
    x = ((cells[:, None, :] + places[None, :, :]) * size.h).reshape(-1, size.dim)
    return x, velocity(x)


def velocity(x: np.ndarray) -> np.ndarray:
    """Translation and spin about the middle at positions float64[n, d]."""
    v = np.tile(np.array(TRANSLATION[: x.shape[1]]), (len(x), 1))
    v[:, 0] -= OMEGA * (x[:, 1] - 0.5)
    v[:, 1] += OMEGA * (x[:, 0] - 0.5)
    return v


def diagnostics(size: Size, x: np.ndarray, v: np.ndarray, F: np.ndarray) -> dict[str, float]:
    """Momentum along the first and last axis, kinetic energy, means of |x|^2, J and |F|^2."""
    x, v = np.asarray(x, dtype=np.float64), np.asarray(v, dtype=np.float64)
    F = np.asarray(F, dtype=np.float64).reshape(len(x), size.dim, size.dim)
    return {
        "px": float(size.mass * v[:, 0].sum()),
        "pz": float(size.mass * v[:, -1].sum()),
        "ke": float(0.5 * size.mass * (v * v).sum()),
        "sx2": float((x * x).sum() / len(x)),
        "j": float(np.linalg.det(F).mean()),
        "f2": float((F * F).sum() / len(F)),
    }
