"""What each effect does to a body, and that the ledger knows it."""

import numpy as np
import pytest
from small_scenes import EPS, RUBBER, SPACES, bar, box, components, example, fits, grid, run, simulation

import mpmkit as mpm
from mpmkit.boundaries import PrescribedVelocity, Wall
from mpmkit.discretizations import FEM
from mpmkit.effects import ArtificialViscosity, BodyForce, Damping, Gravity
from mpmkit.integrators import FLIP, MLS, MUSL, PIC, USL
from mpmkit.materials import LinearElastic, NewtonianFluid
from mpmkit.shapes import GIMP, CubicBSpline, Linear, QuadraticBSpline

pytestmark = pytest.mark.usefixtures("plain_python")

DT = 0.01
STEPS = 12
G = {"1D": (-3.0,), "plane strain": (0.5, -3.0), "axisymmetric": (0.0, -3.0), "3D": (0.5, -3.0, 1.0)}


def falling(space, *parts, transfer=None, integrator=MUSL, shape=None, v=None, **more):
    """A small block that falls freely for twelve steps."""
    body = mpm.Body(box(space, 0.75, 1.0), RUBBER, v if v is not None else (0.0,) * grid(space).dim, name="block")
    sim = simulation(grid(space), body, *parts, shape=shape, integrator=integrator(transfer or FLIP(), dt=DT), **more)
    start = sim.particles()
    return start, run(sim, STEPS * DT)


# --- gravity and body force ---------------------------------------------------------------------------------------
@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize("effect", [Gravity, BodyForce], ids=lambda c: c.__name__)
def test_free_fall(effect, space):
    """v = g t and x = g dt^2 n (n + 1) / 2 of the explicit scheme, to rounding: 1e-12 of g t and of g t^2."""
    g, t = np.array(G[space]), STEPS * DT
    start, sim = falling(space, effect(tuple(g)))
    p = sim.particles()
    assert np.abs(p["v"] - g * t).max() < 1e-12 * 3.0 * t
    assert np.abs(p["x"] - start["x"] - g * DT**2 * STEPS * (STEPS + 1) / 2).max() < 1e-12 * 3.0 * t * t
    assert np.abs(p["stress"]).max() < 1e-12 * RUBBER.E
    last = {n: column[-1] for n, column in sim.history.items()}
    kinetic = 0.5 * last["mass"] * g @ g * t * t
    assert abs(last["kinetic"] - kinetic) < 1e-12 * kinetic
    assert abs(last["external_work"] - kinetic) < 1e-12 * kinetic
    assert abs(last["balance"]) < 1e-12
    impulse = [last[f"force_impulse_{a}"] for a in "xyz"[: len(g)]]
    assert np.abs(np.array(impulse) - last["mass"] * g * t).max() < 1e-12 * last["mass"] * 3.0 * t


METHODS = [
    pytest.param(integrator, cls, shape, id=f"{integrator.__name__}-{cls.__name__}-{shape.__name__}")
    for integrator in components("integrator")
    for cls in components("transfer")
    for shape in components("shape")
    if fits(example(cls), shape())
]


@pytest.mark.physics
@pytest.mark.parametrize(("integrator", "cls", "shape"), METHODS)
def test_free_fall_with_every_method(integrator, cls, shape):
    """Velocity, stress and work to rounding, as above."""
    for effect in (Gravity((0.5, -3.0)), BodyForce((0.5, -3.0))):
        _, sim = falling("plane strain", effect, transfer=example(cls), integrator=integrator, shape=shape())
        p, t = sim.particles(), STEPS * DT
        assert np.abs(p["v"] - np.array([0.5, -3.0]) * t).max() < 1e-12 * 3.0 * t
        assert np.abs(p["stress"]).max() < 1e-12 * RUBBER.E
        assert abs(sim.history["balance"][-1]) < 1e-12


def test_two_gravities_add_up():
    _, sim = falling("plane strain", Gravity((0.0, -1.0)), Gravity((2.0, 0.5)))
    assert np.abs(sim.particles()["v"] - np.array([2.0, -0.5]) * STEPS * DT).max() < 1e-13


