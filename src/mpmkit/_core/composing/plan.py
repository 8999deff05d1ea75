"""The plan of a simulation: fields with their reasons, phases, and the generated module."""

from __future__ import annotations

import time
from typing import Any

import attrs
import numpy as np

import mpmkit
from mpmkit._core.composing import cache, conditions, meeting, sweeps
from mpmkit._core.composing.composition import Composition, Group
from mpmkit._core.composing.fingerprint import fingerprint
from mpmkit._core.composing.jit import Linker, compiled
from mpmkit._core.composing.layout import NodeLayout
from mpmkit._core.composing.operators import GridOperator, StoredOperator
from mpmkit._core.composing.pieces import PIECES
from mpmkit._core.composing.schedule import Phase, Schedule, schedule
from mpmkit._core.composing.source import Names, Parameters, ParticleLoop
from mpmkit._core.composing.sweep import Sweep, value_arguments
from mpmkit._core.composing.writer import fused_function, particle_function
from mpmkit.fields import PARTICLE_FIELDS

LEDGER = (
    "mass",
    "momentum_x",
    "momentum_y",
    "momentum_z",
    "angular_x",
    "angular_y",
    "angular_z",
    "kinetic",
    "stored",
    "dissipated",
    "volume",
)


@attrs.define(eq=False)
class Plan:
    """Everything the engine needs: phases, layouts, run-time parameters and the text of the module."""

    composition: Composition
    schedule: Schedule
    start: Schedule
    node_layout: NodeLayout
    operator: Any
    group_parameters: dict[str, Parameters]
    node_parameters: Parameters
    names: Names
    text: str
    digest: str
    module: Any = None
    compile_seconds: float = 0.0

    @property
    def dtype(self) -> type:
        return np.float32 if self.composition.sim.precision == "float32" else np.float64

    def load(self) -> Any:
        """Import the generated module with its components linked."""
        if self.module is None:
            begin = time.perf_counter()
            link = Linker(self.dtype)
            functions = {name: link(f) for name, f in self.names.functions.items()}
            self.module = cache.load(self.digest, self.text, functions | {"compiled": compiled, "T": self.dtype})
            self.compile_seconds += time.perf_counter() - begin
        return self.module


def make_plan(c: Composition) -> Plan:
    """Lay out the fields, schedule the recipe and write the module."""
    plan_steps = schedule(c, c.verbs)
    start = schedule(c, ["p2g", "momentum"]) if c.stored_operator else Schedule()
    _particle_fields(c)
    layout = _node_channels(c, plan_steps)
    if c.stored_operator:
        operator: Any = StoredOperator(c.discretization.nodes_per_point(c.dim))
    else:
        assert c.shape is not None
        operator = GridOperator(c.shape.nodes, c.shape.offset)
    names, node_parameters = Names(), Parameters()
    group_parameters = {g.name: Parameters() for g in c.groups}
    helpers = operator.helpers(c.transfer is not None and c.transfer.affine == "moment")
    texts: list[str] = ["\n".join(helpers)] if helpers else []

    def loop(group: Group) -> ParticleLoop:
        import mpmkit.tensor as tensor

        names.of("det", tensor.det)
        return ParticleLoop(c, group_parameters[group.name], names, group)

    def sweep() -> Sweep:
        return Sweep(c, node_parameters, names, layout)

    done: set[str] = set()
    channel = {"strain": plan_steps.strain_channel, "u": "u", "u_next": "u_next"}
    for phase in [*start.phases, *plan_steps.phases]:
        has_velocity = plan_steps.has_velocity and phase.name != "start_momentum"
        for function, text in _phase_texts(c, phase, layout, operator, loop, sweep, channel, has_velocity, plan_steps):
            if function not in done:
                done.add(function)
                texts.append(text)
    for group in c.groups:
        texts += [_initial(loop(group), layout, operator), _ledger(loop(group), layout, operator)]
        if c.contact is not None:
            texts.append(meeting.reach_function(loop(group), layout, operator, f"reach_{group.name}"))
        if getattr(c.integrator, "mass", "lumped") == "consistent":
            texts.append(_mass_matrix(loop(group), layout, operator))
    if plan_steps.contact_channels:
        texts.append(meeting.contact_functions(sweep(), list(dict.fromkeys(plan_steps.contact_channels))))
    text = _header(c, names) + "\n\n\n".join(t.rstrip("\n") for t in texts) + "\n"
    from mpmkit._core.composing import jit

    digest = fingerprint(names.functions, text, cache.versions() if jit.enabled() else "plain")
    return Plan(c, plan_steps, start, layout, operator, group_parameters, node_parameters, names, text, digest)


