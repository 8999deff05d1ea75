"""Generated code: nothing of what is absent, one text for all parameter values, never stale, found again by the next process."""

import json
import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from small_scenes import RUBBER, components, example, grid, simulation

import mpmkit as mpm
from mpmkit._core.composing.fingerprint import fingerprint
from mpmkit.boundaries import PrescribedVelocity, TractionLayer, TwoPointTraction, Wall
from mpmkit.contacts import FrictionalContact
from mpmkit.effects import BodyForce, Gravity
from mpmkit.fields import PARTICLE_FIELDS
from mpmkit.integrators import APIC, MUSL, PIC, USF, XPIC
from mpmkit.kernels import Kernel
from mpmkit.materials import HypoelasticJaumann, LinearElastic, NeoHookean, NewtonianFluid, VonMises
from mpmkit.shapes import GIMP, CubicBSpline, Linear

PLANE = grid("plane strain")


def scene(*parts, material=RUBBER, **more):
    body = mpm.Body(mpm.Box((0.5, 0.5), (1.0, 1.0)), material, name="bar")
    return simulation(PLANE, body, *parts, **more)


def plan_of(*parts, **more):
    return scene(*parts, **more).compose().plan


def layouts(plan):
    """What is stored, and where."""
    return plan.node_layout.start, [(g.name, g.layout.start, g.layout.size) for g in plan.composition.groups]


def names_in(component):
    """Everything a text could call it: its class, its kernels' functions and modules."""
    hooks = {n: getattr(component, n) for n in dir(component) if not n.startswith("_") and isinstance(getattr(component, n), Kernel)}
    functions = {k.function.__name__ for k in hooks.values()}
    return {type(component).__name__, *functions, type(component).__module__}


@pytest.fixture(autouse=True)
def plain(plain_python):
    """Only what runs in processes of its own is compiled."""


def unit_speed():
    return 1.0


# --- what is absent -----------------------------------------------------------------------------------------------
GIVEN = {
    TractionLayer: {"traction": (1.0, 0.0), "face": "xmax"},
    TwoPointTraction: {"traction": (1.0, 0.0)},
    PrescribedVelocity: {"faces": "xmin"},
}
"""What the examples of these need to fit into the scene."""


@pytest.mark.parametrize("cls", components("effect", "contact", "boundary"), ids=lambda c: c.__name__)
def test_absent_component_leaves_nothing(cls):
    component = example(cls, **GIVEN.get(cls, {}))
    before, present, after = plan_of(), plan_of(component), plan_of()
    assert any(re.search(rf"\b{name}\b", present.text) for name in names_in(component)), "the test would see nothing"
    for name in names_in(component):
        assert not re.search(rf"\b{name}\b", before.text)
    assert (after.text, after.digest) == (before.text, before.digest)
    assert layouts(after) == layouts(before)
    assert present.digest != before.digest
    (nodes, groups), (nodes_with, groups_with) = layouts(before), layouts(present)
    for absent, fields in ((nodes, nodes_with), (groups[0][1], groups_with[0][1])):
        assert set(absent) <= set(fields)
    for name in set(nodes_with) - set(nodes):
        assert not re.search(rf"\b{name}\b", before.text)
        assert cls.__name__ in present.node_layout.reasons[name]
    for name in set(groups_with[0][1]) - set(groups[0][1]):
        assert cls.__name__ in present.composition.groups[0].layout.reasons[name]
    assert len(before.text) < len(present.text)
    assert len(before.schedule.phases) <= len(present.schedule.phases)


def test_fields_of_transfers_and_shapes_are_there_only_with_them():
    def fields(**more):
        return plan_of(**more).composition.groups[0].layout.start

    assert "C" not in fields() and "C" in fields(integrator=MUSL(APIC()))
    assert "size" not in fields() and "size" in fields(shape=GIMP())
    assert "F" in fields() and "J" not in fields()
    fluid = fields(material=NewtonianFluid(rho=1.0, bulk_modulus=1.0, viscosity=0.1))
    assert "F" not in fluid and "J" in fluid and "viscous_loss" in fluid
    nodes = plan_of(integrator=MUSL(XPIC(3))).node_layout.start
    assert {"u", "u_next", "v_smooth"} <= set(nodes) and "u" not in plan_of().node_layout.start