def test_body_force_of_position_and_time():
    """Each particle's own initial position and the time at the start of the step; PIC would smooth it, FLIP with one node field does too."""
    _, sim = falling("plane strain", BodyForce(("t", "2*t*t")))
    times = DT * np.arange(STEPS)
    wanted = np.array([times.sum() * DT, 2.0 * (times**2).sum() * DT])
    assert np.abs(sim.particles()["v"] - wanted).max() < 1e-13  # rounding of numbers below 0.01

    def pull(X, t):
        return (3.0 * X[0], -X[1] * t)

    start, sim = falling("plane strain", BodyForce(pull))
    p = sim.particles()
    force = (p["m"][:, None] * np.stack([3.0 * start["x"][:, 0] * STEPS * DT, -start["x"][:, 1] * times.sum() * DT], axis=1)).sum(axis=0)
    assert np.abs((p["m"][:, None] * p["v"]).sum(axis=0) - force).max() < 1e-13 * np.abs(force).max()


def test_body_force_may_depend_on_velocity():
    """A force that turns the velocity, as of a charge in a magnetic field: the explicit scheme multiplies |v| by sqrt(1 + w^2 dt^2)."""

    def turn(v):
        return (-5.0 * v[1], 5.0 * v[0])

    _, sim = falling("plane strain", BodyForce(turn), v=(0.3, 0.0))
    speed = np.linalg.norm(sim.particles()["v"], axis=1)
    assert np.abs(speed - 0.3 * (1.0 + (5.0 * DT) ** 2) ** (STEPS / 2)).max() < 1e-13


def test_gravity_and_body_force_agree_with_fem():
    g = mpm.Grid((0.0, 0.0), (2.0, 2.0), 0.25)
    for effect in (Gravity((0.5, -3.0)), BodyForce((0.5, -3.0))):
        sim = simulation(g, mpm.Body(mpm.Box((0.5, 0.5), (1.0, 1.0)), RUBBER), effect, discretization=FEM(dt=DT))
        v = run(sim, STEPS * DT).particles()["v"]
        assert np.abs(v - np.array([0.5, -3.0]) * STEPS * DT).max() < 1e-13
        assert abs(sim.history["balance"][-1]) < 1e-12


# --- damping ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("space", SPACES)
def test_damping_of_rigid_motion(space):
    """v = v0 (1 - rate dt)^n, and what is lost is dissipated, both to rounding; close to exp(-rate t), of first order in dt."""
    v0 = np.zeros(grid(space).dim)
    v0[-1] = 0.7
    _, sim = falling(space, Damping(2.0), v=tuple(v0))
    v = sim.particles()["v"]
    assert np.abs(v - v0 * (1.0 - 2.0 * DT) ** STEPS).max() < 1e-13
    assert np.abs(v[:, -1] / 0.7 - np.exp(-2.0 * STEPS * DT)).max() < 2.0 * DT * 2.0 * STEPS * DT  # rate
    row = sim.history
    assert abs(row["dissipated"][-1] - (row["kinetic"][0] - row["kinetic"][-1])) < 1e-12 * row["kinetic"][0]
    assert row["external_work"][-1] == 0.0


def test_strong_damping_limits_the_time_step():
    sim = falling("plane strain", integrator=lambda t, dt: MUSL(t), v=(0.1, 0.0))[1]
    damped = simulation(
        grid("plane strain"), mpm.Body(box("plane strain", 0.75, 1.0), RUBBER, (0.1, 0.0)), Damping(1e4), integrator=MUSL(cfl=0.4)
    )
    assert sim.compose().limit.dt > 1e-2 > 1e-4
    run(damped, 4e-4)
    assert damped.step_number >= 10
    assert "Damping" in damped.compose().limit.rule and "damping" in damped.compose().limit.rule


# --- artificial viscosity -----------------------------------------------------------------------------------------
def homogeneous(rate, effect):
    """A block after one step in which all nodes move with v = rate (x - 1)."""
    v = tuple(f"{rate}*({a} - 1)" for a in "xy")
    field = PrescribedVelocity(v, region=mpm.Box((-1.0, -1.0), (3.0, 3.0)))
    body = mpm.Body(box("plane strain", 0.5, 1.5), RUBBER, v, name="block")
    return run(simulation(grid("plane strain"), body, effect, field, integrator=MUSL(PIC(), dt=1e-3)), 1e-3)


