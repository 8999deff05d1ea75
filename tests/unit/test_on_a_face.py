"""Particles on the faces of the domain: no velocity gradient from nothing, and rounding never puts them outside."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from small_scenes import RUBBER, run, simulation

import mpmkit as mpm
from mpmkit.boundaries import Wall
from mpmkit.effects import Gravity
from mpmkit.integrators import APIC, MUSL, TPIC
from mpmkit.shapes import GIMP, CubicBSpline, Linear, QuadraticBSpline
from mpmkit.stability.cases.thin_wall import at_wall
from mpmkit.stability.compositions import default

H = 0.1  # no number of the machine: the faces are rounded
SHAPES = [Linear(), GIMP(), QuadraticBSpline(), CubicBSpline()]


def single(x, *parts, shape, v=0.0, **more):
    grid = mpm.Grid((0.0, 0.0), (1.0, 1.0), H)
    body = mpm.Body.from_arrays([x], 0.25 * H * H, RUBBER, v=v, size=(0.25 * H, 0.25 * H), name="particle")
    return simulation(grid, body, Wall("all", condition="slip"), *parts, shape=shape, **more)


@pytest.mark.physics
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: type(shape).__name__)
@pytest.mark.parametrize("face", [0.0, 1.0])
def test_a_particle_slides_along_a_face(shape, face):
    """Tolerance: rounding. The inner neighbour of the face has a slope there but no mass: it once was taken to stand still."""
    for x in (face, float(np.nextafter(face, 0.5)), float(np.nextafter(face, 2.0 * face - 1.0))):
        sim = single((x, 0.45), shape=shape, v=(0.0, 1.0))
        sim.run(until=0.04, quiet=True)
        now = sim.particles("particle")
        assert np.abs(now["x"] - (face, 0.49)).max() < 1e-14
        assert np.abs(now["F"] - np.eye(3).ravel()).max() < 1e-14


@pytest.mark.physics
@pytest.mark.parametrize("transfer", [APIC(), TPIC()], ids=lambda transfer: type(transfer).__name__)
@pytest.mark.parametrize("face", [0.0, 1.0])
def test_affine_motion_does_not_grow_on_a_face(transfer, face):
    """Tolerance: rounding. The inner neighbour of the face has a slope but no mass: any stress would throw it, and C with it."""
    sim = single((face, 0.25), shape=QuadraticBSpline(), integrator=MUSL(transfer), v=(0.0, 0.25))
    run(sim, 1.6)
    now = sim.particles("particle")
    assert np.abs(now["x"] - (face, 0.65)).max() < 1e-12
    assert np.abs(now["stress"]).max() < 1e-12 * RUBBER.E


@pytest.mark.physics
def test_nodes_that_affine_motion_reaches_limit_the_time_step():
    """A particle stopped at a wall has |v| = 0 but C = v / h: the next step must not be h / c, or it is thrown behind the wall."""
    composition = attrs.evolve(default(), integrator=MUSL(APIC()), contact=None)
    assert [at_wall(composition, place) for place in (5.0, 5.4)] == [0.0, 0.0]


@pytest.mark.physics
@pytest.mark.parametrize("ulps", [1, 3, 8, 21])
def test_rounding_does_not_put_a_particle_outside(ulps):
    sim = single((1.0 - ulps * 2.0**-52, 0.45), Gravity((30.0, 0.0)), shape=QuadraticBSpline(), v=(1.0, 0.5))
    run(sim, 0.2)
    assert (sim.particles("particle")["x"][:, 0] <= 1.0).all()


def test_what_is_farther_outside_than_rounding_is_named():
    with pytest.raises(mpm.CompositionError, match="lie outside the domain"):
        single((1.0 + 1e-6, 0.45), shape=QuadraticBSpline()).compose()
