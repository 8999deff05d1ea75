"""Boundary layers: what walls let through, what prescribed nodes do, and how much a traction pulls."""

import attrs
import numpy as np
import pytest
from small_scenes import RUBBER, SPACES, bar, box, components, example, grid, run, simulation

import mpmkit as mpm
from mpmkit._core.running.held import Held
from mpmkit.boundaries import PrescribedVelocity, Symmetry, TractionLayer, TwoPointTraction, Wall
from mpmkit.discretizations import FEM
from mpmkit.effects import Gravity
from mpmkit.integrators import APIC, FLIP, MUSL, PIC, USF, USL, XPIC
from mpmkit.materials import LinearElastic, NeoHookean
from mpmkit.shapes import CubicBSpline, Linear, QuadraticBSpline

pytestmark = pytest.mark.usefixtures("plain_python")

SHAPES = [example(c) for c in components("shape")]
EVERYWHERE = mpm.Box((-9.0, -9.0), (9.0, 9.0))


def named(x):
    return type(x).__name__


# --- walls --------------------------------------------------------------------------------------------------------
def ball_at_wall(wall, v, until, space="plane strain", at=(0.5, 0.0), **more):
    """A block that touches the lower face of the second axis (1D: of the first)."""
    g = grid(space)
    low = np.array(g.lower) + (np.array(at) if g.dim == 2 else 0.0)
    body = mpm.Body(mpm.Box(tuple(low), tuple(low + 0.25)), RUBBER, v, name="block")
    return run(simulation(g, body, wall, **more), until)


@pytest.mark.parametrize("integrator", components("integrator"), ids=lambda c: c.__name__)
@pytest.mark.parametrize("shape", SHAPES, ids=named)
def test_wall_lets_go_unless_it_clamps(shape, integrator):
    """What leaves a sticky wall or one without friction is free from the start; one without slip holds it."""
    away = (0.3, 0.8)
    for wall in (Wall("ymin"), Wall("ymin", condition="slip"), Wall("ymin", friction=0.5)):
        v = ball_at_wall(wall, away, 0.06, shape=shape, integrator=integrator()).particles()["v"]
        assert np.abs(v - away).max() < 1e-12, wall  # rounding, of velocities of about one
    held = ball_at_wall(Wall("ymin", condition="no slip"), away, 0.06, shape=shape, integrator=integrator())
    assert held.particles()["v"][:, 1].mean() < 0.7
    assert held.history["impulse_y"][-1] < 0.0  # pulled back
    rolling = ball_at_wall(Symmetry("ymin"), away, 0.06, shape=shape, integrator=integrator()).particles()["v"]
    assert rolling[:, 1].mean() < 0.7  # held in tension too
    assert np.abs(rolling[:, 0].mean() - 0.3) < 1e-12  # but free along the plane


@pytest.mark.parametrize("transfer", components("transfer"), ids=lambda c: c.__name__)
@pytest.mark.parametrize("integrator", components("integrator"), ids=lambda c: c.__name__)
def test_what_presses_on_a_wall(integrator, transfer):
    """Sticky: no motion along the wall. Slip: nothing along it is lost. Nobody passes, and momentum is accounted for (rounding, 1e-12)."""
    into = (0.5, -0.5)
    along = {}
    for wall in (
        Wall("ymin"),
        Wall("ymin", condition="slip"),
        Wall("ymin", condition="no slip"),
        Symmetry("ymin"),
        Wall("ymin", friction=0.0),
        Wall("ymin", friction=0.3),
    ):
        sim = ball_at_wall(wall, into, 0.08, integrator=integrator(example(transfer)))
        p = sim.particles()
        assert p["x"][:, 1].min() > 0.0
        assert p["v"][:, 1].mean() > -0.3
        along[str(wall)] = p["v"][:, 0].mean()
        assert sim.compose().momentum_error() < 1e-12, wall
    slip = along["Wall(faces=('ymin',), condition=slip)"]
    assert abs(slip - 0.5) < 1e-12 and abs(along["Symmetry(faces=('ymin',))"] - 0.5) < 1e-12
    assert abs(along["Wall(faces=('ymin',), friction=0)"] - slip) < 1e-14  # momentum and forces are summed apart where there is friction
    assert along["Wall(faces=('ymin',))"] < along["Wall(faces=('ymin',), friction=0.3)"] < 0.4 + 0.1
    assert along["Wall(faces=('ymin',), condition=no slip)"] < 0.4