def test_artificial_viscosity_acts_in_compression_only():
    squeezed, stretched = homogeneous(-1.0, ArtificialViscosity()), homogeneous(1.0, ArtificialViscosity())
    assert (stretched.particles()["q"] == 0.0).all() and stretched.history["dissipated"][-1] == 0.0
    assert (squeezed.particles()["q"] > 0.0).all() and squeezed.history["dissipated"][-1] > 0.0


def test_artificial_viscosity_has_the_size_it_says():
    """q = rho h |D| (c1 c + c2 h |D|) with D = -2, and the work q |D| V dt is dissipated; to rounding, 1e-11 of each."""
    sim = homogeneous(-1.0, ArtificialViscosity(linear=0.3, quadratic=1.5))
    p = sim.particles()
    h, D, dt = 0.25, 2.0, 1e-3
    c = np.array([RUBBER.wave_speed(tuple(F), J, RUBBER.lam, RUBBER.mu, RUBBER.rho) for F, J in zip(p["F"], p["J"], strict=True)])
    wanted = p["rho"] * h * D * (0.3 * c + 1.5 * h * D)
    assert np.abs(p["q"] / wanted - 1.0).max() < 1e-11
    work = (wanted * D * p["V"] * dt).sum()
    assert abs(sim.history["dissipated"][-1] / work - 1.0) < 1e-11


@pytest.mark.parametrize("space", ["1D", "plane strain", "3D"])
def test_work_of_artificial_viscosity_is_in_the_ledger(space):
    """Two halves that run into each other: what motion and strain lose is what the ledger says is dissipated.

    Rate: the error of the balance is that of the time step, so that it falls with it; it is a small part of what is dissipated.
    """

    def crash(dt, *effects):
        g = grid(space)
        v = tuple("-0.8*tanh(50*(x - 1))" if a == 0 else 0.0 for a in range(g.dim))
        body = mpm.Body(
            box(space, 0.5, 1.5) if space != "3D" else mpm.Box((0.5, 0.75, 0.75), (1.5, 1.0, 1.0)), RUBBER, v, particles_per_cell=2**g.dim
        )
        return run(simulation(g, body, *effects, shape=Linear(), integrator=MUSL(dt=dt)), 0.05).history

    coarse, fine = (crash(dt, ArtificialViscosity(linear=0.5, quadratic=2.0)) for dt in (5e-3, 2.5e-3))
    without = crash(5e-3)
    assert without["dissipated"][-1] == 0.0
    assert fine["dissipated"][-1] > 0.05 * fine["kinetic"][0]
    assert fine["kinetic"][-1] + fine["stored"][-1] < without["kinetic"][-1] + without["stored"][-1] - 0.04 * fine["kinetic"][0]
    error = [abs(row["energy"][-1] - row["energy"][0]) / row["dissipated"][-1] for row in (coarse, fine)]
    assert error[1] < 0.7 * error[0] or error[1] < 2e-2
    assert (np.diff(fine["dissipated"]) >= 0.0).all()


def test_artificial_viscosity_limits_the_time_step():
    body = mpm.Body(box("plane strain", 0.5, 1.5), RUBBER, ("1 - x", 0.0), name="block")
    plain, viscous = (simulation(grid("plane strain"), body, *more) for more in ([], [ArtificialViscosity(linear=2.0)]))
    for sim in (plain, viscous):
        run(sim, 0.02)
    assert viscous.compose().limit.dt < 0.6 * plain.compose().limit.dt


def test_artificial_viscosity_spreads_a_front():
    """Behind a wave in a bar that hits a wall the particle velocities ring; viscosity leaves less of it."""

    def ringing(*effects):
        sim = run(bar(Wall("xmin", condition="no slip"), *effects, n=16, v=-0.01, integrator=MUSL(FLIP(), cfl=0.5)), 0.5)
        p = sim.particles("bar")
        behind = p["x"][:, 0] < 0.4
        return np.abs(p["stress"][behind, 0] + 0.01).max()

    assert ringing(ArtificialViscosity(linear=1.0, quadratic=0.0)) < 0.5 * ringing()  # pinned: 0.45


