"""The one-dimensional bars of SAND2002-0482 against their exact solutions.

Each example's `check` holds the tolerances: bands that other codes of the same scheme reach (pinned), and rounding where it says so.
"""

from __future__ import annotations

import pytest

import mpmkit as mpm
from mpmkit.contacts import FrictionalContact
from mpmkit.integrators import MUSL
from mpmkit.materials import VonMises
from mpmkit.shapes import GIMP

pytestmark = pytest.mark.physics


@pytest.mark.parametrize("name", ["bar_pulled", "bar_both_ends", "bar_impact", "bars_apart", "bar_plastic_impact", "load_a_boundary"])
def test_bar(example, name):
    bar = example(name)
    numbers = bar.main(quick=True)
    assert numbers
    bar.check(numbers)


def test_drawing_does_not_need_the_full_run(example, tmp_path):
    """One picture of an example in quick mode, so that a change of the drawing code is noticed."""
    bar = example("load_a_boundary")
    bar.main(quick=True, picture=tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000


def test_hardening_impact_at_ten_times_the_speed():
    """Case (f) with V0 = 1, Y = 40, strains of some percent: GIMP, 50 particles, in the band of case (f); tents are outside it (gallery).

    Pinned to the exact solution of small strains: restitution 23/45 to 0.04, plastic shortening 3.1111e-3 m to 5 %.
    """
    L, N, speed, gap = 0.5, 50, 1.0, 0.5
    metal = VonMises(E=1e4, nu=0.0, rho=1.0, yield_stress=40.0, tangent_modulus=2500.0)
    sim = mpm.Simulation(mpm.Grid(-0.5, 2.0, L / N, lateral="stress"), shape=GIMP(), integrator=MUSL(cfl=0.2))
    sim += mpm.Body(mpm.Box(0.0, L), metal, v=speed, particles_per_cell=1, name="left")
    sim += mpm.Body(mpm.Box(L + gap, 2 * L + gap), metal, v=-speed, particles_per_cell=1, name="right")
    sim += FrictionalContact()
    sim.run(until=gap / (2 * speed) + 0.03, quiet=True)
    for name, sign in (("left", 1.0), ("right", -1.0)):
        bar = sim.particles(name)
        assert abs(-sign * bar["v"].mean() / speed - 23 / 45) < 0.04
        assert abs(bar["eps_p"].sum() * L / N / 3.1111e-3 - 1) < 0.05