def test_all_faces_close_the_domain():
    for space in ("1D", "plane strain", "3D"):
        g = grid(space)
        v = tuple([1.5, -1.2, 0.9][: g.dim])
        body = mpm.Body(mpm.Box((0.5,) * g.dim, (0.75,) * g.dim), NeoHookean(E=20.0, nu=0.0, rho=1.0), v, particles_per_cell=1)
        small = mpm.Grid((0.25,) * g.dim, (1.25,) * g.dim, 0.25)
        sim = run(simulation(small, body, Wall("all", condition="slip"), shape=Linear(), integrator=MUSL(cfl=0.5)), 1.2)
        x = sim.particles()["x"]
        assert (x > 0.25).all() and (x < 1.25).all()
        assert abs(sim.history["kinetic"][-1] / sim.history["kinetic"][0] - 1.0) < 0.2  # it has bounced


@pytest.mark.parametrize("transfer", [example(c) for c in components("transfer")], ids=named)
def test_sliding_block_is_stopped_at_the_right_rate(transfer):
    """Friction takes mu times the normal impulse while all of it slides, less where light nodes stick; so mu g to 15 % (pinned: XPIC 12 %, the others 3 %)."""
    mu, g = 0.3, 2.0
    body = mpm.Body(mpm.Box((0.25, 0.0), (0.75, 0.25)), RUBBER, (0.8, 0.0), name="block")
    sim = simulation(grid("plane strain"), body, Wall("ymin", friction=mu), Gravity((0.0, -g)), integrator=MUSL(transfer, dt=5e-3))
    run(sim, 0.3)
    row = {n: c[-1] for n, c in sim.history.items()}
    assert row["impulse_y"] > 0.9 * row["mass"] * g * 0.3
    assert 0.85 * mu < -row["impulse_x"] / row["impulse_y"] < 1.001 * mu  # FLIP: a little of the impulse on the nodes is not felt
    v = sim.particles()["v"][:, 0].mean()
    assert abs(row["mass"] * (0.8 - v) + row["impulse_x"]) < 1e-12 * row["impulse_y"]
    assert abs((0.8 - v) / (mu * g * 0.3) - 1.0) < 0.15
    assert sim.compose().momentum_error() < 1e-12
    lost = 0.5 * row["mass"] * (0.8**2 - v**2)
    assert 0.8 * lost < row["dissipated"] < 1.3 * lost


def test_enough_friction_holds():
    """A block at rest under gravity that pulls it along less than friction can hold does not slide away."""
    body = mpm.Body(mpm.Box((0.25, 0.0), (0.75, 0.25)), RUBBER, name="block")

    def slide(friction):
        sim = simulation(grid("plane strain"), body, Wall("ymin", friction=friction), Gravity((0.6, -2.0)), integrator=MUSL(PIC(), dt=5e-3))
        return run(sim, 0.4).particles()["v"][:, 0].mean()

    assert slide(0.6) < 0.05 * 0.6 * 0.4  # it leans, but its foot stays
    assert abs(slide(0.1) / ((0.6 - 0.1 * 2.0) * 0.4) - 1.0) < 0.1


def test_wall_parameters_that_contradict():
    with pytest.raises(mpm.ParameterError, match=r"friction is required"):
        Wall(condition="friction")
    with pytest.raises(mpm.ParameterError, match=r"friction = 0.3 would be ignored with condition 'slip'"):
        Wall(condition="slip", friction=0.3)
    with pytest.raises(mpm.ParameterError, match="did you mean 'xmin'"):
        Wall("xmim")


def test_what_a_wall_remembers_stays_with_the_nodes():
    """Wherever they are stored, and whatever others are listed; a node in a corner is listed for each of its faces."""
    x, y = (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)
    held = Held()
    flags = held.of(np.array([7, 9, 9]), np.array([x, x, y]))
    assert flags.tolist() == [False, False, False]
    flags[1] = True
    assert held.of(np.array([7, 9, 9]), np.array([x, x, y])) is flags
    assert held.of(np.array([9, 9, 11, 7]), np.array([y, x, x, x])).tolist() == [False, True, False, False]
    other = Held()
    other.restore(**held.state())
    assert other.of(np.array([9]), np.array([x])).tolist() == [True]


