"""Tractions on the inner and outer face of an axisymmetric body (rounding)."""

from __future__ import annotations

import numpy as np
import pytest

import mpmkit as mpm
from mpmkit.boundaries import TwoPointTraction
from mpmkit.integrators import MUSL
from mpmkit.materials import LinearElastic
from mpmkit.shapes import Linear


@pytest.mark.usefixtures("plain_python")
@pytest.mark.parametrize(("face", "radius"), [("xmin", 1.0), ("xmax", 2.0)])
def test_two_point_traction_acts_on_the_ring_at_the_boundary(face, radius):
    """Its force is traction times 2 pi r height with the radius of the face, not of the particles (1e-12 of it)."""
    grid = mpm.Grid((0.5, 0.0), (2.5, 0.5), 0.25, coordinates="axisymmetric")
    sim = mpm.Simulation(grid, Linear(), MUSL())
    sim += mpm.Body(mpm.Box((1.0, 0.0), (2.0, 0.5)), LinearElastic(E=1e3, nu=0.3, rho=1.0), name="ring")
    sim += TwoPointTraction(body="ring", traction=(0.01, 0.0), face=face)
    sim.run(until=1e-3, quiet=True)
    force = sim.history["force_impulse_x"][-1] / sim.history["t"][-1]
    assert abs(force / (0.01 * 2 * np.pi * radius * 0.5) - 1) < 1e-12
