"""What cannot work is refused before the first step, with who, what and the remedy."""

import numpy as np
import pytest
from small_scenes import RUBBER, bar, grid, simulation

import mpmkit as mpm
from mpmkit.boundaries import PrescribedVelocity, Symmetry, TractionLayer, TwoPointTraction, Wall
from mpmkit.contacts import FrictionalContact
from mpmkit.discretizations import FEM
from mpmkit.effects import BodyForce, Damping, Gravity
from mpmkit.integrators import APIC, FLIP, MUSL, TPIC, USF, USL, XPIC
from mpmkit.interfaces.integrator import ExplicitIntegrator
from mpmkit.materials import HypoelasticJaumann, LinearElastic, NeoHookean, NewtonianFluid, VonMises
from mpmkit.shapes import GIMP, ContiguousGIMP, CubicBSpline, Linear, QuadraticBSpline

pytestmark = pytest.mark.usefixtures("plain_python")

PLANE = grid("plane strain")
STRIP = grid("1D")


def block(name="block", low=0.5, high=1.0, dim=2, **more):
    return mpm.Body(mpm.Box((low,) * dim, (high,) * dim), more.pop("material", RUBBER), name=name, **more)


def refused(sim, *fragments, error=mpm.CompositionError):
    """The composition is refused, once and again, and the message holds all fragments."""
    for _ in range(2):
        with pytest.raises(error) as caught:
            sim.compose()
        for fragment in fragments:
            assert fragment in str(caught.value)


# --- what is doubtful ---------------------------------------------------------------------------------------------
def test_negative_weights_are_warned_of():
    declared = type("Wavy", (QuadraticBSpline,), {"positive": False})()
    with pytest.warns(UserWarning, match="Wavy has negative weights: .* momentum is lost. To fix: .* QuadraticBSpline"):
        simulation(PLANE, block(), shape=declared).compose()


# --- what must be there -------------------------------------------------------------------------------------------
def test_no_body():
    refused(simulation(PLANE, Wall("all")), "no body", "sim += mpm.Body(geometry, material)")


def test_mpm_needs_a_shape_and_an_integrator():
    with pytest.raises(mpm.CompositionError, match="needs shape and integrator, for example shape="):
        mpm.Simulation(PLANE)
    with pytest.raises(mpm.CompositionError, match="needs integrator, for example integrator="):
        mpm.Simulation(PLANE, shape=Linear())


def test_classes_in_place_of_components():
    with pytest.raises(mpm.ParameterError, match=r"shape must be a ShapeFunction.*call it: Linear\(\)"):
        mpm.Simulation(PLANE, shape=Linear, integrator=MUSL())
    with pytest.raises(mpm.ParameterError, match=r"Body.material must be a ConstitutiveModel, got .*NeoHookean"):
        block(material=NeoHookean)
    with pytest.raises(mpm.CompositionError, match="cannot add.*Gravity"):
        simulation(PLANE, Gravity)


def test_components_in_the_wrong_place():
    with pytest.raises(mpm.CompositionError, match=r"cannot add.*give it to Simulation\(\.\.\.\)"):
        simulation(PLANE, QuadraticBSpline())
    with pytest.raises(mpm.ParameterError, match="Simulation.grid must be a Grid"):
        mpm.Simulation((0, 1), shape=Linear(), integrator=MUSL())
    with pytest.raises(mpm.ParameterError, match="did you mean 'float32'"):
        simulation(PLANE, precision="flota32")


def test_nothing_is_added_to_a_composed_simulation():
    sim = simulation(PLANE, block())
    sim.compose()
    with pytest.raises(mpm.CompositionError, match="cannot add Gravity.*already composed"):
        sim += Gravity((0.0, -1.0))
    assert not sim.effects


def test_two_bodies_of_one_name():
    with pytest.raises(mpm.CompositionError, match="two bodies are named 'block'"):
        simulation(PLANE, block(), block(low=1.0, high=1.5))


