"""The order of a step: strain updates, the protection of USL, consistent mass, time steps that land."""

import math

import numpy as np
import pytest
from small_scenes import EPS, bar, components, example, grid, run, simulation

import mpmkit as mpm
from mpmkit._core.composing.increments import (
    centred,
    exponential_increment,
    exponential_volume_ratio,
    first_order_increment,
    midpoint_increment,
)
from mpmkit._core.running.timestep import land
from mpmkit.boundaries import PrescribedVelocity, TwoPointTraction, Wall
from mpmkit.integrators import APIC, FLIP, MUSL, PIC, USF, USL
from mpmkit.materials import LinearElastic, NeoHookean
from mpmkit.shapes import Linear, QuadraticBSpline
from mpmkit.tensor import det

pytestmark = pytest.mark.usefixtures("plain_python")

EYE = tuple(np.eye(3).ravel())


def spin(w):
    return (0.0, -w, 0.0, w, 0.0, 0.0, 0.0, 0.0, 0.0)


# --- strain updates, as functions ---------------------------------------------------------------------------------
def test_first_order_update_inflates_a_rotation_by_the_formula():
    """J = (1 + w^2 dt^2)^n: 1.04 after a turn in 1000 steps. Rounding: n machine epsilons."""
    w, n = 2.0, 1000
    dt = 2.0 * np.pi / w / n
    A = np.array(first_order_increment(spin(w), dt)).reshape(3, 3)
    J = np.linalg.det(np.linalg.matrix_power(A, n))
    assert abs(J / (1.0 + w * w * dt * dt) ** n - 1.0) < n * 4 * EPS
    assert abs(J - 1.04) < 0.001


@pytest.mark.parametrize("increment", [exponential_increment, midpoint_increment], ids=lambda f: f.__name__)
@pytest.mark.parametrize("w_dt", [1e-9, 1e-3, 0.1, 0.5, 3.0])
def test_other_updates_of_a_rotation_are_rotations(increment, w_dt):
    """Orthogonal to ten machine epsilons (rounding); the exponential turns by w dt to 4e-8 (w dt)^9, the midpoint rule by 2 atan(w dt / 2)."""
    R = np.array(increment(spin(1.0), w_dt)).reshape(3, 3)
    assert np.abs(R @ R.T - np.eye(3)).max() < 10 * EPS * max(1.0, w_dt)
    angle = np.arctan2(R[1, 0], R[0, 0])
    if increment is exponential_increment:
        assert abs(angle - w_dt) < 20 * EPS + 4e-8 * w_dt**9
    else:
        assert abs(angle - 2.0 * np.arctan(0.5 * w_dt)) < 20 * EPS * max(1.0, w_dt)


def test_exponential_is_the_matrix_exponential():
    """Against scipy, for velocity gradients of all sizes: to rounding (20 epsilons) and the truncation error it states (4e-8 |dt L|^9)."""
    from scipy.linalg import expm

    rng = np.random.default_rng(5)
    for size in (1e-30, 1e-8, 1e-4, 1e-2, 0.125, 0.5, 1.0, 2.0):
        for _ in range(20):
            L = rng.uniform(-1.0, 1.0, (3, 3))
            L = L / np.linalg.norm(L, 2)
            E = np.array(exponential_increment(tuple(L.ravel()), size)).reshape(3, 3)
            wanted = expm(size * L)
            assert np.linalg.norm(E - wanted, 2) < (20 * EPS + 5e-8 * size**9) * np.linalg.norm(wanted, 2), size
            ratio = exponential_volume_ratio(tuple(L.ravel()), size)
            assert abs(ratio / np.linalg.det(wanted) - 1.0) < 1e-13


def test_exponential_never_turns_a_body_inside_out():
    """A positive determinant for velocity gradients far above what a stable step allows, |dt L| = 5, in compression too."""
    rng = np.random.default_rng(6)
    for _ in range(100):
        L = rng.uniform(-1.0, 1.0, (3, 3))
        assert det(exponential_increment(tuple(L.ravel() / np.linalg.norm(L, 2)), 5.0)) > 0.0
    assert det(exponential_increment((-5.0, 0.0, 0.0, 0.0, -5.0, 0.0, 0.0, 0.0, -5.0), 1.0)) > 0.0