def _phase_texts(
    c: Composition,
    phase: Phase,
    layout: NodeLayout,
    operator: Any,
    loop: Any,
    sweep: Any,
    channel: dict[str, str],
    has_velocity: bool,
    plan: Schedule,
) -> list[tuple[str, str]]:
    """Functions one phase needs: (name, text)."""
    if phase.kind == "particles":
        return [
            (f"{phase.name}_{g.name}", fused_function(loop(g), layout, operator, f"{phase.name}_{g.name}", list(phase.verbs), channel))
            for g in c.groups
        ]
    if phase.kind == "loads":
        out = []
        for g in c.groups:
            one = loop(g)
            one.in_middle = False
            out.append((f"{phase.name}_{g.name}", conditions.load(one, layout, operator, phase.role, f"{phase.name}_{g.name}")))
        return out
    if phase.kind == "boundary":
        on_old = (phase.channel == "v" and not has_velocity) or (phase.channel == "v" and c.stored_operator)
        return [(phase.name, conditions.boundary(sweep(), phase.role, phase.channel, on_old, phase.name))]
    if phase.kind == "nodes":
        if phase.name in ("momentum", "start_momentum"):
            return [(phase.name, sweeps.momentum(sweep(), has_velocity, phase.name))]
        if phase.name == "carry":
            return [("carry", sweeps.carry(sweep(), "carry"))]
        if phase.name == "velocity":
            return [("velocity", sweeps.divide(sweep(), "v_old", "velocity", "Nodes: v_i = (mv)_i / m_i."))]
        if phase.name == "limited_velocity":
            return [(phase.name, sweeps.limit(sweep(), phase.name))]
        if phase.name == "mapped_velocity":
            return [(phase.name, sweeps.divide(sweep(), "v_map", phase.name, "Nodes: v_i = (mv)_i / m_i after the second mapping."))]
        if phase.name == "filter_start":
            return [("filter_start", sweeps.filter_start(sweep()))]
        return [("filter_add", sweeps.filter_add(sweep()))]
    return []