def test_only_what_the_dimension_needs_is_stored():
    stored = {}
    for space in ("1D", "plane strain", "axisymmetric", "3D"):
        g = grid(space)
        body = mpm.Body(mpm.Box(tuple(x + 0.5 for x in g.lower), tuple(x + 1.0 for x in g.lower)), RUBBER)
        stored[space] = simulation(g, body).compose().plan.composition.groups[0].layout.size
    # x, v (dim each), m, V0, F; the stress follows from F
    assert stored == {"1D": 2 + 2 + 1, "plane strain": 4 + 2 + 4, "axisymmetric": 4 + 2 + 5, "3D": 6 + 2 + 9}


def test_stress_is_kept_only_if_it_does_not_follow_from_the_deformation():
    kept = {}
    for law in (RUBBER, VonMises(E=1e3, nu=0.3, rho=1.0, yield_stress=1.0), HypoelasticJaumann(E=1e3, nu=0.3, rho=1.0)):
        g = grid("plane strain")
        body = mpm.Body(mpm.Box(tuple(x + 0.5 for x in g.lower), tuple(x + 1.0 for x in g.lower)), law)
        kept[type(law).__name__] = "stress" in simulation(g, body).compose().plan.composition.groups[0].layout.fields
    assert kept == {"NeoHookean": False, "VonMises": True, "HypoelasticJaumann": True}


def test_state_of_a_law_may_have_any_name():
    """Also the name of any variable of the generated step: the results are those of a law with names of its own."""

    def run(names):
        text = f"def stress(F, mu, lam, {', '.join(names)}):\n    of_rubber = inner(F, lam, mu)\n    return of_rubber, {', '.join(f'{n} + {k}.0 + of_rubber[0]' for k, n in enumerate(names))}\n"
        space = {"inner": RUBBER.stress.function}
        exec(text, space)

        @mpm.define
        class Named(mpm.ConstitutiveModel):
            """A law with much state."""

            rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1.0)
            state = tuple(mpm.Field(n) for n in names)
            stress = mpm.kernel(space["stress"])
            wave_speed = mpm.kernel(unit_speed)
            energy = RUBBER.energy
            dissipation = mpm.kernel(eval(f"lambda {names[0]}: 1e-12 * {names[0]}"))
            lam, mu = RUBBER.lam, RUBBER.mu

        sim = scene(
            Wall("all", friction=0.1),
            Gravity((0.0, -1.0)),
            TractionLayer("bar", (1.0, 0.0), "xmax"),
            material=Named(rho=1.0),
            integrator=MUSL(APIC(), dt=1e-3),
        )
        sim.run(until=4e-3, quiet=True)
        plan = sim.compose().plan
        return plan, sim.history, sim.particles("bar")

    plan, history, particles = run(["alpha_1", "alpha_2", "alpha_3"])
    taken = sorted(set(re.findall(r"^ +(\w+) (?:\+|-)?= ", plan.text, re.MULTILINE)) - set(PARTICLE_FIELDS))
    assert len(taken) > 40
    for first in range(0, len(taken) - 2, 3):
        names = taken[first : first + 3]
        _, other_history, other = run(names)
        assert all(np.array_equal(history[n], other_history[n]) for n in history), names
        assert all(
            np.array_equal(particles[a], other[b])
            for a, b in zip(["x", "v", "alpha_1", "alpha_3"], ["x", "v", names[0], names[2]], strict=True)
        ), names


# --- parameter values ---------------------------------------------------------------------------------------------
def test_parameter_values_do_not_change_the_text():
    def plan(E, h, cells, integrator, friction, g, lower):
        body = mpm.Body(mpm.Box((lower + 2 * h,) * 2, (lower + 4 * h,) * 2), NeoHookean(E=E, nu=0.2, rho=E), name="bar")
        sim = simulation(
            mpm.Grid((lower, lower), (lower + cells * h, lower + 8 * h), h),
            body,
            Wall("all", friction=friction),
            Gravity(g),
            integrator=integrator,
        )
        return sim.compose().plan

    one = plan(1.0, 0.25, 8, MUSL(), 0.1, (0.0, -1.0), 0.0)
    two = plan(7e9, 1e-3, 16, MUSL(cfl=0.1), 0.7, (3.0, 0.0), -5.0)
    fixed = plan(7e9, 1e-3, 16, MUSL(dt=1e-9), 0.0, (0.0, 0.0), 0.0)
    assert one.text == two.text == fixed.text
    assert one.digest == two.digest == fixed.digest


