"""Effects on demand: what is absent leaves no trace, what is there changes only the loops it acts in, and acts only where it must."""

from __future__ import annotations

import ast
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
from mpmkit._core.running.engine import Engine
from mpmkit.boundaries import PrescribedVelocity, TractionLayer, TwoPointTraction, Wall
from mpmkit.contacts import FrictionalContact
from mpmkit.effects import ArtificialViscosity, BodyForce, Damping, Gravity
from mpmkit.integrators import APIC, MUSL, USL
from mpmkit.materials import VonMises

PLANE = grid("plane strain")
OPTIONAL = components("effect", "contact", "boundary")
GIVEN = {
    TractionLayer: {"body": "bar", "traction": (1.0, 0.0), "face": "xmax"},
    TwoPointTraction: {"body": "bar", "traction": (1.0, 0.0), "face": "xmax"},
    PrescribedVelocity: {"faces": "xmin"},
}


@pytest.fixture(autouse=True)
def plain(plain_python):
    """Nothing here needs a compiler."""


def scene(*parts, **more):
    return simulation(PLANE, mpm.Body(mpm.Box((0.5, 0.5), (1.0, 1.0)), RUBBER, name="bar"), *parts, **more)


def plan_of(*parts, **more):
    return scene(*parts, **more).compose().plan


def fields(plan):
    """Fields of each material's particles and channels of the nodes, in their order."""
    return [list(g.layout.fields) for g in plan.composition.groups], list(plan.node_layout.start)


HELPERS = re.compile(r"\b(fetch|flush|gather|scatter)_\w+")
MOVES = re.compile(r"^ *transpose\(.*\n", re.MULTILINE)


def functions(plan):
    """Generated functions by name: without helpers for windows of a record, whose names are their sizes, and without places in memory.

    How many numbers of a window are moved between rows and lanes also follows from its size.
    """
    found = {n.name: ast.unparse(n) for n in ast.parse(plan.text).body if isinstance(n, ast.FunctionDef)}
    return {n: re.sub(r"\b\d+\b", "#", HELPERS.sub(r"\1", MOVES.sub("", text))) for n, text in found.items() if not HELPERS.match(n)}


# --- absent -------------------------------------------------------------------------------------------------------
PLUGINS = {cls.__module__.split(".")[0] for cls in OPTIONAL}
CHILD = """
    import sys

    class Nowhere:
        def find_spec(self, name, path=None, target=None):
            if name.split(".")[0] == {plugin!r}:
                raise ImportError("this installation does not have it")

    sys.meta_path.insert(0, Nowhere())
    import mpmkit as mpm
    from mpmkit._core.registry import registry
    from small_scenes import RUBBER, grid, simulation

    assert not any(e.component.__module__.startswith({plugin!r}) for e in registry().entries), "it is there after all"
    body = mpm.Body(mpm.Box((0.5, 0.5), (1.0, 1.0)), RUBBER, name="bar")
    plan = simulation(grid("plane strain"), body).compose().plan
    print(plan.digest)
    print([list(g.layout.fields) for g in plan.composition.groups], list(plan.node_layout.start))
    """