# --- symmetry -----------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("method", [MUSL(dt=5e-3), MUSL(PIC(), dt=5e-3), MUSL(XPIC(4), dt=5e-3), USF(XPIC(2), dt=5e-3)], ids=str)
def test_half_with_symmetry_is_the_half_of_the_whole(method):
    """Linear functions see the same on both sides of a plane of symmetry; to 1e-11 of each field's size (rounding, twenty steps).

    The momentum that the plane gives to the half is that by which the half's changes (rounding).
    """
    law = NeoHookean(E=50.0, nu=0.3, rho=1.0)
    v = ("-0.5*x", "0.4*y + 0.3*x*x")
    whole = mpm.Body(mpm.Box((-0.5, 0.25), (0.5, 0.75)), law, v)
    half = mpm.Body(mpm.Box((0.0, 0.25), (0.5, 0.75)), law, v)
    both = run(simulation(mpm.Grid((-1.0, 0.0), (1.0, 1.5), 0.25), whole, shape=Linear(), integrator=method), 0.1).particles()
    sim = run(simulation(mpm.Grid((0.0, 0.0), (1.0, 1.5), 0.25), half, Symmetry("xmin"), shape=Linear(), integrator=method), 0.1)
    one = sim.particles()
    assert sim.compose().momentum_error() < 1e-12
    right = both["x"][:, 0] > 0.0
    for name in one:
        assert np.abs(both[name][right] - one[name]).max() < 1e-11 * np.abs(one[name]).max(), name


def test_axis_of_rings_is_straight():
    """A cylinder that is squeezed along the axis widens; no particle reaches the axis."""
    g = mpm.Grid((0.0, 0.0), (1.0, 1.0), 0.25, coordinates="axisymmetric")
    body = mpm.Body(mpm.Box((0.0, 0.25), (0.5, 0.75)), RUBBER, ("0.2*x", "-0.8*(y - 0.5)"))
    sim = run(simulation(g, body, Symmetry("xmin"), shape=Linear(), integrator=MUSL(dt=5e-3)), 0.1)
    p = sim.particles()
    assert p["x"][:, 0].min() > 0.05
    assert p["F"][:, 8].min() > 1.0  # hoops are longer
    assert p["F"][:, 4].max() < 1.0


# --- prescribed velocity ------------------------------------------------------------------------------------------
@pytest.mark.parametrize("shape", SHAPES, ids=named)
@pytest.mark.parametrize("integrator", components("integrator"), ids=lambda c: c.__name__)
def test_everything_prescribed_moves_as_prescribed(integrator, shape):
    """With PIC the particles have the velocity of the nodes, here of a linear field: 1e-12 (rounding)."""
    field = PrescribedVelocity(("0.3 + 0.2*y", "0.1*x"), region=EVERYWHERE)
    sim = run(
        simulation(
            grid("plane strain"),
            mpm.Body(box("plane strain", 0.5, 0.75), RUBBER),
            field,
            shape=shape,
            integrator=integrator(PIC(), dt=0.01),
        ),
        0.01,
    )
    p = sim.particles()
    start = p["X"] if "X" in p else p["x"] - 0.01 * p["v"]
    assert np.abs(p["v"] - np.stack([0.3 + 0.2 * start[:, 1], 0.1 * start[:, 0]], axis=1)).max() < 1e-12
    first = integrator is USF  # strains come from the velocities at the start of the step
    L = (p["F"].reshape(-1, 3, 3) - np.eye(3))[:, :2, :2] / 0.01
    assert np.abs(L - [[0.0, 0.2], [0.1, 0.0]]).max() < 2e-3, first  # exp(dt L) - 1 = dt L + O(dt^2)


