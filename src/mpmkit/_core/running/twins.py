"""Copies of a simulation to try things on: whole, or without one of its optional components, and in the state of the original."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mpmkit._core.composing.composition import Composition
from mpmkit._core.running.engine import Engine

if TYPE_CHECKING:
    from mpmkit._core.running.loop import Run
    from mpmkit.simulation import Simulation

Place = tuple[str, int]
"""Which list of a simulation a component is in, and where."""


def optional(c: Composition) -> dict[str, Place]:
    """Components that a composition could do without, by role: contact, effects, boundary layers."""
    found: dict[str, Place] = {} if c.contact is None else {type(c.contact).__name__: ("contacts", 0)}
    for kind, roles in (("effects", c.effects), ("boundaries", c.layers)):
        found |= {role: (kind, k) for k, role in enumerate(roles)}
    return found


def twin(sim: Simulation, threads: int, leave_out: Place | None = None) -> Run:
    """Compose a simulation of the same parts, less one component and the records, and make it ready to step.

    Raises
    ------
    MpmkitError
        If the parts do not fit together without that component.
    """
    from mpmkit._core.running.loop import Run

    method = {"discretization": sim.discretization, "precision": sim.precision, "leaving": sim.leaving}
    other = type(sim)(sim.grid, sim.shape, sim.integrator, **method)
    for kind in ("bodies", "boundaries", "contacts", "effects"):
        getattr(other, kind)[:] = [part for k, part in enumerate(getattr(sim, kind)) if (kind, k) != leave_out]
    run = Run(other)
    run.use(threads)
    run.warm_up()
    return run


def take_state(mine: Engine, theirs: Engine) -> None:
    """Bring an engine to the state of another one of the same bodies, field by field: those that only the other one has are left out."""
    for ours, original in zip(mine.stores, theirs.stores, strict=True):
        ours.keep(original.points_now())
        for name in ours.layout.fields:
            ours.set(name, original.get(name))
    mine.outs[:], mine.work[:], mine.gone[:] = theirs.outs, theirs.work, theirs.gone
    mine.flags[:] = False
    if mine.c.stored_operator:
        _take_nodes(mine, theirs)
    else:
        mine.places.drift[:] = np.inf  # the next step sorts the particles first
    mine.t, mine.step_number = theirs.t, theirs.step_number


def _take_nodes(mine: Engine, theirs: Engine) -> None:
    """The nodes of a mesh carry velocities from step to step."""
    ours, original = ((e.fields[0].G.reshape(-1, e.channels), e.plan.node_layout) for e in (mine, theirs))
    for name, start in ours[1].start.items():
        there, width = original[1].start.get(name), ours[1].width(name)
        if there is not None:
            ours[0][:, start : start + width] = original[0][:, there : there + width]