# --- who does not fit to whom -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "layer",
    [
        Wall("zmin"),
        Symmetry(("xmin", "zmin")),
        PrescribedVelocity((0.0, 0.0), "zmin"),
        TractionLayer("block", (1.0, 0.0), "zmin"),
        TwoPointTraction("block", (1.0, 0.0), "zmin"),
    ],
    ids=lambda layer: type(layer).__name__,
)
def test_unknown_face_in_this_dimension(layer):
    refused(simulation(PLANE, block(), layer), type(layer).__name__, "'zmin'", "xmin, xmax, ymin, ymax", "2D")


@pytest.mark.parametrize("shape", [GIMP(), ContiguousGIMP()], ids=str)
def test_shape_that_knows_no_rings(shape):
    sim = simulation(grid("axisymmetric"), mpm.Body(mpm.Box((1.5, 0.5), (2.0, 1.0)), RUBBER), shape=shape)
    refused(sim, type(shape).__name__, "axisymmetric", "Linear", "QuadraticBSpline")


def test_axis_needs_symmetry():
    g = mpm.Grid((0.0, 0.0), (1.0, 1.0), 0.25, coordinates="axisymmetric")
    body = mpm.Body(mpm.Box((0.0, 0.25), (0.5, 0.75)), RUBBER)
    for layers in (
        (),
        (Wall("all"),),
        (Wall("xmin"),),
        (Wall("xmin", condition="slip"),),
        (PrescribedVelocity((0.0, 1.0), "xmin", components="tangential"),),
    ):
        refused(simulation(g, body, *layers), "r = 0", "Symmetry('xmin')")
    simulation(g, body, Wall("all"), Symmetry("xmin")).compose()


@pytest.mark.parametrize("material", [RUBBER, NewtonianFluid(rho=1.0, bulk_modulus=1.0, viscosity=0.0)], ids=lambda m: type(m).__name__)
def test_law_without_uniaxial_stress(material):
    g = mpm.Grid(0.0, 2.0, 0.25, lateral="stress")
    refused(simulation(g, block(dim=1, material=material)), type(material).__name__, "uniaxial stress", "lateral='strain'")


def test_one_contact_algorithm():
    refused(
        simulation(PLANE, block(), FrictionalContact(), FrictionalContact(friction=0.1)),
        "one contact algorithm",
        "FrictionalContact, FrictionalContact",
    )


@pytest.mark.parametrize("layer", [TractionLayer, TwoPointTraction], ids=lambda c: c.__name__)
def test_load_of_an_unknown_body(layer):
    refused(
        simulation(PLANE, block("hammer"), layer("hamer", (0.0, 1.0), "xmin")),
        f"{layer.__name__}.body",
        "'hamer'",
        "did you mean 'hammer'?",
    )


@pytest.mark.parametrize(
    ("part", "name"),
    [
        (Gravity((0.0, 0.0, -9.81)), "Gravity.g"),
        (Gravity(-9.81), "Gravity.g"),
        (BodyForce((1.0,)), "BodyForce.value"),
        (BodyForce("x"), "BodyForce.value"),
        (PrescribedVelocity((1.0, 0.0, 0.0), "xmin"), "PrescribedVelocity.velocity"),
        (PrescribedVelocity((0.0, 0.0), region=mpm.Box((0.0, 0.0), (1.0, 1.0)), moving=(1.0,)), "PrescribedVelocity.moving"),
        (TractionLayer("block", (1.0, 0.0, 0.0), "xmin"), "TractionLayer.traction"),
    ],
)
def test_vector_of_the_wrong_length(part, name):
    sim = simulation(PLANE, block(), part)
    refused(sim, name, "2 component", error=mpm.MpmkitError)


def test_zero_is_a_vector_of_any_length():
    simulation(PLANE, block(), PrescribedVelocity(0.0, "xmin"), BodyForce(0.0)).compose()


