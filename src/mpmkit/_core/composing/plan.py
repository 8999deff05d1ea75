"""The plan of a simulation: fields with their reasons, phases, and the generated module."""

from __future__ import annotations

import time
from typing import Any

import attrs
import numpy as np

from mpmkit._core.composing import cache, simd
from mpmkit._core.composing.composition import Composition
from mpmkit._core.composing.fingerprint import fingerprint
from mpmkit._core.composing.jit import Linker, compiled
from mpmkit._core.composing.layout import NodeLayout
from mpmkit._core.composing.module import Module
from mpmkit._core.composing.operators import GridOperator, StoredOperator
from mpmkit._core.composing.records import node_channels, particle_fields
from mpmkit._core.composing.schedule import Schedule, schedule
from mpmkit._core.composing.source import Names, Parameters


@attrs.define(eq=False)
class Plan:
    """Everything the engine needs: phases, layouts, run-time parameters and the text of the module.

    Attributes
    ----------
    start : Schedule
        Phases before the first step, where nodes carry their velocity; else empty.
    operator : GridOperator or StoredOperator
        How loops over particles visit nodes.
    slots : int
        Rows of 16 numbers that a thread's scratch array must have.
    scatters : set of str
        Loops that add to nodes.
    traffic : dict
        Of each loop over particles: channels summed over nodes, channels added to.
    digest : str
        Names the module in the cache.
    compile_seconds : float
        Wall time that loading the module took.
    """

    composition: Composition
    schedule: Schedule
    start: Schedule
    node_layout: NodeLayout
    operator: Any
    group_parameters: dict[str, Parameters]
    node_parameters: Parameters
    names: Names
    slots: int
    scatters: set[str]
    traffic: dict[str, tuple[tuple[str, ...], tuple[str, ...]]]
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
            self.module = cache.load(self.digest, self.text, functions | simd.functions() | {"compiled": compiled, "T": self.dtype})
            self.compile_seconds += time.perf_counter() - begin
        return self.module


def make_plan(c: Composition) -> Plan:
    """Lay out the fields, schedule the recipe and write the module."""
    plan_steps = schedule(c, c.verbs)
    start = schedule(c, ["p2g", "momentum"]) if c.stored_operator else Schedule()
    particle_fields(c)
    layout = node_channels(c, plan_steps)
    if c.stored_operator:
        operator: Any = StoredOperator(c.dim, c.discretization.nodes_per_point(c.dim))
    else:
        assert c.shape is not None
        operator = GridOperator(c.dim, c.shape.nodes, c.shape.offset, np.dtype(c.sim.precision).itemsize)
    writing = Module(c, layout, operator, plan_steps)
    for phase in [*start.phases, *plan_steps.phases]:
        writing.phase(phase)
    for group in c.groups:
        writing.group(group)
        writing.cycle(group)
    text = writing.text()
    from mpmkit._core.composing import jit

    digest = fingerprint(writing.names.functions, text, cache.versions() if jit.enabled() else "plain", *jit.sources())
    return Plan(
        c,
        plan_steps,
        start,
        layout,
        operator,
        writing.group_parameters,
        writing.node_parameters,
        writing.names,
        writing.slots,
        writing.scatters,
        writing.traffic,
        text,
        digest,
    )