def test_constant_and_formula_differ_in_text_but_two_constants_do_not():
    assert plan_of(BodyForce((1.0, 2.0))).digest == plan_of(BodyForce((3.0, -2.0))).digest
    assert plan_of(BodyForce(("x", "2*t"))).digest != plan_of(BodyForce((1.0, 2.0))).digest
    assert plan_of(BodyForce(("x", "2*t"))).digest == plan_of(BodyForce(("x", "2*t"))).digest
    assert plan_of(BodyForce(("x", "2*t"))).digest != plan_of(BodyForce(("x", "3*t"))).digest


@pytest.mark.parametrize(
    "more",
    [
        {"integrator": USF()},
        {"integrator": MUSL(PIC())},
        {"integrator": MUSL(strain="first-order")},
        {"shape": Linear()},
        {"shape": CubicBSpline()},
        {"precision": "float32"},
        {"material": VonMises(E=1.0, nu=0.3, rho=1.0, yield_stress=1.0)},
        {"material": NeoHookean(E=1.0, nu=0.3, rho=1.0, form="log")},
    ],
    ids=str,
)
def test_another_choice_is_another_digest(more):
    assert plan_of(**more).digest != plan_of().digest


def test_bodies_of_one_law_share_their_loops():
    def plan(*materials):
        bodies = [mpm.Body(mpm.Box((0.25 * k, 0.5), (0.25 * k + 0.25, 1.0)), m, name=f"b{k}") for k, m in enumerate(materials)]
        return simulation(PLANE, *bodies).compose().plan

    soft, hard = NeoHookean(E=1.0, nu=0.3, rho=1.0), NeoHookean(E=2.0, nu=0.1, rho=3.0)
    assert plan(soft, hard).text == plan(soft).text
    log = NeoHookean(E=1.0, nu=0.3, rho=1.0, form="log")
    names = [g.name for g in plan(soft, log, LinearElastic(E=1.0, nu=0.3, rho=1.0), log).composition.groups]
    assert names == ["NeoHookean", "NeoHookean_2", "LinearElastic"]


# --- fingerprints -------------------------------------------------------------------------------------------------
LAW = """
    import constants
    from helper import stiffness
    FACTOR = {factor}

    def stress(x, a):
        "{comment}"
        return stiffness(x) * a * FACTOR + constants.OFFSET {plus}
    """