@pytest.mark.parametrize(
    ("increment", "order", "dt"), [(first_order_increment, 2, 0.02), (midpoint_increment, 3, 0.02), (exponential_increment, 9, 0.5)]
)
def test_order_of_the_updates(increment, order, dt):
    """Rate: the error of one step against the exponential falls as dt^order."""
    from scipy.linalg import expm

    L = np.array([0.3, 1.0, -0.2, -0.7, 0.1, 0.4, 0.2, -0.5, 0.6])
    errors = [np.abs(np.array(increment(tuple(L), s)).reshape(3, 3) - expm(s * L.reshape(3, 3))).max() for s in (dt, 0.5 * dt)]
    assert errors[0] / errors[1] > 2**order * 0.9


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_centred_gradient_follows_the_positions(way):
    """With Cayley's form the gradient of x + dt v for what follows, and of what has led to x; skew for a rotation along chords. Rounding."""
    rng = np.random.default_rng(7)
    A = rng.uniform(-0.2, 0.2, (3, 3))
    moved = np.eye(3) + A if way > 0.0 else np.linalg.inv(np.eye(3) - A)
    dt = 0.1
    found = midpoint_increment(centred(tuple((A / dt).ravel()), way * dt), dt)
    assert np.array(found).reshape(3, 3) == pytest.approx(moved, abs=20 * EPS)
    angle = 0.3
    R = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    chord = way * (np.linalg.matrix_power(R, int(way)) - np.eye(3))  # x is where the chord begins, or ends
    G = np.array(centred(tuple((chord / dt).ravel()), way * dt)).reshape(3, 3)
    assert np.abs(G + G.T).max() < 40 * EPS / dt
    assert np.array(midpoint_increment(tuple(G.ravel()), dt)).reshape(3, 3) == pytest.approx(R, abs=20 * EPS)


# --- strain updates, in a simulation ------------------------------------------------------------------------------
@pytest.mark.parametrize("integrator", components("integrator"), ids=lambda c: c.__name__)
@pytest.mark.parametrize("strain", ["first-order", "midpoint", "exponential"])
@pytest.mark.parametrize("shape", [example(c) for c in components("shape")], ids=lambda s: type(s).__name__)
def test_volume_of_a_body_in_rigid_rotation(shape, strain, integrator):
    """All nodes turn as v = w x r: the velocity gradient is exact, and J that of the update; 1e-12 (rounding)."""
    w, dt, steps = 1.5, 0.02, 10
    turn = PrescribedVelocity((f"-{w}*(y - 1)", f"{w}*(x - 1)"), region=mpm.Box((-9.0, -9.0), (9.0, 9.0)))
    soft = NeoHookean(E=1.0, nu=0.3, rho=1.0)
    body = mpm.Body(mpm.Box((0.75, 0.75), (1.25, 1.25)), soft, particles_per_cell=1)
    sim = run(simulation(grid("plane strain"), body, turn, shape=shape, integrator=integrator(PIC(), dt=dt, strain=strain)), steps * dt)
    p = sim.particles()
    J = np.array(p["J"])
    if strain == "first-order":
        assert np.abs(J / (1.0 + w * w * dt * dt) ** steps - 1.0).max() < 1e-12
        assert np.abs(p["stress"]).max() > 1e-3
    else:
        assert np.abs(J - 1.0).max() < 1e-12
        assert np.abs(p["stress"]).max() < 1e-12


