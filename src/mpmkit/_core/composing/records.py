"""The records of particles and nodes: which fields exist, and who asked for them."""

from __future__ import annotations

import attrs

from mpmkit._core.composing.composition import Composition
from mpmkit._core.composing.layout import NodeLayout
from mpmkit._core.composing.schedule import Schedule
from mpmkit._core.composing.sweep import value_arguments
from mpmkit.fields import PARTICLE_FIELDS


def particle_fields(c: Composition) -> None:
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
        if group.keeps_stress:
            layout.add(PARTICLE_FIELDS["stress"], material)
        else:
            layout.derived["stress"] = PARTICLE_FIELDS["stress"]
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


def node_channels(c: Composition, plan: Schedule) -> NodeLayout:
    """The channels of the nodes' record: what phases and components read and write, and no more.

    Those that one loop needs lie beside each other, for a loop moves a whole window of them.
    """
    layout = NodeLayout(c.dim, 4 if c.sim.precision == "float32" else 8)
    integrator = type(c.integrator or c.discretization).__name__
    if any(p.channel == "v_map" for p in plan.phases):
        layout.add(["v_map"], f"{integrator}: velocities for the strain")
    if c.merges:
        layout.add(["v"], f"{integrator}: (mv)_i + dt f_i, then v_i")
    else:
        layout.add(["v", "v_old"], f"{integrator}: (mv)_i then v_i before, f_i then v_i after the update")
    layout.add(["m"], integrator, scalar=True)
    loads = [role for role, layer in c.layers.items() if layer.load is not None]
    loads += [role for role, e in c.effects.items() if e.body_force is not None]
    if loads:
        layout.add(["f_ext"], f"work of {', '.join(loads)}")
    if c.transfer is not None and c.transfer.passes > 1:
        layout.add(["v_smooth", "u", "u_next"], type(c.transfer).__name__)
    if c.contact is not None:
        layout.add(["outward"], f"normals of {type(c.contact).__name__}")
    if any(p.name == "soft_velocity" for p in plan.phases):
        layout.add(["v_soft"], f"{type(c.transfer).__name__}: velocities limited at light nodes")
    if c.limits_velocities:
        given = [role for role, e in c.effects.items() if e.acceleration is not None or (e.body_force is not None and not c.loaded)]
        if given:
            layout.add(["v_given"], f"change of velocity by {', '.join(given)}, which is left alone at light nodes")
    return layout