def law(tmp_path, monkeypatch, *, factor=1.0, plus="", comment="", helper="2.0 * x", offset=0.0):
    """The function of a module written to disk and imported anew."""
    (tmp_path / "law.py").write_text(textwrap.dedent(LAW.format(factor=factor, plus=plus, comment=comment)))
    (tmp_path / "helper.py").write_text(f"def inner(x):\n    return {helper}\n\ndef stiffness(x):\n    return inner(x)\n")
    (tmp_path / "constants.py").write_text(f"OFFSET = {offset}\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    for name in ("law", "helper", "constants"):
        sys.modules.pop(name, None)
    import law

    made = fingerprint({"stress": law.stress})
    for name in ("law", "helper", "constants"):
        sys.modules.pop(name, None)
    return made


def test_fingerprint_follows_the_code_and_all_it_reaches(tmp_path, monkeypatch):
    first = law(tmp_path, monkeypatch)
    assert law(tmp_path, monkeypatch) == first
    assert law(tmp_path, monkeypatch, factor=2.0) != first  # a constant of its module
    assert law(tmp_path, monkeypatch, factor=1) != first  # of another type
    assert law(tmp_path, monkeypatch, plus="+ 1.0") != first  # its own code
    assert law(tmp_path, monkeypatch, helper="3.0 * x") != first  # a function behind a function in another module
    assert law(tmp_path, monkeypatch, offset=1.0) != first  # a constant reached as an attribute of a module


def test_fingerprint_of_closures():
    def made(a):
        def f(x):
            return a * x

        return f

    assert fingerprint({"f": made(1.0)}) == fingerprint({"f": made(1.0)}) != fingerprint({"f": made(2.0)})
    assert fingerprint({"f": made(1.0)}) != fingerprint({"f": made(1.0)}, "text")


# --- explain ------------------------------------------------------------------------------------------------------
def test_explain_shows_the_step():
    sim = scene(Wall("all"), Gravity((0.0, -1.0)), integrator=MUSL(APIC(), cfl=0.3))
    explanation = sim.explain()
    text = str(explanation)
    assert "QuadraticBSpline() · MUSL(cfl=0.3, transfer=APIC()) in plane strain, 8 x 8 cells, 16 particles, float64" in text
    phases = [line.split()[1] for line in text.split("\n") if re.match(r" +\d+ ", line)]
    assert phases == ["particles", "nodes", "boundary", "particles", "nodes", "boundary", "particles"]
    assert re.search(r"nodes +momentum +MUSL, Gravity", text)
    assert re.search(r"particles +advect, strain, stress +QuadraticBSpline, NeoHookean", text)
    assert re.search(r"C +32 B +APIC", text) and re.search(r"stress +0 B +computed where it is asked for", text)
    assert "off (no field, no line, no time): ArtificialViscosity, BodyForce, Damping, FrictionalContact" in text
    assert "h / (c + |v| + |C| h)" in text and "body 'bar'" in text
    assert sim.compose().plan.text == Path(text.rsplit("generated step: ", 1)[1]).read_text()
    data = explanation.data
    assert json.loads(json.dumps(data)) == data
    assert data["particles"] == {"bar": 16}
    assert data["particle fields"]["NeoHookean"]["x"] == {"components": 2, "bytes": 16, "for": ["MUSL"]}


def test_explain_after_a_run_shows_shares():
    sim = scene(Gravity((0.0, -1.0)))
    assert "%" not in str(sim.explain())
    sim.run(until=0.02, quiet=True)
    shares = [float(s) for s in re.findall(r"([\d.]+)%", str(sim.explain()))]
    assert 50.0 < sum(shares) <= 100.5


def test_explain_with_contact_and_float32():
    second = mpm.Body(mpm.Box((1.25, 0.5), (1.5, 1.0)), RUBBER, name="other")
    text = str(scene(second, FrictionalContact(), precision="float32").explain())
    assert "one set for each of 2 bodies" in text and "contact" in text and "float32" in text
    assert re.search(r"x +8 B", text)
    assert "off (no field, no line, no time): ArtificialViscosity, BodyForce, Damping, Gravity\n" in text


def test_explain_is_data_for_notebooks():
    html = scene().explain()._repr_html_()
    assert html.startswith("<pre>") and "advect, strain, stress" in html


def test_generated_text_is_python_and_names_its_functions():
    plan = plan_of(Wall("all", friction=0.2), PrescribedVelocity(("t", 0.0), "xmax"))
    compile(plan.text, "step", "exec")
    for name, function in plan.names.functions.items():
        assert re.search(rf"    {name} = {re.escape(function.__module__)}", plan.text)


# --- processes of their own ---------------------------------------------------------------------------------------
CHILD = """
    import json, sys, warnings
    warnings.simplefilter("always")
    import numpy as np
    import mpmkit as mpm
    from mpmkit.integrators import MUSL, PIC
    from mpmkit.shapes import Linear
    from squeeze import Squeeze

    sim = mpm.Simulation(mpm.Grid(0.0, 2.0, 0.25), shape=Linear(), integrator=MUSL(PIC(), dt=0.01))
    sim += mpm.Body(mpm.Box(0.5, 1.0), Squeeze(rho=1.0), lambda x: np.sin(7.0 * x))
    sim.run(until=0.2, quiet=True)
    plan = sim.compose().plan
    found = {n: f.stats for n, f in vars(plan.module).items() if hasattr(f, "stats") and f.py_func.__module__ == plan.module.__name__}
    used = [s for s in found.values() if s.cache_hits or s.cache_misses]
    out = {
        "digest": plan.digest,
        "file": plan.module.__file__,
        "hits": sum(sum(s.cache_hits.values()) for s in used),
        "misses": sum(sum(s.cache_misses.values()) for s in used),
        "state": {n: a.tolist() for n, a in sim.particles().items()},
        "steps": sim.step_number,
    }
    print(json.dumps(out))
    """

PLUGIN = """
    import mpmkit as mpm
    from modulus import modulus

    @mpm.kernel
    def stress(J):
        return (modulus() * {law}, 0.0, 0.0, 0.0, 0.0, 0.0)

    @mpm.kernel
    def speed():
        return 1.5

    @mpm.define
    class Squeeze(mpm.ConstitutiveModel):
        "A law in a file of its own."
        rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1.0)
        stress = stress
        wave_speed = speed
    """


@pytest.fixture(scope="module")
def child(tmp_path_factory):
    """Runs the scene of CHILD, compiled, in a process of its own with a law written for the occasion."""
    folder = tmp_path_factory.mktemp("child")

    def run(law="(J - 1.0)", modulus="1.0", **environment):
        (folder / "squeeze.py").write_text(textwrap.dedent(PLUGIN.format(law=law)))
        (folder / "modulus.py").write_text(f"def modulus():\n    return {modulus}\n")
        more = {
            "PYTHONPATH": str(folder),
            "PYTHONDONTWRITEBYTECODE": "1",
            "MPMKIT_CACHE_DIR": str(folder / "cache"),
            "NUMBA_DISABLE_JIT": "0",
        }
        done = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(CHILD)],
            env=os.environ | more | environment,
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout) | {"stderr": done.stderr}

    return run