# --- what the integrators are known for ---------------------------------------------------------------------------
def trembling(integrator):
    """Four particles that fly across twelve cells with a disturbance of 1e-6."""
    law = NeoHookean(E=0.7428, nu=0.3, rho=1.0)  # sound travels 1 m/s
    v = (0.08253, 0.05646)
    body = mpm.Body(mpm.Box((0.4, 0.4), (0.5, 0.5)), law, (f"{v[0]} + 1e-6*sin(37*x + 20*y)", f"{v[1]} + 1e-6*sin(30*y)"), name="body")
    sim = simulation(mpm.Grid((0.0, 0.0), (2.0, 2.0), 0.1), body, shape=Linear(), integrator=integrator, retries=0)
    p = run(sim, 15.0).particles("body")
    return np.abs(p["v"] - v).max()


def test_usl_is_bounded_by_its_limit():
    """The disturbance stays of its size; without the limit the body is torn apart already in free flight."""
    assert trembling(USL(cfl=0.4)) < 2e-6
    assert trembling(MUSL(cfl=0.4)) < 2e-6
    with (
        pytest.raises(mpm.StabilityError, match="energy was created|left the domain|inverted"),
        pytest.warns(UserWarning, match="slopes jump"),
    ):
        trembling(USL(cfl=0.4, limit=0.0))


def vibrating(integrator, **more):
    """A bar that is let go from a stretched state, v = 0.01 sin(pi x / 2): one period is 4 s."""
    sim = bar(Wall("xmin", condition="no slip"), v="0.01*sin(pi*x/2)", n=10, integrator=integrator, **more)
    return run(sim, 4.0)


@pytest.mark.filterwarnings("ignore:1 particle.*USL")  # which makes energy with one particle per cell, in many more steps
@pytest.mark.parametrize("integrator", components("integrator"), ids=lambda c: c.__name__)
@pytest.mark.parametrize("shape", [Linear(), QuadraticBSpline()], ids=lambda s: type(s).__name__)
def test_period_of_a_vibrating_bar(integrator, shape):
    """After a period the velocities are back, to 10 % (pinned: ten cells); MUSL and USF keep the energy to 2 %."""
    sim = vibrating(integrator(FLIP(), cfl=0.2), shape=shape)
    p = sim.particles("bar")
    wanted = 0.01 * np.sin(0.5 * np.pi * p["x"][:, 0])
    assert np.abs(p["v"][:, 0] - wanted).max() < 0.1 * 0.01
    energy = sim.history["energy"]
    if integrator is not USL:
        assert abs(energy[-1] / energy[0] - 1.0) < 0.02


# --- consistent mass ----------------------------------------------------------------------------------------------
@pytest.mark.parametrize("transfer", [FLIP(), PIC(), FLIP(0.5)], ids=str)
def test_consistent_mass_agrees_with_lumped(transfer):
    """The pulled bar with both: stress behind the front and end velocity agree to 15 % (pinned: twelve cells)."""
    load = TwoPointTraction("bar", (0.01,), "xmax")
    found = []
    for mass in ("lumped", "consistent"):
        sim = run(bar(load, Wall("xmin", condition="no slip"), n=12, integrator=MUSL(transfer, cfl=0.3, mass=mass)), 0.7)
        p = sim.particles("bar")
        found.append((p["stress"][p["x"][:, 0] > 0.55, 0].mean(), p["v"][p["x"][:, 0] > 0.55, 0].mean()))
        assert abs(sim.history["force_impulse_x"][-1] - 0.01 * 0.7) < 1e-12
        assert abs(sim.compose().momentum_error()) < 1e-10
    lumped, consistent = np.array(found)
    assert np.abs(consistent / lumped - 1.0).max() < 0.15
    assert (lumped != consistent).any()
    assert np.abs(lumped / 0.01 - 1.0).max() < 0.15


def test_consistent_mass_in_two_dimensions():
    """A free block that is pulled keeps its momentum account, and flies like the lumped one."""
    body = mpm.Body(mpm.Box((0.5, 0.5), (1.0, 1.0)), NeoHookean(E=50.0, nu=0.3, rho=1.0), (0.3, 0.1), name="block")
    load = TwoPointTraction("block", (0.2, 0.0), "xmax")
    for mass in ("lumped", "consistent"):
        sim = run(simulation(grid("plane strain"), body, load, shape=Linear(), integrator=MUSL(mass=mass, dt=5e-3)), 0.05)
        row = {n: c[-1] for n, c in sim.history.items()}
        assert abs(row["momentum_x"] - (0.3 * 0.25 + 0.2 * 0.5 * 0.05)) < 1e-12
        assert abs(row["momentum_y"] - 0.1 * 0.25) < 1e-12


