"""Walls: a body bounces off a wall as off its mirror image (pinned: measured 1e-5 to 1e-3; 5e-2 with a wall that does work, 1e-1
with one that lets go of a node before the stress that strains come from is known)."""

from __future__ import annotations

import pytest

import mpmkit as mpm
from mpmkit.boundaries import Wall
from mpmkit.integrators import APIC, MUSL, USF, XPIC
from mpmkit.materials import NeoHookean
from mpmkit.shapes import QuadraticBSpline

pytestmark = pytest.mark.physics
R, H, V = 0.1, 0.01, 1.4


def bounce(integrator: mpm.Integrator, mirror: bool) -> tuple[float, float]:
    """Speed after over speed before, and the largest energy out of nothing, for a disk that hits a wall or its image."""
    sim = mpm.Simulation(mpm.Grid((0.0, 0.0), (0.4, 0.8 if mirror else 0.4), H), shape=QuadraticBSpline(), integrator=integrator)
    rubber = NeoHookean(E=1e6, nu=0.3, rho=1000.0)
    if mirror:
        sim += mpm.Body(mpm.Disk((0.2, 0.25), R), rubber, v=(0.0, V), name="disk")
        sim += mpm.Body(mpm.Disk((0.2, 0.55), R), rubber, v=(0.0, -V), name="image")
    else:
        sim += mpm.Body(mpm.Disk((0.2, 0.15), R), rubber, v=(0.0, -V), name="disk"), Wall("ymin", condition="slip")
    sim.run(until=0.08, quiet=True)
    return abs(sim.particles("disk")["v"][:, 1].mean()) / V, sim.history["balance"].max()


@pytest.mark.parametrize("integrator", [MUSL(), USF(), USF(APIC()), MUSL(XPIC())], ids=lambda i: f"{type(i).__name__}-{i.transfer}")
def test_a_wall_is_a_mirror(integrator):
    wall, created = bounce(integrator, mirror=False)
    image, _ = bounce(integrator, mirror=True)
    assert abs(wall - image) < 2e-3
    assert created < 0.015  # of the time integration itself: the mirror image has 0.010
