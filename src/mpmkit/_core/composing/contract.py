"""Checks a composition before anything is generated: what cannot work is refused, with the reason and ways out."""

from __future__ import annotations

from typing import Any

from mpmkit._core.composing import cautions, limits
from mpmkit._core.composing.composition import Composition
from mpmkit._core.composing.layout import SYMMETRIC, TENSOR
from mpmkit._core.composing.schedule import schedule
from mpmkit.errors import CompositionError
from mpmkit.interfaces import BoundaryLayer, Component


def check(c: Composition) -> list[str]:
    """Refuse what does not work; return warnings about what is known, or was found, to be unstable.

    Raises
    ------
    CompositionError
        Who conflicts with whom, and what to do.
    """
    sim = c.sim
    if not sim.bodies:
        raise CompositionError("the simulation has no body; add one with sim += mpm.Body(geometry, material)")
    if len(sim.contacts) > 1:
        raise CompositionError(
            f"one contact algorithm acts on all bodies, got {', '.join(type(k).__name__ for k in sim.contacts)}; keep one"
        )
    for component in _all(c):
        _check_space(c, component)
        if sim.precision not in component.precisions:
            raise CompositionError(
                f"{type(component).__name__} works in {', '.join(component.precisions)} only, not in {sim.precision}; set "
                "precision accordingly"
            )
    _check_order(c)
    _check_moments(c)
    _check_bar(c)
    _check_axis(c)
    _check_layers(c)
    _check_values(c)
    if c.stored_operator:
        _check_stored(c)
    if getattr(c.integrator, "mass", "lumped") == "consistent":
        _check_consistent(c)
    return cautions.warnings(c) + limits.warnings(c) + _negative_weights(c)


def _negative_weights(c: Composition) -> list[str]:
    if c.shape is None or c.shape.positive:
        return []
    return [
        f"{type(c.shape).__name__} has negative weights: nodes at the edge of a body are left with no mass, or less than none, and their "
        "momentum is lost. To fix: a shape function with positive weights, such as QuadraticBSpline"
    ]


def _all(c: Composition) -> list[Component]:
    parts: list[Any] = [c.shape, c.integrator, c.transfer, c.discretization, c.contact, *c.effects.values(), *c.layers.values()]
    return [p for p in [*parts, *(b.material for b in c.sim.bodies)] if p is not None]


def _check_space(c: Composition, component: Component) -> None:
    if c.grid.space not in component.spaces:
        from mpmkit._core.registry import registry

        others = [e.name for e in registry().of(component.kind).values() if c.grid.space in e.component.spaces]
        instead = f"{', '.join(sorted(others))}, or another grid" if others else "another grid"
        raise CompositionError(
            f"{type(component).__name__} ({component.kind}) does not work in a grid that is {c.grid.space}; it works in "
            f"{', '.join(component.spaces)}. To fix: {instead}"
        )


def _check_order(c: Composition) -> None:
    """Particles move last: until the next step sorts them, they may be beyond the nodes at hand."""
    if c.stored_operator:
        return
    phases = schedule(c, c.verbs).phases
    moved = next((k for k, phase in enumerate(phases) if "advect" in phase.verbs), len(phases))
    for phase in phases[moved + 1 :]:
        if phase.kind in ("loads", "contact", "solve") or set(phase.verbs) - {"stress"}:
            raise CompositionError(
                f"{type(c.integrator).__name__}: its recipe moves the particles by advect() and then visits nodes again in "
                f"{', '.join(phase.verbs) or phase.name}; a step must see one set of weights. To fix: call advect() in the last loop "
                "that visits nodes (neighbouring verbs over particles are one loop)"
            )


def _check_moments(c: Composition) -> None:
    if c.transfer is not None and c.transfer.gradient == "moment" and c.shape is not None and c.shape.nodes < 3:
        raise CompositionError(
            f"{type(c.transfer).__name__} takes gradients from the moments of the weights, which vanish where a particle lies on a node of "
            f"{type(c.shape).__name__} (2 nodes in each direction). Use APIC, or a shape function of three nodes or more"
        )


def _check_bar(c: Composition) -> None:
    if c.grid.lateral != "stress":
        return
    for body in c.sim.bodies:
        if body.material.bar_stress is None:
            raise CompositionError(
                f"{type(body.material).__name__} has no form for uniaxial stress, which Grid(lateral='stress') asks for; use "
                "lateral='strain' or a law that has one"
            )


def _check_axis(c: Composition) -> None:
    if c.grid.space == "axisymmetric" and c.grid.lower[0] == 0.0:
        held = [layer for layer in c.layers.values() if "xmin" in layer.faces_of(c.grid) and layer.bilateral and _holds_normal(layer)]
        if not held:
            raise CompositionError(
                "an axisymmetric grid that begins at r = 0 needs v_r = 0 on the axis; add mpmkit.boundaries.Symmetry('xmin')"
            )


def _holds_normal(layer: BoundaryLayer) -> bool:
    """False for a layer that prescribes some components and leaves the normal one, x on the axis, free."""
    return getattr(layer, "components", "all") in ("all", "normal", "x")


def _check_layers(c: Composition) -> None:
    from mpmkit.errors import did_you_mean

    names = [c.sim.body_name(b) for b in c.sim.bodies]
    for layer in c.layers.values():
        layer.faces_of(c.grid)
        body = getattr(layer, "body", None)
        if body is not None and body not in names:
            raise CompositionError(
                f"{type(layer).__name__}.body: no body is named {body!r}{did_you_mean(body, names)}; bodies: {', '.join(names)}"
            )
        face = getattr(layer, "face", None)
        if face is not None and face not in c.grid.faces:
            raise CompositionError(f"{type(layer).__name__}.face: the {c.dim}D grid has no {face!r}; it has {', '.join(c.grid.faces)}")