# --- order of a recipe --------------------------------------------------------------------------------------------
@mpm.define
class Restless(ExplicitIntegrator):
    """USL that moves the particles before the conditions that the strain sees."""

    references = ("none",)
    transfer: mpm.Transfer = mpm.parameter("how particle velocities follow from the grid", default=FLIP())
    between: bool = mpm.parameter("whether something keeps advect and strain from being one loop", default=True)

    def step(self, s):
        s.p2g()
        s.forces()
        s.momentum()
        s.g2p()
        s.advect()
        if self.between:
            s.boundary()
        s.strain()
        s.stress()


def test_particles_move_last():
    # the arenas of nodes hold what particles can reach until they are sorted, at the start of a step
    sim = simulation(PLANE, block(), Wall("all"), integrator=Restless())
    refused(sim, "Restless", "advect() and then visits nodes again in strain, stress")
    simulation(PLANE, block(), Wall("all"), integrator=Restless(between=False)).compose()


# --- consistent mass ----------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("integrator", "parts", "reason"),
    [
        (MUSL(mass="consistent"), [FrictionalContact()], "contact"),
        (USF(mass="consistent"), [], "USF"),
        (USL(mass="consistent"), [], "USL"),
        (MUSL(XPIC(2), mass="consistent"), [], "XPIC"),
        (MUSL(APIC(), mass="consistent"), [], "APIC"),
        (MUSL(TPIC(), mass="consistent"), [], "TPIC"),
        (MUSL(mass="consistent"), [Wall("xmin")], "separate"),
        (MUSL(mass="consistent"), [Wall("xmin", friction=0.1)], "Wall"),
        (MUSL(mass="consistent"), [PrescribedVelocity((0.0, 0.0), region=mpm.Box((0.0, 0.0), (1.0, 1.0)))], "region"),
    ],
)
def test_consistent_mass_refuses(integrator, parts, reason):
    refused(simulation(PLANE, block(), *parts, integrator=integrator), "mass='consistent'", reason, "lumped")


@pytest.mark.parametrize(
    ("low", "v", "meets"), [(0.0, "0.1*x", False), (0.0, 0.1, True), (0.5, -0.1, True), (0.25, 0.0, True), (0.5, 0.1, False)]
)
def test_consistent_mass_and_bodies_that_meet_a_held_plane(low, v, meets):
    """Quadratic splines reach 1.5 cells of 0.25: what is at rest at the plane, or moves away from it, is fine."""
    body = mpm.Body(mpm.Box(low, low + 1.0), LinearElastic(E=1.0, nu=0.0, rho=1.0), v, name="bar")
    sim = simulation(mpm.Grid(0.0, 2.0, 0.25), body, Symmetry("xmin"), integrator=MUSL(mass="consistent"))
    if meets:
        refused(sim, "mass='consistent'", "body 'bar' would meet Symmetry on 'xmin' in motion", "mass='lumped'")
    else:
        sim.compose()


def test_consistent_mass_with_damping_is_refused_before_the_first_step():
    sim = simulation(PLANE, block(), Damping(1.0), integrator=MUSL(mass="consistent"))
    with pytest.raises(mpm.CompositionError, match="Damping"):
        sim.run(until=1.0, quiet=True)


def test_consistent_mass_is_for_small_problems(monkeypatch):
    from mpmkit._core.running import consistent

    monkeypatch.setattr(consistent, "LARGEST", 3)
    with pytest.raises(mpm.CompositionError, match=r"up to 3 occupied nodes; this scene has \d+.*lumped"):
        simulation(PLANE, block(), integrator=MUSL(mass="consistent")).run(until=1.0, quiet=True)


# --- FEM ----------------------------------------------------------------------------------------------------------
def test_fem_brings_its_own_method():
    for more in ({"shape": Linear()}, {"integrator": MUSL()}):
        sim = mpm.Simulation(STRIP, discretization=FEM(), **more)
        sim += block(dim=1)
        refused(sim, "FEM brings its own shape functions")


def test_fem_has_no_contact():
    refused(simulation(PLANE, block(), FrictionalContact(), discretization=FEM()), "FEM does not offer contact", "FrictionalContact")