def _particle_fields(c: Composition) -> None:
    """The fields of each group's record: what the kernels and verbs ask for, and no more."""
    integrator = type(c.integrator or c.discretization).__name__
    for group in c.groups:
        layout, material = group.layout, type(group.material).__name__
        for name in ("x", "v", "m", "V0"):
            layout.add(PARTICLE_FIELDS[name], integrator)
        asked: dict[str, list[str]] = {}
        for kernel in group.hooks.values():
            for name in kernel.arguments:
                asked.setdefault(name, []).append(material)
        for role, effect in c.effects.items():
            for hook in ("body_force", "viscous_pressure", "signal_speed"):
                kernel = getattr(effect, hook)
                for name in kernel.arguments if kernel is not None else ():
                    asked.setdefault(name, []).append(role)
                    for more in value_arguments(effect, name, c.dim):
                        asked.setdefault(more, []).append(role)
        for role, layer in c.layers.items():
            for name in layer.load.arguments if layer.load is not None else ():
                for one in (name, *value_arguments(layer, name, c.dim)):
                    asked.setdefault(one, []).append(role)
        if c.reference:
            asked.setdefault("F", []).append(type(c.discretization).__name__)
        if c.shape is not None and c.shape.particle_size == "current":
            asked.setdefault("F", []).append(type(c.shape).__name__)
        volume = PARTICLE_FIELDS["F"] if "F" in asked else PARTICLE_FIELDS["J"]
        if volume.name == "F":
            volume = attrs.evolve(volume, initial=1.0)
        for who in dict.fromkeys(asked.get("F", [f"{integrator} (volume)"])):
            layout.add(volume, who)
        layout.add(PARTICLE_FIELDS["stress"], material)
        for field in group.state:
            layout.add(field, material)
        if "X" in asked:
            for who in asked["X"]:
                layout.add(PARTICLE_FIELDS["X"], who)
        if c.transfer is not None and c.transfer.affine != "none":
            layout.add(PARTICLE_FIELDS["C"], type(c.transfer).__name__)
        for role, effect in c.effects.items():
            if effect.viscous_pressure is not None:
                layout.add(PARTICLE_FIELDS["q"], role)
        if c.shape is not None and c.shape.particle_size != "none":
            layout.add(PARTICLE_FIELDS["size"], type(c.shape).__name__)
        if c.keeps_size:
            layout.add(PARTICLE_FIELDS["size_now"], f"{type(c.shape).__name__} with {integrator}")


def _node_channels(c: Composition, plan: Schedule) -> NodeLayout:
    layout = NodeLayout(c.dim)
    integrator = type(c.integrator or c.discretization).__name__
    layout.add(["m"], integrator, scalar=True)
    layout.add(["v_old", "v"], f"{integrator}: (mv)_i then v_i before, f_i then v_i after the update")
    if any(p.channel == "v_map" for p in plan.phases):
        layout.add(["v_map"], f"{integrator}: velocities for the strain")
    loads = [role for role, layer in c.layers.items() if layer.load is not None]
    loads += [role for role, e in c.effects.items() if e.body_force is not None]
    if loads:
        layout.add(["f_ext"], f"work of {', '.join(loads)}")
    if c.limits_velocities:
        given = [role for role, e in c.effects.items() if e.acceleration is not None or (e.body_force is not None and not c.loaded)]
        if given:
            layout.add(["v_given"], f"change of velocity by {', '.join(given)}, which is not limited at light nodes")
    if c.contact is not None:
        layout.add(["outward"], f"normals of {type(c.contact).__name__}")
    if c.transfer is not None and c.transfer.passes > 1:
        layout.add(["u", "u_next", "v_smooth"], type(c.transfer).__name__)
    return layout


def _initial(loop: ParticleLoop, layout: NodeLayout, operator: Any) -> str:
    """Stress of the initial deformation and the wave speed for the first time step: the law with L = 0 and dt = 0."""
    loop.in_middle = True
    loop.middle.append("L = (zero, zero, zero, zero, zero, zero, zero, zero, zero)")
    loop.have.add("L")
    PIECES["stress"](loop, layout, "compute", {})
    loop.field("x")
    loop.middle += ["x_low = min(x_low, x[0])", "x_high = max(x_high, x[0])"]
    return particle_function(loop, layout, operator, f"initial_{loop.group.name}", "Initial stress and wave speed")


