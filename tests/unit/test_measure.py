"""`explain` with loops and memory, and what it measures: of phases, and of what a composition could do without."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from small_scenes import RUBBER, grid, simulation

import mpmkit as mpm
from mpmkit._core.running import measuring, twins
from mpmkit.boundaries import TractionLayer, Wall
from mpmkit.contacts import FrictionalContact
from mpmkit.discretizations import FEM
from mpmkit.effects import ArtificialViscosity, Gravity
from mpmkit.errors import CompositionError, ParameterError, StabilityError
from mpmkit.integrators import MLS, MUSL, USL, XPIC
from mpmkit.materials import VonMises

PLANE = grid("plane strain")


@pytest.fixture(autouse=True)
def plain(plain_python):
    """Nothing here needs a compiler."""


def body(low=0.5, name="bar", material=RUBBER, v=0.0):
    return mpm.Body(mpm.Box((low, 0.5), (low + 0.5, 1.0)), material, name=name, v=(v, 0.0))


def scene(*parts, integrator=None, **more):
    return simulation(PLANE, body(), *parts, integrator=integrator or MUSL(dt=1e-3), **more)


# --- what explain says of the loops -------------------------------------------------------------------------------
def test_loops_are_named_with_what_they_read_and_add():
    data = scene(integrator=MUSL(XPIC(3), dt=1e-3)).explain().data
    loops = {f["function"]: f for phase in data["phases"] if phase["over"] == "particles" for f in phase["functions"]}
    assert loops["p2g_forces_NeoHookean"] == {"function": "p2g_forces_NeoHookean", "sums": [], "adds": ["m", "v_old", "v"]}
    assert loops["filter_NeoHookean"]["sums"] == ["u"] and loops["filter_NeoHookean"]["adds"] == ["u_next"]
    sizes = {"passes": 5, "nodes per particle": 9, "operator": "rebuilt", "block": [8, 8], "arena": [12, 12]}
    assert data["loops"] == sizes | {"joined in large bodies": False}
    text = scene().compose().plan.text
    for phase in scene(FrictionalContact(), TractionLayer("bar", (1.0, 0.0), "xmax"), Wall("all")).explain().data["phases"]:
        assert phase["functions"]
    for phase in scene().explain().data["phases"]:
        assert all(f"def {f['function']}(" in text for f in phase["functions"])


def test_every_function_that_is_named_is_generated():
    sim = scene(FrictionalContact(), body(1.0, "other"), TractionLayer("bar", (1.0, 0.0), "xmax"), Wall("all"), Gravity((0.0, -1.0)))
    explanation, text = sim.explain(), sim.compose().plan.text
    names = [f["function"] for phase in explanation.data["phases"] for f in phase["functions"]]
    assert {"contact_normals", "load_TractionLayer_NeoHookean", "Wall_v", "momentum"} <= set(names)
    assert all(f"def {name}(" in text for name in names)
    assert json.loads(json.dumps(explanation.data)) == explanation.data


def test_memory_is_that_of_the_arrays():
    sim = scene()
    data = sim.explain().data
    engine = sim.compose().engine
    assert data["threads"] == 1
    assert data["memory"]["particles"] == sum(s.P.nbytes + s.ids.nbytes for s in engine.stores) > 16 * 8 * 10
    assert data["memory"]["stored nodes"] == data["memory"]["blocks"] * 64 > 0
    assert data["memory"]["scratch"] > 0
    text = str(sim.explain())
    assert "loops: 3 over the particles, 9 nodes each; particles sorted by cell, blocks of 8 x 8 nodes, arenas of 12 x 12\n" in text
    joined = "9 nodes each, the last and the next step's first in one pass if bodies are large; particles sorted"
    assert joined in str(scene(integrator=USL(MLS(), limit=0.0, dt=1e-3)).explain())
    assert re.search(
        r"memory: \S+ \w+ for particles, \S+ \w+ for [\d,]+ stored nodes in \d+ blocks, \S+ \w+ of scratch for 1 thread\n", text
    )


def test_loops_over_lists():
    text = str(simulation(PLANE, body(), discretization=FEM()).explain())
    assert re.search(r"loops: \d over the particles, 4 nodes each, from lists with weights that are made once\n", text)


# --- copies -------------------------------------------------------------------------------------------------------
def state(sim):
    return {n: np.array(a) for n, a in sim.compose().engine.state().items()}, sim.t, sim.step_number


def equal(one, other):
    return one[1:] == other[1:] and all(np.array_equal(one[0][n], other[0][n]) for n in one[0])


@pytest.mark.parametrize("leave_out", [None, ("effects", 1)])
def test_a_twin_takes_the_state(leave_out):
    steel = VonMises(E=100.0, nu=0.3, rho=1.0, yield_stress=0.1)
    sim = scene(body(1.0, "metal", steel, v=-1.0), Gravity((0.0, -1.0)), ArtificialViscosity(), integrator=MUSL(dt=2e-4))
    sim.run(until=0.01, quiet=True)
    run = twins.twin(sim, 1, leave_out)
    twins.take_state(run.engine, sim.compose().engine)
    assert (run.engine.t, run.engine.step_number) == (sim.t, sim.step_number)
    for store in run._stores:
        original = sim.particles(store.name)
        assert ("q" in store.layout.fields) == (leave_out is None)
        for name in store.layout.fields:
            assert np.array_equal(store.get(name), original[name]), name
    assert any((run._stores[1].get(f.name) > 0.0).any() for f in steel.state), "it has a history"
    if leave_out is None:  # it goes on as the original does, up to the order of the sums
        run.engine.step(2e-4)
        sim.run(until=0.0102, quiet=True)
        for store in run._stores:
            v = sim.particles(store.name)["v"]
            assert np.abs(store.get("v") - v).max() < 100 * np.finfo(float).eps * np.abs(v).max()  # rounding: sums of tens of terms


def test_nodes_of_a_mesh_go_on_moving():
    sim = simulation(PLANE, body(v=1.0), Gravity((0.0, -1.0)), discretization=FEM())
    sim.run(until=0.01, quiet=True)
    run = twins.twin(sim, 1)
    twins.take_state(run.engine, sim.compose().engine)
    run.engine.step(1e-3)
    assert run._stores[0].get("v").mean(axis=0) == pytest.approx([1.0, -0.011], rel=1e-12)  # rounding


def test_optional_components_and_where_they_are():
    sim = scene(Wall("xmin"), Gravity((0.0, -1.0)), FrictionalContact(), Wall("xmax"), ArtificialViscosity())
    found = twins.optional(sim.compose().plan.composition)
    assert list(found) == ["FrictionalContact", "Gravity", "ArtificialViscosity", "Wall", "Wall_2"]
    assert all(type(getattr(sim, kind)[k]).__name__ == role.split("_")[0] for role, (kind, k) in found.items())


# --- measuring ----------------------------------------------------------------------------------------------------
def test_what_is_measured(tmp_path):
    sim = scene(Wall("all"), Gravity((0.0, -1.0)), mpm.Record(str(tmp_path / "run.vtkhdf"), every=0.05))
    explanation = sim.explain()
    before = state(sim)
    said = []
    assert explanation.measure(steps=12, say=said.append) is explanation
    assert equal(before, state(sim)), "the scene does not move"
    assert list(tmp_path.iterdir()) == [], "nothing is written to where it records"
    assert said == ["measuring the phases", "measuring without Gravity (1 of 2)", "measuring without Wall (2 of 2)"]
    m = explanation.data["measured"]
    assert json.loads(json.dumps(m)) == m
    assert (m["steps"], m["t"], m["dt"], m["threads"], m["particles"], m["stopped"]) == (12, 0.0, 1e-3, 1, 16, "")
    names = [row["name"] for row in m["phases"]]
    phases = list(dict.fromkeys(p.name for p in sim.compose().plan.schedule.phases))
    others = ["guards, time step", "history, every 10 steps", "frames, every 0.05 s", "checkpoints"]
    assert names == ["sort", "zero", *phases, "accounts", *others]
    assert sum(row["share"] for row in m["phases"]) == pytest.approx(1.0)
    assert sum(row["ns"] for row in m["phases"]) == pytest.approx(m["ns"])
    assert {row["name"] for row in m["phases"] if not row["share"] > 0.0} == set()
    assert [(row["name"], row["kind"]) for row in m["components"]] == [("Gravity", "effects"), ("Wall", "boundaries")]
    assert all(row["spread"] > 0.0 and -2.0 < row["share"] < 1.0 and 7 <= row["rounds"] <= 12 for row in m["components"])
    text = str(explanation)
    assert re.search(r"\nmeasured in 12 steps from t = 0 s, 1 thread: [\d.e+]+ ns per particle-step\n +part of a step +share +ns per", text)
    assert re.search(r"\n    advect_strain_stress +[\d.]+% +[\d.e+]+\n", text)
    assert re.search(r"\n    Wall +[+-][\d.]+% ± [\d.]+%", text)
    assert "measured" not in sim.explain().data and "measured" not in str(sim.explain())


SLOW = """
def slow():
    total = 0.0
    for k in range(20000):
        total = total + 0.0 * k
    return (total, 0.0, 0.0)