@pytest.mark.parametrize("space", ["axisymmetric", "3D"])
def test_fem_knows_bars_and_plane_strain(space):
    g = grid(space)
    body = mpm.Body(mpm.Box(tuple(x + 0.5 for x in g.lower), tuple(x + 1.0 for x in g.lower)), RUBBER)
    refused(simulation(g, body, discretization=FEM()), "FEM (discretization)", space, "1D, plane strain")


# --- fields -------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("field", "near"), [("stres", "; did you mean 'stress'?"), ("temperature", ""), ("C", "")])
def test_record_of_an_unknown_field(tmp_path, field, near):
    sim = simulation(PLANE, block(), mpm.Record(tmp_path / "run.vtkhdf", fields=("x", field)))
    with pytest.raises(mpm.FieldContractError, match=rf"body 'block' has no field '{field}'") as caught:
        sim.run(until=0.1, quiet=True)
    assert near in str(caught.value)
    assert "it has" in str(caught.value)


def test_record_of_a_field_of_some_bodies(tmp_path):
    """A state that only one law carries cannot be a column of all particles."""
    metal = block("metal", material=VonMises(E=100.0, nu=0.3, rho=1.0, yield_stress=1.0))
    sim = simulation(PLANE, metal, block("rubber", 1.25, 1.5), mpm.Record(tmp_path / "run.vtkhdf", fields=("x", "eps_p")))
    with pytest.raises(mpm.FieldContractError, match="body 'rubber' has no field 'eps_p'"):
        sim.run(until=0.1, quiet=True)


@mpm.kernel
def asks_too_much(F, mu, lam, temprature):
    return (temprature, 0.0, 0.0, 0.0, 0.0, 0.0)


@mpm.kernel
def unit_speed():
    return 1.0


@mpm.define
class Thermal(mpm.ConstitutiveModel):
    """Asks for a name that nobody supplies."""

    rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1.0)
    temperature: float = mpm.parameter("of all points", unit="K", default=300.0)
    mu = lam = 1.0
    stress = asks_too_much
    wave_speed = unit_speed


def test_kernel_asks_for_an_unknown_name():
    refused(
        simulation(PLANE, block(material=Thermal(rho=1.0))),
        "Thermal", "'stress'", "'temprature'", "did you mean 'temperature'?", error=mpm.FieldContractError,
    )  # fmt: skip


@mpm.kernel
def needs_gap(v, gap):
    return (gap * v[0], v[1], v[2])


@mpm.define
class Leaky(mpm.BoundaryLayer):
    """A layer on nodes that asks for what only contact knows."""

    constrain = needs_gap

    def faces_of(self, grid):
        return ("xmin",)


def test_layer_asks_for_an_unknown_name():
    refused(simulation(PLANE, block(), Leaky()), "Leaky", "'gap'", error=mpm.FieldContractError)


# --- bodies in the domain -----------------------------------------------------------------------------------------
def test_body_outside_the_domain():
    refused(simulation(PLANE, block(low=1.75, high=2.25)), "body 'block'", "outside")
    cloud = mpm.Body.from_arrays([[0.5, 0.5], [0.5, 2.5]], 0.01, RUBBER, name="cloud")
    refused(simulation(PLANE, cloud), "body 'cloud'", "1 of 2 particles", "(0.5, 2.5)", "enlarge the grid")


def test_body_without_a_particle():
    refused(simulation(PLANE, mpm.Body(mpm.Disk((1.0, 1.0), 0.01), RUBBER, name="dot")), "body 'dot'", "particle")


def test_body_of_another_dimension():
    refused(simulation(PLANE, block(dim=3)), "3 dimensions", "the grid has 2")


def test_overlapping_bodies_warn():
    sim = simulation(PLANE, block("a"), block("b", 0.75, 1.25))
    with pytest.warns(UserWarning, match="'a' and 'b' overlap"):
        sim.compose()
    assert "overlap" in str(sim.explain())


def test_touching_bodies_do_not_warn():
    assert not simulation(PLANE, block("a"), block("b", 1.0, 1.5)).compose().warnings  # warnings are errors here