# --- effects and laws ---------------------------------------------------------------------------------------------
def sheared_honey(integrator):
    honey = NewtonianFluid(rho=1.0, bulk_modulus=50.0, viscosity=20.0)
    body = mpm.Body(box("plane strain", 0.5, 1.0), honey, ("0.3*(y - 0.75)", "0.3*(x - 0.75)"))
    return run(simulation(grid("plane strain"), body, integrator=integrator), 0.0015)


def test_viscosity_limits_the_time_step():
    rule = sheared_honey(MUSL()).compose().limit.rule
    assert "viscosity" in rule and "h^2" in rule and "nu = 26.6667" in rule  # 4/3 of 20


def test_viscous_dissipation_is_in_the_ledger():
    """Rate: the balance of a flow that viscosity stops is of first order in the time step."""
    coarse, fine = (sheared_honey(MUSL(dt=dt)).history for dt in (1e-4, 5e-5))
    lost = fine["kinetic"][0] - fine["kinetic"][-1]
    assert lost > 0.7 * fine["kinetic"][0]
    assert abs(fine["dissipated"][-1] / lost - 1.0) < 0.05
    assert abs(fine["balance"][-1]) < 0.6 * abs(coarse["balance"][-1]) < 0.05


@pytest.mark.parametrize("shape", [Linear(), QuadraticBSpline(), CubicBSpline(), GIMP()], ids=str)
def test_weight_on_the_ground(shape):
    """A column at rest under its weight: with damping it carries rho g (H - x) to 5 % of rho g H (pinned: eight particles)."""
    law = LinearElastic(E=100.0, nu=0.0, rho=1.0)
    body = mpm.Body(mpm.Box(0.0, 1.0), law, particles_per_cell=1, name="column")
    sim = simulation(
        mpm.Grid(0.0, 1.5, 0.125),
        body,
        Wall("xmin", condition="no slip"),
        Gravity((-1.0,)),
        Damping(12.0),
        shape=shape,
        integrator=MUSL(cfl=0.8),
    )
    run(sim, 1.2)
    p = sim.particles("column")
    weight = p["m"].sum() * 1.0
    below = np.argsort(p["x"][:, 0])[1:-2]
    wanted = -(1.0 - p["x"][below, 0])
    assert np.abs(p["stress"][below, 0] - wanted).max() < 0.05
    late = sim.history["t"] > 1.1
    reaction = np.diff(sim.history["impulse_x"][late]) / np.diff(sim.history["t"][late])
    assert np.abs(reaction / weight - 1.0).max() < 0.02
    assert EPS < np.abs(p["v"]).max() < 1e-2


@pytest.mark.parametrize("transfer", [PIC(), MLS()], ids=str)
def test_work_of_gravity_on_a_block_that_lands_and_rests(transfer):
    """Trapezoidal rule of the momentum, to rounding (1e-12 of M g^2 t dt): W = g M (x_end - x_start) + g dt (P_start - P_end) / 2.

    Positions move with the momentum after the step; momentum and forces are one sum at the nodes with these transfers.
    """
    dt, g = 2e-3, 9.81
    body = mpm.Body(box("plane strain", 0.5, 1.0), RUBBER, (0.2, -1.0))
    sim = simulation(
        grid("plane strain"), body, Wall("ymin", condition="slip"), Gravity((0.0, -g)), integrator=USL(transfer, limit=0.0, dt=dt)
    )
    assert sim.compose().plan.composition.merges

    def sums():
        p = sim.particles()
        return float((p["m"] * p["x"][:, 1]).sum()), float((p["m"] * p["v"][:, 1]).sum()), float(p["m"].sum())

    (place, momentum, mass), end = sums(), 1.0
    run(sim, end)
    place_end, momentum_end, _ = sums()
    assert sim.history["impulse_y"][-1] > 0.5 * mass * g * 0.3, "it lies on the wall"
    wanted = -g * (place_end - place) - g * dt * (momentum - momentum_end) / 2.0
    assert abs(sim.history["external_work"][-1] - wanted) < 1e-12 * mass * g * g * end