@pytest.mark.parametrize("plugin", sorted(PLUGINS))
def test_a_composition_without_it_is_that_of_an_installation_that_never_heard_of_it(plugin, tmp_path):
    (tmp_path / "scene.py").write_text(textwrap.dedent(CHILD.format(plugin=plugin)))
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": path}
    done = subprocess.run([sys.executable, str(tmp_path / "scene.py")], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    digest, stored = done.stdout.splitlines()
    plan = plan_of()
    assert digest == plan.digest  # text, and the code of every function it calls
    layouts = fields(plan)
    assert stored == f"{layouts[0]} {layouts[1]}"


def test_records_are_no_part_of_the_step(tmp_path):
    plan = plan_of(mpm.Record(str(tmp_path / "a.vtkhdf"), every=0.1, history=1, fields=("x", "v", "stress", "F", "J", "rho")))
    assert (plan.text, plan.digest, fields(plan)) == (plan_of().text, plan_of().digest, fields(plan_of()))


# --- present ------------------------------------------------------------------------------------------------------
FIELDS = {"ArtificialViscosity": ["q"]}
CHANNELS = {
    "FrictionalContact": ["outward", "v_map"],
    "BodyForce": ["f_ext"],
    "TractionLayer": ["f_ext"],
    "TwoPointTraction": ["f_ext"],
}
CONTACT = ["find_shared", "mark_shared", "clear_shared", "near_shared", "contact_normals", "choose_normals", "contact_v", "node_of"]
CONTACT += ["reach_NeoHookean", "outward_NeoHookean", "outward_NeoHookean_tile"]
ADDED = {
    "FrictionalContact": CONTACT,
    "TractionLayer": ["load_TractionLayer_NeoHookean", "node_of"],
    "TwoPointTraction": ["load_TwoPointTraction_NeoHookean", "node_of"],
    "Wall": ["Wall_v"],
    "Symmetry": ["Symmetry_v"],
    "PrescribedVelocity": ["PrescribedVelocity_v"],
}
# p2g_forces: what a particle gives to the nodes; momentum: nodes; g2p: what it takes, and the work of external forces
CHANGED = {
    "ArtificialViscosity": {"stress", "initial", "p2g_forces"},
    "BodyForce": {"p2g_forces", "momentum", "g2p"},
    "Damping": {"momentum"},
    "Gravity": {"momentum"},
    "FrictionalContact": set(),
    "TractionLayer": {"momentum", "g2p"},
    "TwoPointTraction": {"momentum", "g2p"},
    "Wall": set(),
    "Symmetry": set(),
    "PrescribedVelocity": set(),
}
"""Loops that each component changes. One that is not here fails below: say where it acts."""
LOOPS = {
    "musl": {"g2p": "g2p_remap", "stress": "advect_strain_stress"},
    "usl": {"g2p": "g2p_advect_strain_stress", "stress": "g2p_advect_strain_stress"},
}


def without_windows(text):
    return re.sub(r"(fetch|flush)_\d+_\d+", r"\1", text)


@pytest.mark.parametrize("integrator", [MUSL(), USL(APIC(), limit=0.0)], ids=["musl", "usl"])
@pytest.mark.parametrize("cls", OPTIONAL, ids=lambda c: c.__name__)
def test_a_component_changes_only_the_loops_it_acts_in(cls, integrator):
    name, recipe = cls.__name__, type(integrator).__name__.lower()
    without, with_it = plan_of(integrator=integrator), plan_of(example(cls, **GIVEN.get(cls, {})), integrator=integrator)
    before, after = functions(without), functions(with_it)
    assert set(before) <= set(after), "nothing goes away"
    maps = {f"{n}_map" for n in ("contact_v", f"{name}_v") if n in after} if recipe == "musl" else set()
    assert set(after) - set(before) == {*ADDED.get(name, []), *maps}
    wanted = {LOOPS[recipe].get(loop, loop) for loop in CHANGED[name]}
    computations = {n.removesuffix("_NeoHookean_tile") for n in before if n.endswith("_tile") or n == "momentum"}
    changed = {n.removesuffix("_NeoHookean_tile") for n in before if after[n] != before[n] and not n.endswith("_NeoHookean")}
    assert changed == wanted and wanted <= computations
    # around the computation: reductions of what it keeps account of, of the same loops; a further channel may shift the record of a node
    around = {n for n in before if n.endswith("_NeoHookean") and without_windows(after[n]) != without_windows(before[n])}
    assert {n.removesuffix("_NeoHookean") for n in around} - {"cycle"} <= wanted
    (old, old_nodes), (new, new_nodes) = fields(without), fields(with_it)
    assert new[0] == old[0] + FIELDS.get(name, [])
    assert sorted(new_nodes) == sorted({*old_nodes, *(c for c in CHANNELS.get(name, []) if c != "v_map")})


INERT = {
    "ArtificialViscosity": {"linear": 0.0, "quadratic": 0.0},
    "BodyForce": {"force": (0.0, 0.0)},
    "Damping": {"rate": 0.0},
    "Gravity": {"g": (0.0, 0.0)},
    "FrictionalContact": {"friction": 0.0},
    "TractionLayer": {"traction": (0.0, 0.0)},
    "TwoPointTraction": {"traction": (0.0, 0.0)},
}


@pytest.mark.parametrize("cls", [c for c in OPTIONAL if c.__name__ in INERT], ids=lambda c: c.__name__)
def test_an_inert_instance_is_not_dropped(cls):
    """Whoever writes it gets the step with it: values are read at run time, nothing guesses what was meant."""
    import attrs

    values = INERT[cls.__name__]
    names = [a.name for a in attrs.fields(cls)]
    given = {n if n in names else names[0]: v for n, v in values.items()}
    inert = plan_of(cls(**(GIVEN.get(cls, {}) | given)))
    assert inert.text == plan_of(example(cls, **GIVEN.get(cls, {}))).text != plan_of().text


def test_history_fields_are_those_of_the_own_material():
    steel = VonMises(E=100.0, nu=0.3, rho=1.0, yield_stress=1.0)
    bodies = [mpm.Body(mpm.Box((low, 0.5), (low + 0.5, 1.0)), m, name=m.__class__.__name__) for low, m in ((0.25, RUBBER), (1.0, steel))]
    plan = simulation(PLANE, *bodies, ArtificialViscosity()).compose().plan
    rubber, metal = (g.layout for g in plan.composition.groups)
    state = [f.name for f in steel.state]
    assert state and not set(state) & set(rubber.fields) and set(state) <= set(metal.fields)
    alone = [simulation(PLANE, b, ArtificialViscosity()).compose().plan.composition.groups[0].layout for b in bodies]
    assert [alone[0].start, alone[1].start] == [rubber.start, metal.start], "each body stores what it would store alone"
    texts = functions(plan)
    for name in state:
        assert not any(re.search(rf"\bstate_{name}\b", text) for n, text in texts.items() if "NeoHookean" in n)
        assert any(re.search(rf"\bstate_{name}\b", text) for n, text in texts.items() if "VonMises" in n)


# --- only where it acts -------------------------------------------------------------------------------------------
def test_energies_are_summed_in_the_loop_of_the_ledger_alone():
    texts = functions(plan_of(ArtificialViscosity(), Gravity((0.0, -1.0)), FrictionalContact(), Wall("all")))
    assert {n for n, text in texts.items() if "NeoHookean_energy" in text} == {"ledger_NeoHookean_tile"}


def test_the_ledger_is_summed_at_rows_that_are_recorded(tmp_path, monkeypatch):
    calls = []
    ledger = Engine.ledger
    monkeypatch.setattr(Engine, "ledger", lambda engine: calls.append(engine.step_number) or ledger(engine))
    sim = scene(mpm.Record(str(tmp_path / "run.vtkhdf"), every=0.03, history=20), integrator=MUSL(dt=1e-3))
    sim.run(until=0.05, quiet=True)
    rows = [0, 20, 30, 40, 50]  # the start, every 20 steps, the frame at 0.03 s, the end
    # beside them the alarm looks at the energy: after each of the first 20 steps and then every 10
    assert calls == sorted({*rows, *range(21), *range(20, 51, 10)})
    assert sim.history["step"].tolist() == rows


def counted(monkeypatch, sim, until):
    """How often the functions of contact and its kernel are called in a run."""
    module = sim.compose().plan.load()
    calls = dict.fromkeys((n for n in vars(module) if n.startswith(("contact_", "reach_")) and not n.endswith("_tile")), 0)

    def wrapped(name, function):
        def call(*arguments):
            calls[name] += 1
            return function(*arguments)

        return call

    for name in calls:
        monkeypatch.setattr(module, name, wrapped(name, getattr(module, name)))
    sim.run(until=until, quiet=True)
    return calls


@pytest.mark.parametrize(("low", "touching"), [(1.5, False), (0.75, True)])
def test_contact_works_at_shared_nodes_only(low, touching, monkeypatch):
    bodies = [mpm.Body(mpm.Box((x, 0.5), (x + 0.5, 1.0)), RUBBER, name=f"b{x}") for x in (0.25, low)]
    calls = counted(monkeypatch, simulation(PLANE, *bodies, FrictionalContact(), integrator=MUSL(dt=1e-3)), until=3e-3)
    assert {"contact_normals", "reach_NeoHookean", "contact_v", "contact_v_map", "contact_impulse"} == set(calls)
    if touching:  # three steps; five nodes along the face times several across it, but by far not all 81 of the grid
        assert calls["contact_v"] == 3 and calls["reach_NeoHookean"] == 6 and 3 * 2 * 5 <= calls["contact_impulse"] < 3 * 2 * 81 / 2
    else:
        assert set(calls.values()) == {0}


def test_viscosity_acts_on_what_is_compressed_alone():
    def q(v):
        sim = scene(ArtificialViscosity(), integrator=MUSL(dt=1e-4))
        sim.bodies[0] = mpm.Body(mpm.Box((0.5, 0.5), (1.0, 1.0)), RUBBER, v=v, name="bar")
        sim.run(until=1e-4, quiet=True)
        return sim.particles("bar")["q"]

    assert (q(("0.75 - x", "0.75 - y")) > 0.0).all()
    assert not np.any(q(("x - 0.75", "y - 0.75")))


def test_effects_do_not_meet(monkeypatch):
    """Each of several effects changes what it changes alone."""
    parts = [Gravity((0.0, -1.0)), Damping(rate=1.0), ArtificialViscosity(), BodyForce((1.0, 0.0))]
    base, together = functions(plan_of()), functions(plan_of(*parts))
    changed = {n for n in base if together[n] != base[n]}
    alone = [functions(plan_of(part)) for part in parts]
    assert changed == {n for one in alone for n in base if one[n] != base[n]}