def test_particles_larger_than_the_shape_function_reaches():
    big = mpm.Body.from_arrays([[0.75, 0.75]], 0.25, RUBBER, size=(0.25, 0.25), name="big")
    refused(simulation(PLANE, big, shape=GIMP()), "body 'big'", "2 cells wide", "GIMP allows 1", "more particles per cell")
    with pytest.warns(UserWarning, match="body 'big': particles are 2 cells wide"):
        simulation(PLANE, big, shape=Linear()).compose()
    simulation(mpm.Grid((0.0, 0.0), (2.0, 2.0), 0.5), big, shape=GIMP()).compose()


# --- initial state ------------------------------------------------------------------------------------------------
def test_initial_stress_of_a_law_that_does_not_keep_it():
    pressed = (-1.0, -1.0, -1.0, 0.0, 0.0, 0.0)
    refused(simulation(PLANE, block(stress=pressed)), "body 'block'", "NeoHookean", "stress", "F")
    rate = HypoelasticJaumann(E=100.0, nu=0.3, rho=1.0)
    kept = simulation(PLANE, block(stress=pressed, material=rate)).particles("block")["stress"]
    assert np.array_equal(kept, np.tile(pressed, (len(kept), 1)))


def test_initial_state_that_the_space_cannot_hold():
    sheared = np.eye(3)
    sheared[0, 2] = 0.1
    refused(simulation(PLANE, block(F=sheared)), "body 'block'", "F", "plane strain")
    stretched = np.diag([1.1, 1.1, 1.1])
    refused(simulation(PLANE, block(F=stretched)), "body 'block'", "F", "plane strain")
    simulation(grid("3D"), block(F=stretched, dim=3)).compose()


# --- time step ----------------------------------------------------------------------------------------------------
def test_fixed_time_step_above_the_limit():
    sim = bar(integrator=MUSL(dt=0.13))  # h / c = 0.125 s
    with pytest.raises(
        mpm.StabilityError, match=r"fixed dt = 0\.13 s is above the stable limit 0\.125 s at step 0.*body 'bar'.*dt <= 0\.1 s"
    ):
        sim.run(until=1.0, quiet=True)
    assert sim.step_number == 0
    assert bar(integrator=MUSL(dt=0.12)).run(until=0.12, quiet=True) is not None


def test_fixed_time_step_that_becomes_too_large():
    sim = bar(integrator=MUSL(dt=0.115), v=lambda x: 0.08 * x, room=2.0)  # stretched: the small-strain law gets faster
    with pytest.raises(mpm.StabilityError, match=r"above the stable limit .* at step [1-9]"):
        sim.run(until=50.0, quiet=True)


def test_a_run_needs_an_end():
    with pytest.raises(mpm.ParameterError, match=r"run\(until\) is required"):
        bar().run()
    for wrong in (0.0, -1.0, "3 kg", float("nan")):
        with pytest.raises(mpm.ParameterError, match=r"run\(until\)"):
            bar().run(until=wrong)


def test_precision_a_component_does_not_offer():
    @mpm.define
    class Exact(mpm.Effect):
        """Only in double precision."""

        precisions = ("float64",)
        acceleration = Gravity.acceleration
        g = (0.0, 0.0, 0.0)

    refused(simulation(PLANE, block(), Exact(), precision="float32"), "Exact works in float64 only", "float32")


@pytest.mark.parametrize("shape", [Linear(), QuadraticBSpline(), CubicBSpline(), GIMP(), ContiguousGIMP()], ids=str)
def test_what_is_offered_composes(shape):
    """The other side of all refusals."""
    for integrator in (MUSL(APIC()), USF(XPIC(3)), USL()):
        simulation(PLANE, block(), Wall("all"), Gravity((0.0, -1.0)), FrictionalContact(), shape=shape, integrator=integrator).compose()
    simulation(STRIP, block(dim=1, material=LinearElastic(E=1.0, nu=0.0, rho=1.0)), shape=shape).compose()
