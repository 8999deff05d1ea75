"""The step of the method as a matrix, for small vibrations of a uniform bar at rest: its eigenvalues give the stable Courant number.

The bar lies freely in one dimension, particles on a lattice that may be shifted against the grid; h = c = rho = E = 1. To first order in
the displacements weights and slopes are constant, and a step maps velocities V, affine matrices C and strains e of the particles linearly:

    nodes      M_i = sum_p m N_ip,  M v = sum_p m N_ip (V_p + C_p (x_i - x_p)),  M a = - sum_p G_ip V_p e_p
    particles  FLIP  V <- V + dt N a;  PIC  V <- N (v + dt a);  XPIC(m)  V <- N (v* + dt a);  e <- e + dt G w

with w = v before the update (USF, whose forces see the new strain), v + dt a limited at light nodes (USL), or the second mapping of the
new V (MUSL). Without the affine matrix MUSL and USF are a leapfrog for A M^-1 K, A = M^-1 (N^T m N) the ratio of consistent to lumped
mass, so that they are stable for dt^2 max eig(A M^-1 K) <= 4. A linear finite element mesh (Linear, one particle on each node) gives 1.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from mpmkit.errors import ParameterError
from mpmkit.stability.search import first_failure

if TYPE_CHECKING:
    from mpmkit.interfaces import ShapeFunction
    from mpmkit.stability.case import Composition

Matrix = Any
RADIUS = 1e-3
"""Growth per step above which a mode grows: a thousand steps then multiply it by 2.7."""
SEQUENCES = {"MUSL", "USF", "USL"}
TRANSFERS = {"FLIP", "PIC", "XPIC", "APIC", "MLS", "TPIC"}


def known(composition: Composition) -> bool:
    """Whether the matrix of this composition's step is written here."""
    transfer = getattr(composition.integrator, "transfer", None)
    return type(composition.integrator).__name__ in SEQUENCES and type(transfer).__name__ in TRANSFERS


@attrs.frozen
class Lattice:
    """Particles of a free bar and the nodes around them: weights, slopes, and distances x_i - x_p, all (n_p, n_i); masses."""

    N: Matrix
    G: Matrix
    r: Matrix
    m: float

    @property
    def M(self) -> Matrix:
        return self.N.sum(axis=0) * self.m

    def mapped(self, V: Matrix, C: Matrix) -> Matrix:
        """Velocities of the nodes from those of the particles and their affine parts."""
        return (self.N.T @ V + (self.N * self.r).T @ C) * self.m / self.M[:, None]


def lattice(shape: ShapeFunction, per_cell: int, offset: float, cells: int) -> Lattice:
    """A bar of so many cells, its particles in the middles of equal parts of the cells, shifted by `offset` cells."""
    x = 4.0 + offset + (np.arange(cells * per_cell) + 0.5) / per_cell
    count = cells + 10
    N, G = np.zeros((x.size, count)), np.zeros((x.size, count))
    for p, at in enumerate(x):
        first = int(np.floor(at - shape.offset))
        given = {"f": at - first, "half": 0.5 / per_cell}
        weights, slopes = shape.weights(**{name: given[name] for name in shape.weights.arguments})
        N[p, first : first + shape.nodes] = weights
        G[p, first : first + shape.nodes] = slopes
    kept = N.sum(axis=0) > 1e-14
    r = np.arange(count)[None, :] - x[:, None]
    return Lattice(N[:, kept], G[:, kept], r[:, kept], 1.0 / per_cell)


def amplification(lattice: Lattice, integrator: Any, dt: float) -> Matrix:
    """The matrix of one step on (V, C, e) of the particles."""
    N, G, r, m, M = lattice.N, lattice.G, lattice.r, lattice.m, lattice.M
    n, transfer, sequence = len(N), integrator.transfer, type(integrator).__name__
    kind = type(transfer).__name__
    moment = (N * r) / np.maximum((N * r * r).sum(axis=1), 1e-14)[:, None]
    slope = moment if kind == "MLS" else G
    V, C, e = np.split(np.eye(3 * n), 3)
    v = lattice.mapped(V, C)
    if sequence == "USF":
        e = e + dt * slope @ v
    dv = -dt * m * (slope.T @ e) / M[:, None]  # volume = m, since rho = 1
    if kind == "FLIP":
        V = transfer.blend * (V + N @ dv) + (1.0 - transfer.blend) * N @ (v + dv)
    elif kind == "XPIC":
        left, filtered = v, np.zeros_like(v)
        for _ in range(transfer.passes):  # I - (I - S S+)^m, one factor after the other
            filtered = filtered + left
            left = left - m * (N.T @ (N @ left)) / M[:, None]
        V = N @ (filtered + dv) if transfer.passes > 1 else N @ (v + dv)
    else:
        V = N @ (v + dv)
    C = {"APIC": moment, "MLS": moment, "TPIC": G}.get(kind, 0.0 * G) @ (v + dv)
    if sequence == "MUSL":
        e = e + dt * slope @ lattice.mapped(V, C)
    elif sequence == "USL":
        share = np.minimum(1.0, M / (integrator.limit * m)) if integrator.limit > 0.0 else np.ones_like(M)
        e = e + dt * slope @ (v + share[:, None] * dv)
    return np.concatenate([V, C, e])


def _steady(shift: Lattice, integrator: Any, dt: float) -> bool:
    return bool(np.abs(np.linalg.eigvals(amplification(shift, integrator, dt))).max() <= 1.0 + RADIUS)


def stable_courant(composition: Composition, per_cell: int, offset: float, cells: int = 8) -> float | None:
    """Largest dt c / h at which no mode of the bar grows; None if one grows at every dt that is tried.

    Raises
    ------
    ParameterError
        If the step of this composition is not written here.
    """
    if not known(composition):
        raise ParameterError(f"the linear step of {composition.label} is not written down; search its limit instead")
    bar = lattice(composition.shape, per_cell, offset, cells)
    steps = [0.1 * k for k in range(1, 41)]
    return first_failure(lambda dt: _steady(bar, composition.integrator, dt), steps, 0.005).holds