@pytest.mark.parametrize("transfer", [FLIP(), PIC(), APIC()], ids=str)
def test_what_rests_under_its_weight_is_not_taken_for_light(transfer, plain_python):
    """Stress of a column of ten cells after a period, from that of equilibrium: within 0.2 of the weight of a cell (pinned: 0.14, 0.10,
    0.10; 0.5 to 0.9 when the strain of light nodes sees all of gravity, but not all of the stress that carries them).
    """
    from mpmkit.stability import Composition
    from mpmkit.stability.cases.changed_gravity import ADDED, SETTLED, column, heights

    sim = run(column(Composition(QuadraticBSpline(), USL(transfer)), 10, SETTLED.g), ADDED.period)
    off = sim.particles()["stress"][:, 0] - SETTLED.stress(heights(10))
    assert np.abs(off).max() < 0.2 * SETTLED.rho * SETTLED.g * SETTLED.H / 10


# --- time steps ---------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("fixed", [True, False])
def test_steps_land_on_their_target_without_a_tiny_one(fixed):
    for dt in (0.1, 0.3, 0.0999999, 0.33, 0.7):
        t, lengths = 0.0, []
        while t < 1.0:
            step, arrived = land(t, dt, 1.0, fixed=fixed)
            lengths.append(step)
            t = 1.0 if arrived else t + step
            assert arrived or t < 1.0
        assert abs(sum(lengths) - 1.0) < 1e-12
        assert max(lengths) <= dt * (1.0 + 1e-9) and min(lengths) > 0.45 * min(dt, 1.0)
        if fixed:
            assert set(lengths[:-2]) <= {dt}
        else:
            assert max(lengths) - min(lengths) < 1e-12  # rounding: sums of t
        assert len(lengths) == math.ceil(1.0 / dt * (1.0 - 1e-9))


def test_time_step_is_that_of_the_fastest_body():
    slow, fast = LinearElastic(E=1.0, nu=0.0, rho=1.0), LinearElastic(E=100.0, nu=0.0, rho=1.0)
    g = mpm.Grid(0.0, 4.0, 0.25, lateral="stress")
    sim = simulation(
        g,
        mpm.Body(mpm.Box(0.5, 1.5), slow, 0.5, name="slow"),
        mpm.Body(mpm.Box(2.0, 3.0), fast, 2.0, name="fast"),
        shape=Linear(),
        integrator=MUSL(cfl=0.3),
    )
    text = str(sim.explain())
    assert "body 'fast'" in text and "c + |v| = 12 m/s" in text and f"dt = {0.3 * 0.25 / 12:.4g} s" in text
    run(sim, 0.05)
    assert sim.step_number == 8  # 0.05 / 0.00625


def test_smallest_spacing_limits():
    body = mpm.Body(mpm.Box((0.5, 0.5), (1.0, 1.0)), LinearElastic(E=1.0, nu=0.0, rho=1.0), name="flat")
    sim = simulation(mpm.Grid((0.0, 0.0), (2.0, 2.0), (0.25, 0.125)), body, integrator=MUSL(cfl=0.5))
    assert "dt = 0.0625 s" in str(sim.explain())


@pytest.mark.filterwarnings("ignore:1 particle.*USL")
@pytest.mark.parametrize("integrator", [MUSL, USF, USL], ids=lambda c: c.__name__)
def test_fixed_step_is_kept(integrator):
    sim = bar(integrator=integrator(dt=0.01), v=0.01)
    run(sim, 0.25)
    assert sim.step_number == 25
    assert np.allclose(sim.history["dt"][1:], 0.01, rtol=1e-9)