def _check_values(c: Composition) -> None:
    """Vectors must have as many components as space has dimensions."""
    from typing import get_args

    from mpmkit.expression import as_function
    from mpmkit.parameters import Vector, specs

    for component in [*c.effects.values(), *c.layers.values()]:
        for name, (attribute, _) in specs(type(component)).items():
            value = getattr(component, name)
            if name in component.values:
                as_function(value, c.dim, f"{type(component).__name__}.{name}")
            elif Vector in (attribute.type, *get_args(attribute.type)) and value is not None and len(value) != c.dim:
                raise CompositionError(
                    f"{type(component).__name__}.{name} must have {c.dim} component(s) in a {c.dim}D grid, got {len(value)}: {value}"
                )


def _check_stored(c: Composition) -> None:
    name = type(c.discretization).__name__
    if c.contact is not None:
        raise CompositionError(
            f"{name} does not offer contact: {type(c.contact).__name__} works between MPM bodies; leave it out or use MPM"
        )
    for layer in c.layers.values():
        if layer.constrain is not None and not layer.bilateral:
            raise CompositionError(
                f"{name} holds the nodes that stand on a face at the start, it does not look for bodies that come or go: "
                f"{type(layer).__name__} with separation needs MPM. Use Symmetry, or Wall(..., condition='no slip')"
            )
    if c.sim.shape is not None or c.sim.integrator is not None:
        raise CompositionError(f"{name} brings its own shape functions and time integration; leave shape and integrator out")


def _check_consistent(c: Composition) -> None:
    if c.contact is not None:
        raise CompositionError("mass='consistent' does not work with contact, which acts on lumped nodes; use mass='lumped'")
    if c.transfer is not None and (c.transfer.passes > 1 or c.transfer.affine != "none"):
        raise CompositionError(
            f"mass='consistent' does not work with {type(c.transfer).__name__}, whose affine or filtered velocities would come "
            "from nodes that no particle determines; use FLIP or PIC, or mass='lumped'"
        )
    if "remap" not in c.verbs:
        raise CompositionError(
            "mass='consistent' works with MUSL only: it leaves nodal velocities that no particle sees undetermined, and "
            f"{type(c.integrator).__name__} "
            "would take strains from them and blow up. Use MUSL, or mass='lumped'"
        )
    for layer in c.layers.values():
        if layer.constrain is not None and not (layer.bilateral and layer.faces_of(c.grid)):
            raise CompositionError(
                f"mass='consistent' needs conditions that always hold on faces; {type(layer).__name__} lets bodies separate, "
                "rubs, or acts in a region. "
                "Use Symmetry, a wall with no slip, or mass='lumped'"
            )


def _check_held_planes(c: Composition, points: list[Any]) -> None:
    """With the consistent mass a body that meets a held plane in motion makes energy, whatever the step (see `running.consistent`)."""
    import numpy as np

    assert c.shape is not None
    for role, layer in c.layers.items():
        for face in layer.faces_of(c.grid):
            axis, upper = "xyz".index(face[0]), face.endswith("max")
            plane = (c.grid.upper if upper else c.grid.lower)[axis]
            for k, one in enumerate(points):
                distance, v = np.abs(one.x[:, axis] - plane), one.v[:, axis]
                touches = bool((distance <= 2.0 * one.size[:, axis]).any())
                near = distance < 0.5 * c.shape.nodes * c.grid.spacing[axis]
                fastest = float(np.abs(v).max())
                slow = fastest == 0.0 or not near.any() or float(np.abs(v[near]).max()) <= 0.5 * fastest
                towards = bool((v > 0.0).any() if upper else (v < 0.0).any())
                if slow and (touches or not (towards or near.any())):
                    continue
                raise CompositionError(
                    f"mass='consistent' works where bodies touch held planes from the start and are at rest there; body "
                    f"{c.sim.body_name(c.sim.bodies[k])!r} would meet {role} on {face!r} in motion, and make energy. To fix: mass='lumped'"
                )


def check_state(c: Composition, points: list[Any]) -> None:
    """Refuse initial states that the law would replace, or of which the space stores only a part.

    Raises
    ------
    CompositionError
        Names the body, what it was given, and what to give instead.
    """
    import numpy as np

    if getattr(c.integrator, "mass", "lumped") == "consistent":
        _check_held_planes(c, points)
    for k, one in enumerate(points):
        group, who = c.group_of(k), f"body {c.sim.body_name(c.sim.bodies[k])!r}"
        law = type(group.material).__name__
        if one.stress is not None and "stress" not in group.hooks["stress"].arguments:
            raise CompositionError(
                f"{who}: the initial stress would be lost, since {law} computes the stress from F alone; give the initial F, or "
                "use a law in rate form"
            )
        held: Any = (("F", one.F, TENSOR, np.eye(3).ravel(), 9), ("stress", one.stress, SYMMETRIC, np.zeros(6), 6))
        for name, value, stored, default, size in held:
            if value is None:
                continue
            lost = np.setdiff1d(np.arange(size), stored[group.layout.space])
            wrong = (np.asarray(value).reshape(-1, size)[:, lost] != default[lost]).any(axis=0)
            if wrong.any():
                first = lost[np.argmax(wrong)]
                space = "uniaxial stress" if group.layout.space == "bar" else c.grid.space
                raise CompositionError(
                    f"{who}: the initial {name} has a component that does not exist in {space}; component {first} (counted from 0) must be "
                    f"{default[first]:g} there. Leave it out, or use a grid in which it exists"
                )