"""


def slow_effect():
    space: dict = {}
    exec(SLOW, space)

    @mpm.define
    class Slow(mpm.Effect):
        """An acceleration that takes long."""

        acceleration = mpm.kernel(space["slow"])

    return Slow()


def test_what_costs_is_told_from_what_does_not():
    sim = scene(slow_effect())
    measured = sim.explain(measure=True).data["measured"]
    (row,) = measured["components"]
    assert row["name"] == "Slow" and row["share"] > 0.5 and row["share"] > row["spread"]
    assert measured["control"]["share"] < 0.4  # the same again takes as long; by far more than any noise
    shares = {part["name"]: part["share"] for part in measured["phases"]}
    assert max(shares, key=shares.get) == "momentum"


def test_measured_where_the_simulation_stands(monkeypatch):
    sim = scene(Gravity((0.0, -1.0)))
    sim.run(until=0.02, quiet=True)
    before = state(sim)
    assert sim.explain().measure(steps=3).data["measured"]["t"] == pytest.approx(0.02, rel=1e-12)
    assert equal(before, state(sim))
    sim.run(until=0.03, quiet=True)
    plain = scene(Gravity((0.0, -1.0)))
    plain.run(until=0.02, quiet=True)
    plain.run(until=0.03, quiet=True)
    assert equal(state(sim), state(plain)), "a run goes on as if nothing had been measured"


def test_a_refused_twin_is_named(monkeypatch):
    sim = scene(Wall("all"))
    whole = twins.twin

    def refuses(sim, threads, leave_out=None):
        if leave_out is not None:
            raise CompositionError("there must be a wall\nsecond line")
        return whole(sim, threads)

    monkeypatch.setattr(twins, "twin", refuses)
    explanation = sim.explain().measure(steps=2)
    (row,) = explanation.data["measured"]["components"]
    assert row == {"name": "Wall", "kind": "boundaries", "refused": "there must be a wall"}
    assert "Wall" in str(explanation) and "cannot be measured, there is no step without it: there must be a wall" in str(explanation)


def test_a_simulation_that_breaks_down(monkeypatch):
    sim = simulation(PLANE, body(v=40.0), integrator=MUSL(dt=0.002))
    explanation = sim.explain().measure(steps=100)
    m = explanation.data["measured"]
    assert 1 <= m["steps"] < 100 and "left the domain" in m["stopped"]
    assert "stopped early: particle" in str(explanation)
    with pytest.raises(StabilityError, match="above the stable limit"):
        simulation(PLANE, body(v=40.0), integrator=MUSL(dt=0.5)).explain(measure=True)


@pytest.mark.parametrize("steps", [0, -3, 1.5, "ten", True])
def test_steps_must_be_a_number_above_zero(steps):
    with pytest.raises(ParameterError, match=re.escape(f"steps must be a whole number above 0, got {steps!r}")):
        scene().explain().measure(steps=steps)


def test_threads_are_those_of_a_run():
    explanation = scene().explain()
    with pytest.raises(CompositionError, match="threads = 0"):
        explanation.measure(threads=0)
    assert explanation.measure(steps=2, threads=1).data["measured"]["threads"] == 1


def test_nothing_optional_is_one_table():
    tables = measuring_tables(scene().explain().measure(steps=2).data["measured"])
    assert len(tables) == 1


def measuring_tables(measured):
    from mpmkit.explanation import costs

    return costs(measured)


def test_noise_is_not_taken_for_cost():
    row = {"name": "Wall", "kind": "boundaries", "share": 0.01, "spread": 0.02, "rounds": 7}
    phases = [{"name": "sort", "share": 1.0, "ns": 1.0}]
    measured = {
        "steps": 1,
        "t": 0.0,
        "dt": 1.0,
        "threads": 2,
        "particles": 1,
        "ns": 1.0,
        "phases": phases,
        "stopped": "",
        "components": [row],
    }
    assert measuring_tables(measured)[1][2] == [("Wall", "+1.0% ± 2.0%", "not above the noise")]
    measured["components"] = [row | {"share": 0.03}]
    assert measuring_tables(measured)[1][2] == [("Wall", "+3.0% ± 2.0%", "")]
    assert "2 threads" in measuring_tables(measured)[0][0]
    assert measuring.ROUNDS[0] >= 7, "quartiles of fewer turns say little"


# --- command line -------------------------------------------------------------------------------------------------
def test_the_command_line_measures(tmp_path):
    (tmp_path / "bar.toml").write_text(scene(Wall("all"), until=0.1).scene_text()[0])

    def call(*arguments):
        command = [sys.executable, "-m", "mpmkit", "explain", "bar.toml", *arguments]
        return subprocess.run(
            command, cwd=tmp_path, capture_output=True, text=True, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, check=False
        )

    done = call("--measure", "--steps", "5", "--at", "2 ms")
    assert done.returncode == 0, done.stderr
    assert re.search(r"measured in 5 steps from t = 0.002 s, 1 thread", done.stdout)
    assert re.search(r"\n +Wall +[+-][\d.]+% ±", done.stdout)
    assert "measuring without Wall (1 of 1) ..." in done.stderr and "measuring" not in done.stdout
    assert [p.name for p in tmp_path.iterdir()] == ["bar.toml"]
    refused = call("--steps", "5")
    assert refused.returncode == 2 and "--steps says how to measure; add --measure" in refused.stderr