@pytest.mark.parametrize(
    ("components_", "wanted"),
    [("all", (0.6, -0.2)), ("x", (0.6, 0.1)), ("y", (0.4, -0.2)), ("normal", (0.4, -0.2)), ("tangential", (0.6, 0.1))],
)
def test_components_of_prescribed_velocity(components_, wanted):
    """At the nodes of the face ymin, whose normal is y; read from the nodes themselves."""
    layer = (
        PrescribedVelocity((0.6, -0.2), "ymin", components=components_)
        if components_ not in "xy"
        else PrescribedVelocity((0.6, -0.2), region=mpm.Box((-9.0, -9.0), (9.0, 0.1)), components=components_)
    )
    body = mpm.Body(mpm.Box((0.5, 0.0), (1.0, 0.5)), RUBBER, (0.4, 0.1))
    sim = run(simulation(grid("plane strain"), body, layer, shape=Linear(), integrator=MUSL(dt=1e-3)), 1e-3)
    engine = sim.compose().engine
    layout, x = engine.plan.node_layout, engine.node_positions()
    G = engine.fields[0].G.reshape(-1, engine.channels)
    on = (G[:, 0] > 1e-6) & (x[:, 1] < 0.1)
    above = (G[:, 0] > 1e-6) & (x[:, 1] > 0.1)
    v = slice(layout.start["v"], layout.start["v"] + 2)
    assert on.sum() == 3 and above.sum() == 6
    assert np.abs(G[on, v] - wanted).max() < 1e-13
    assert np.abs(G[above, v] - (0.4, 0.1)).max() < 1e-13


def test_prescribed_velocity_in_time():
    """Formula and function of time, at the time of the step's start; the body follows its clamped end."""
    dt, steps = 1e-2, 10

    def push(t):
        return (t * t,)

    for velocity in ("t*t", push):
        layer = PrescribedVelocity(velocity, region=mpm.Box((-9.0,), (9.0,)))
        sim = run(bar(layer, shape=Linear(), integrator=MUSL(PIC(), dt=dt)), steps * dt)
        t = dt * np.arange(steps)
        p = sim.particles("bar")
        assert np.abs(p["v"] - t[-1] ** 2).max() < 1e-15
        assert np.abs(p["x"][0] - 0.0625 - dt * (t * t).sum()).max() < 1e-15


def test_prescribed_velocity_on_a_face_pulls_a_bar():
    """Strain of a bar whose end is pulled slowly; the wall's impulse and work are in the ledger, to rounding."""
    layer = PrescribedVelocity(-0.01, "xmin")
    sim = run(bar(layer, integrator=MUSL(FLIP(), cfl=0.5)), 1.0)
    row = {n: c[-1] for n, c in sim.history.items()}
    assert row["boundary_work"] > 0.0
    assert abs(row["momentum_x"] - row["impulse_x"]) < 1e-13
    assert abs(sim.particles("bar")["v"].mean() / -0.01 - 1.0) < 0.1  # the front has just reached the free end


def test_region_may_move():
    """A punch that moves sideways prescribes what it has reached, and no longer what it has left."""
    x = np.linspace(0.3, 1.7, 29)[:, None]
    cloud = mpm.Body.from_arrays(x, 0.05, LinearElastic(E=1e-9, nu=0.0, rho=1.0), name="dust")
    punch = PrescribedVelocity(1e-3, region=mpm.Box((0.3,), (0.6,)), moving=1.0)
    sim = run(simulation(grid("1D"), cloud, punch, shape=Linear(), integrator=MUSL(PIC(), dt=0.05)), 0.5)
    engine = sim.compose().engine
    G, nodes = engine.fields[0].G.reshape(-1, engine.channels), engine.node_positions()[:, 0]
    held = np.isclose(G[:, engine.plan.node_layout.start["v"]], 1e-3, rtol=1e-12)
    assert nodes[held].tolist() == [0.75, 1.0]  # the region is at 0.75 to 1.05 at the start of the last step
    resting = run(simulation(grid("1D"), cloud, attrs.evolve(punch, moving=None), shape=Linear(), integrator=MUSL(PIC(), dt=0.05)), 0.5)
    pushed = [s.particles("dust")["v"][x[:, 0] > 0.9].sum() for s in (sim, resting)]
    assert pushed[0] > 3.0 * pushed[1] > 0.0


def test_fast_nodes_limit_the_time_step():
    layer = PrescribedVelocity(50.0, "xmax")
    sim = bar(layer)
    sim.explain()
    assert "prescribed speed 50 m/s" in str(sim.explain())


def test_prescribed_velocity_parameters_that_contradict():
    for wrong, message in (
        ({}, "needs either faces or a region"),
        ({"faces": "xmin", "region": EVERYWHERE}, "needs either faces or a region"),
        ({"region": EVERYWHERE, "components": "normal"}, "a region has no normal"),
        ({"faces": "xmin", "moving": (1.0, 0.0)}, "moving needs a region"),
    ):
        with pytest.raises(mpm.ParameterError, match=message):
            PrescribedVelocity((1.0, 0.0), **wrong)


