"""Masses, energies and wave speeds that no floating-point number holds are refused before the first step."""

import numpy as np
import pytest
from small_scenes import grid, simulation

import mpmkit as mpm
from mpmkit.materials import NeoHookean
from mpmkit.shapes import QuadraticBSpline

pytestmark = pytest.mark.usefixtures("plain_python")


def block(rho=1.0, E=1.0, v=0.0, V=0.0625, **more):
    body = mpm.Body.from_arrays([[0.9, 0.9], [1.1, 1.1]], V, NeoHookean(E=E, nu=0.0, rho=rho), v=(v, 0.0), size=(0.1, 0.1), name="block")
    return simulation(grid("plane strain"), body, shape=QuadraticBSpline(), **more)


@pytest.mark.parametrize(
    ("given", "what"),
    [
        ({"rho": 1e308, "V": 1.0}, r"its mass is inf kg, with rho = 1e\+308 kg/m\^3"),
        ({"rho": 1e300, "v": 1e10}, r"its kinetic energy is inf J, with rho = 1e\+300"),
        ({"rho": 1e37, "V": 20.0, "precision": "float32"}, r'its mass is .*float32 holds 1.2e-38 to 3.4e\+38. .*precision="float64"'),
        ({"rho": 1e-310}, r"the mass of its lightest particle is 6\.\d+e-312 kg"),
    ],
)
def test_masses_out_of_range(given, what):
    with pytest.raises(mpm.ParameterError, match=rf"body 'block': {what}"):
        block(**given).run(until=1e-3, quiet=True)


@pytest.mark.filterwarnings("ignore:overflow")  # numpy's, of the loops run as plain Python; compiled ones are silent
@pytest.mark.parametrize("given", [{"E": 1e300, "rho": 1e-9}, {"E": 1e38, "rho": 1e-3, "precision": "float32"}], ids=str)
def test_an_infinite_wave_speed(given):
    sim = block(**given)
    with pytest.raises(
        mpm.StabilityError,
        match=r"'block' \(NeoHookean\): the wave speed.* is infinite or not a number, c \+ \|v\| = inf m/s, at step 0.*smaller moduli",
    ):
        sim.run(until=1e-3, quiet=True)
    assert sim.step_number == 0


def test_a_modulus_that_single_precision_cannot_hold():
    with pytest.raises(mpm.ParameterError, match=r"mu of NeoHookean is 5e\+38, float32 holds up to 3.4e\+38"):
        block(E=1e39, precision="float32").run(until=1e-3, quiet=True)


def test_numbers_that_can_be_held_run():
    sim = block(rho=1e30, E=1e30)
    sim.run(until=1e-3, quiet=True)
    assert np.isfinite(sim.history["energy"]).all()