@pytest.fixture(scope="module")
def first(child):
    """What the first process finds: nothing compiled."""
    return child()


def scaled_difference(a, b):
    """Largest difference of all fields, relative to each field's largest value."""
    assert a.keys() == b.keys()
    pairs = [(np.array(a[n]), np.array(b[n])) for n in a]
    return max(np.abs(x - y).max() / max(np.abs(x).max(), 1e-300) for x, y in pairs)


def test_second_process_compiles_nothing(child, first):
    assert first["hits"] == 0 and first["misses"] >= 5
    again = child()
    assert again["digest"] == first["digest"]
    assert again["misses"] == 0 and again["hits"] >= 5  # functions that others have taken in are not looked up
    assert again["state"] == first["state"]  # to the bit


def test_compiled_and_plain_agree(child, first):
    plain = child(NUMBA_DISABLE_JIT="1")
    assert plain["hits"] == plain["misses"] == 0
    assert plain["steps"] == first["steps"] >= 20
    # rounding: some machine epsilons of each field's size, for each of 20 steps
    assert 0.0 < scaled_difference(first["state"], plain["state"]) + 1e-300 < 20 * 50 * np.finfo(float).eps


def test_edited_components_are_never_served_stale(child, first):
    """A kernel, then a helper function in another file: the results follow, also back to the first edition, which is still there."""
    plain = {"NUMBA_DISABLE_JIT": "1"}
    for edit in ({"law": "(J - 1.0) * J"}, {"modulus": "2.0"}):
        edited, truth = child(**edit), child(**edit, **plain)
        assert edited["digest"] != first["digest"]
        assert edited["misses"] > 0
        assert scaled_difference(edited["state"], first["state"]) > 1e-4
        assert scaled_difference(edited["state"], truth["state"]) < 20 * 50 * np.finfo(float).eps  # rounding, as above
    back = child()
    assert back["digest"] == first["digest"] and back["misses"] == 0
    assert back["state"] == first["state"]


def test_cache_folder_that_cannot_be_written(child, first, tmp_path):
    """One line of notice, then a folder of this process."""
    (tmp_path / "file").write_text("not a folder")
    there = tmp_path / "file" / "cache"
    found = child(MPMKIT_CACHE_DIR=str(there), XDG_CACHE_HOME=str(there), NUMBA_DISABLE_JIT="1")
    notices = [line for line in found["stderr"].splitlines() if "cache folder" in line and "UserWarning" in line]
    assert len(notices) == 1 and "not writable" in notices[0] and "for this process only" in notices[0]
    assert str(there) not in found["file"]
    assert scaled_difference(found["state"], first["state"]) < 20 * 50 * np.finfo(float).eps  # rounding, as above
    assert "cache folder" not in first["stderr"]