# --- tractions ----------------------------------------------------------------------------------------------------
LOADS = [
    lambda t, face: TractionLayer("block", t, face),
    lambda t, face: TractionLayer("block", t, face, thickness=0.125),
    lambda t, face: TwoPointTraction("block", t, face),
]
LOAD_IDS = ["layer of a cell", "layer of a particle", "two points"]
PULL = {"1D": (0.5,), "plane strain": (0.5, -0.2), "axisymmetric": (0.0, -0.2), "3D": (0.5, -0.2, 0.1)}


@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize("load", LOADS, ids=LOAD_IDS)
def test_force_of_a_traction(load, space):
    """Force = traction x initial area, whatever the body does meanwhile: the impulse of ten steps, to 1e-12 (rounding)."""
    g = grid(space)
    face = "ymax" if space == "axisymmetric" else "xmax"
    traction = np.array(PULL[space])
    v = tuple([0.4] * g.dim) if space != "axisymmetric" else (0.0, 0.4)
    body = mpm.Body(box(space, 0.5, 1.0), RUBBER, v, name="block")
    sim = simulation(g, body, load(tuple(traction), face), shape=Linear() if space == "3D" else None, integrator=MUSL(dt=0.01))
    before = sim.particles()["x"]
    run(sim, 0.1)
    area = {"1D": 1.0, "plane strain": 0.5, "3D": 0.25, "axisymmetric": np.pi * (2.0**2 - 1.5**2)}[space]
    history = sim.history
    for a, t in zip("xyz", traction, strict=False):
        assert abs(history[f"force_impulse_{a}"][-1] - t * area * 0.1) < 1e-12 * area * 0.05
    p = sim.particles()
    momentum = (p["m"][:, None] * (p["v"] - np.array(v))).sum(axis=0)
    axis = slice(1, 2) if space == "axisymmetric" else slice(None)  # hoop stress pushes rings outwards
    assert np.abs(momentum - traction * area * 0.1)[axis].max() < 1e-11 * area * 0.05
    assert np.abs(p["x"] - before).max() > 0.03
    assert abs(history["balance"][-1]) < 5e-3
    assert history["external_work"][-1] != 0.0


@pytest.mark.parametrize("shape", SHAPES, ids=named)
@pytest.mark.parametrize("load", LOADS, ids=LOAD_IDS)
def test_traction_moves_with_the_body(load, shape):
    """After cells have been crossed the same particles are pulled: the force on a flying block is what it was."""
    body = mpm.Body(mpm.Box((0.25, 0.25), (0.5, 0.5)), NeoHookean(E=10.0, nu=0.3, rho=1.0), (4.0, 2.0), name="block")
    sim = simulation(mpm.Grid((0.0, 0.0), (2.5, 1.5), 0.25), body, load((0.0, 0.3), "ymax"), shape=shape, integrator=MUSL(dt=0.01))
    run(sim, 0.3)
    half = sim.history["force_impulse_y"][-1]
    run(sim, 0.36)
    assert sim.particles()["x"][:, 0].min() > 1.5
    assert abs(half - 0.3 * 0.25 * 0.3) < 1e-12 * half
    assert abs(sim.history["force_impulse_y"][-1] - half - 0.3 * 0.25 * 0.06) < 1e-12 * half


def test_torque_of_a_traction():
    """The angular momentum after one step is the moment of the traction about the origin: at the boundary itself with two points,
    at the particles' centres with a layer. APIC and quadratic splines: exact to rounding (1e-11)."""
    traction, dt = np.array([0.3, 0.7]), 1e-4
    body = mpm.Body(mpm.Box((0.8, 0.6), (1.1, 1.0)), RUBBER, name="block", lattice="body")

    def moment(load):
        sim = run(simulation(grid("plane strain"), body, load, integrator=MUSL(APIC(), dt=dt)), dt)
        return sim.history["angular_z"][-1] / dt

    force, y = 0.4 * traction, 0.8
    exact = 1.1 * force[1] - y * force[0]
    assert abs(moment(TwoPointTraction("block", tuple(traction), "xmax")) / exact - 1.0) < 1e-11
    thin = moment(TractionLayer("block", tuple(traction), "xmax", thickness=0.1))  # one particle thick
    assert abs(thin / exact - 1.0) > 1e-3