def _ledger(loop: ParticleLoop, layout: NodeLayout, operator: Any) -> str:
    """Sums for the ledger over one body."""
    dim, group = loop.dim, loop.group
    affine = "C" in group.layout.fields
    for name in ("x", "v", "m", "V0"):
        loop.field(name)
    if affine:
        loop.field("C")
        loop.needs |= {"w", "r"}
        for b in range(dim):
            loop.gather_zero.append(f"D{b} = zero")
            loop.gather.append(f"D{b} += w * r{b} * r{b}")
        _ = [loop.field(n) for n in ("size", "size_now", "F") if n in group.layout.fields]
    loop.in_middle = True
    loop.field("V")
    add = ["mass += m"] + [f"momentum{a} += m * v[{a}]" for a in range(dim)]
    squares = " + ".join(f"v[{a}] * v[{a}]" for a in range(dim))
    if affine:
        squares += "".join(f" + C[{3 * a + b}] * C[{3 * a + b}] * D{b}" for a in range(dim) for b in range(dim))
    add.append(f"kinetic += T(0.5) * m * ({squares})")
    for axis, (a, b) in enumerate(((1, 2), (2, 0), (0, 1))):
        if a < dim and b < dim:
            spin = f" + C[{3 * b + a}] * D{a} - C[{3 * a + b}] * D{b}" if affine else ""
            add.append(f"angular{axis} += m * (x[{a}] * v[{b}] - x[{b}] * v[{a}]{spin})")
    add.append("volume += V")
    for hook, column in (("energy", "stored"), ("dissipation", "dissipated")):
        if hook in group.hooks:
            add.append(f"{column} += V0 * {loop.material(hook, {})}")
    loop.middle += add
    sums = ["mass", *(f"momentum{a}" for a in range(3)), *(f"angular{a}" for a in range(3)), "kinetic", "stored", "dissipated", "volume"]
    text = particle_function(loop, layout, operator, f"ledger_{group.name}", "Mass, momentum, angular momentum and energies of one body")
    head, rest = text.split("    for p in range(n):", 1)
    zeros = "".join(f"    {s} = 0.0\n" for s in sums)
    ends = "".join(f"    out[{k}] += {s}\n" for k, s in enumerate(sums))
    return f"{head}{zeros}    for p in range(n):{rest}{ends}"


def _mass_matrix(loop: ParticleLoop, layout: NodeLayout, operator: Any) -> str:
    """Consistent mass matrix m_ij = sum_p m_p N_i N_j (eq 1-14 of SAND2002-0482) into a dense array, `number` maps nodes to rows."""
    loop.needs.add("w")
    loop.field("m")
    loop.scatter += [
        f"row = number[k // {layout.size}]",
        "for q in range(count):",
        "    M[row, rows[q]] += m * w * ws[q]",
    ]
    loop.gather_zero.append("count = 0")
    loop.gather += [f"rows[count] = number[k // {layout.size}]", "ws[count] = w", "count += 1"]
    return particle_function(
        loop, layout, operator, f"mass_matrix_{loop.group.name}", "Consistent mass matrix", extra="M, number, rows, ws, "
    )


def _edge(c: Composition) -> list[str]:
    """How near a particle may come to a node of a kinked shape function, in cells."""
    if c.shape is None or c.shape.smooth:
        return []
    return [f"edge = T({64.0 * float(np.finfo(c.sim.precision).eps)!r})"]


def _header(c: Composition, names: Names) -> str:
    # Only kinds of components: their values are run-time parameters and do not belong to the text.
    sim = c.sim
    kinds = [
        type(x).__name__
        for x in (sim.shape, sim.integrator, sim.discretization, *sim.boundaries, *sim.contacts, *sim.effects)
        if x is not None
    ]
    lines = [
        f'"""One step of a simulation composed of {", ".join(kinds)}',
        f"in {c.grid.space} with {', '.join(g.name for g in c.groups)}, {sim.precision}. Written by mpmkit "
        f"{mpmkit.__version__}; edit the components, not this file.",
        "",
        "P: particles of one body, component k of particle p at P[(p >> 4) * 16 R + 16 k + (p & 15)].",
        "G: nodes, channel c of node i at G[i C + c]; channels: "
        + ", ".join(f"{n} {s}" for n, s in _node_channels(c, schedule(c, c.verbs)).start.items())
        + ".",
        "par: run-time parameters. lat: cells and strides of the grid. Component functions are filled in when this module is loaded:",
    ]
    for name, f in names.functions.items():
        lines.append(f"    {name} = {f.__module__}.{f.__qualname__}")
    lines += ['"""', "", "from math import floor, sqrt", "", "zero, one = T(0), T(1)", *_edge(c), "", "", ""]
    return "\n".join(lines)
