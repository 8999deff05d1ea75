"""Checks of shape functions in a small scene, where the core has formed products over the directions and folded weights at boundaries."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import ShapeFunction
from mpmkit.testing.collect import check, expect_close
from mpmkit.testing.element import exponential
from mpmkit.testing.flight import check_free_flight
from mpmkit.testing.scenes import check_momentum, plain_python, rubber, standard_space

GRADIENT = np.array([[12.0, -7.0, 5.0], [9.0, -4.0, -6.0], [3.0, 8.0, -10.0]])
"""Of the prescribed velocity [1/s]: stretch, shear and rotation."""
DT = 1e-3


@check("shape", "linear field at every boundary")
def linear_field_at_every_boundary(shape: ShapeFunction, rng: Any) -> None:
    """A body fills the domain, and all nodes move as v = b + A x: each particle gets exactly exp(dt A) and that velocity.

    So partition of unity, linear reproduction and the sum of the gradients hold beside every face and corner, where the weights of nodes
    outside are folded into the domain. Tolerance (rounding): 1e-13 of F, some hundred machine epsilons.
    """
    import mpmkit as mpm
    from mpmkit import boundaries, integrators

    space = standard_space(shape)
    dim = {"1D": 1, "3D": 3}.get(space, 2)
    low = np.zeros(dim)
    low[0] = 1.0 if space == "axisymmetric" else 0.0
    A = GRADIENT[:dim, :dim]
    b = np.array([2.0, -3.0, 1.0])[:dim] - A @ low
    velocity = tuple(" + ".join([repr(float(b[a])), *(f"({float(A[a, k])!r})*{'xyz'[k]}" for k in range(dim))]) for a in range(dim))
    with plain_python():
        grid = mpm.Grid(tuple(low), tuple(low + 2.0), 0.5, coordinates="axisymmetric" if space == "axisymmetric" else "cartesian")
        sim = mpm.Simulation(grid, shape, integrators.MUSL(dt=DT))
        sim += mpm.Body(mpm.Box(tuple(low), tuple(low + 2.0)), rubber(), velocity, particles_per_cell=2**dim if dim < 3 else 1)
        sim += boundaries.PrescribedVelocity(velocity, region=mpm.Box((-9.0,) * dim, (9.0,) * dim))
        first = sim.particles()["x"]
        sim.run(until=DT, quiet=True, threads=1)
    last = sim.particles()
    expect_close(last["x"] - first, DT * (b + first @ A.T), 1e-14, "displacement in a linear field")
    L = np.zeros((3, 3))
    L[:dim, :dim] = A
    F = last["F"].reshape(-1, 3, 3)
    if space == "axisymmetric":  # the hoop is v_r / r, which is not the same everywhere
        F, L = F[:, :2, :2], L
        expect_close(F, np.broadcast_to(exponential(DT * L)[:2, :2], F.shape), 1e-13, "deformation in a linear field")
        return
    expect_close(F, np.broadcast_to(exponential(DT * L), F.shape), 1e-13, "deformation in a linear field")


@check("shape", "momentum is conserved")
def momentum_is_conserved(shape: ShapeFunction, rng: Any) -> None:
    """A trembling body that nothing acts on keeps its momentum. Tolerance (rounding): 1e-13 of the sum of all momenta."""
    check_momentum(shape)


@check("shape", "free flight", when=lambda shape: "plane strain" in shape.spaces)
def shape_free_flight(shape: ShapeFunction, rng: Any) -> None:
    """A body that nothing acts on keeps its velocity exactly, in two dimensions. Tolerance (rounding): 1e-12."""
    check_free_flight(shape=shape)