def test_traction_of_a_formula_and_of_a_function():
    def grow(X, t):
        return (2.0 * t * X[1], 0.0)

    dt = 0.01
    body = mpm.Body(mpm.Box((0.5, 0.5), (1.0, 1.0)), RUBBER, name="block")
    for load in (TwoPointTraction("block", ("2*t*Y", 0.0), "xmax"), TractionLayer("block", grow, "xmax")):
        sim = run(simulation(grid("plane strain"), body, load, integrator=MUSL(dt=dt)), 0.1)
        wanted = 2.0 * (dt * np.arange(10)).sum() * dt * 0.75 * 0.5  # the mean of Y over the face is 0.75, its length 0.5
        assert abs(sim.history["force_impulse_x"][-1] / wanted - 1.0) < 1e-12


def test_traction_on_a_region():
    body = mpm.Body(mpm.Box((0.5, 0.5), (1.0, 1.0)), RUBBER, name="block")
    load = TractionLayer("block", (0.0, 1.0), region=mpm.Box((0.5, 0.75), (0.75, 1.0)), thickness=0.25)
    sim = run(simulation(grid("plane strain"), body, load, integrator=MUSL(dt=0.01)), 0.05)
    assert abs(sim.history["force_impulse_y"][-1] - 0.25 * 0.05) < 1e-14
    nowhere = TractionLayer("block", (0.0, 1.0), region=mpm.Box((1.5, 1.5), (1.75, 1.75)), thickness=0.25)
    with pytest.raises(mpm.CompositionError, match="no particle of body 'block' lies in the region"):
        simulation(grid("plane strain"), body, nowhere).run(until=0.1, quiet=True)
    thin = TractionLayer("block", (0.0, 1.0), "ymax", thickness=0.01)
    with pytest.raises(mpm.CompositionError, match=r"no particle lies within 0\.01 m of the face 'ymax'"):
        simulation(grid("plane strain"), body, thin).run(until=0.1, quiet=True)


def test_traction_layer_parameters_that_contradict():
    with pytest.raises(mpm.ParameterError, match="needs either a face or a region"):
        TractionLayer("block", (1.0, 0.0))
    with pytest.raises(mpm.ParameterError, match="thickness is required with a region"):
        TractionLayer("block", (1.0, 0.0), region=EVERYWHERE)


@pytest.mark.filterwarnings("ignore:1 particle.*USL")  # which makes energy with one particle per cell, in many more steps
@pytest.mark.parametrize("integrator", [MUSL, USF, USL], ids=lambda c: c.__name__)
@pytest.mark.parametrize("shape", [Linear(), QuadraticBSpline(), CubicBSpline()], ids=named)
def test_pulled_bar_stretches(integrator, shape):
    """The first wave through a bar pulled with t: stress t behind it, to 15 % (pinned: sixteen particles, ringing at the front),
    end velocity t / (rho c); work of the traction in the ledger to 3 %."""
    load = TwoPointTraction("bar", (0.01,), "xmax")
    sim = run(bar(load, Wall("xmin", condition="no slip"), n=16, shape=shape, integrator=integrator(FLIP(), cfl=0.5)), 0.8)
    p = sim.particles("bar")
    behind = p["x"][:, 0] > 0.5
    assert abs(p["stress"][behind, 0].mean() / 0.01 - 1.0) < 0.15
    row = {n: c[-1] for n, c in sim.history.items()}
    assert abs(row["external_work"] / (0.01 * 0.01 * 0.8) - 1.0) < 0.1
    assert abs(row["balance"]) < 0.03


def test_fem_takes_the_same_layers():
    """The same bar with finite elements, by another line."""
    load = TwoPointTraction("bar", (0.01,), "xmax")
    g = mpm.Grid(0.0, 1.5, 1 / 16, lateral="stress")
    body = mpm.Body(mpm.Box(0.0, 1.0), LinearElastic(E=1.0, nu=0.0, rho=1.0), name="bar")
    sim = run(simulation(g, body, load, Wall("xmin", condition="no slip"), discretization=FEM()), 0.8)
    p = sim.particles("bar")
    assert abs(p["stress"][p["x"][:, 0] > 0.5, 0].mean() / 0.01 - 1.0) < 0.15
    assert abs(sim.history["balance"][-1]) < 0.02
    assert abs(sim.history["force_impulse_x"][-1] - 0.01 * 0.8) < 1e-14
