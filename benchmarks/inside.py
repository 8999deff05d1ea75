"""The one place where the benchmarks look behind mpmkit's public interface: single steps, clocks of phases, layouts."""

from __future__ import annotations

import contextlib
import os
import time
import warnings
from dataclasses import dataclass
from typing import Any


def set_threads(threads: int) -> None:
    """Choose the number of threads of simulations that are started from now on."""
    os.environ["MPMKIT_THREADS"] = str(threads)


@dataclass
class Stepper:
    """A composed, compiled and started simulation that is stepped by hand, without guards, ledger and records."""

    run: Any

    @property
    def particles(self) -> int:
        """Number of particles."""
        return int(self.run.n_particles)

    def steps(self, count: int, dt: float) -> float:
        """Do `count` steps and return the wall time of one [s]."""
        step = self.run.engine.step
        begin = time.perf_counter()
        for _ in range(count):
            step(dt)
        return (time.perf_counter() - begin) / count

    def shares(self) -> dict[str, float]:
        """Share of each phase in the time of all steps so far."""
        clocks = self.run.engine.clocks
        total = sum(clocks.values())
        return {name: seconds / total for name, seconds in clocks.items()} if total > 0.0 else {}

    def forget(self) -> None:
        """Set the clocks of the phases to zero."""
        self.run.engine.clocks.clear()

    def passes(self) -> list[tuple[str, ...]]:
        """The loops over particles of one step, each by its verbs."""
        return [tuple(p.verbs) for p in self.run.plan.schedule.phases if p.kind == "particles"]

    def near_contact(self) -> float:
        """Share of the particles in blocks that reach shared nodes, which go through two more loops; as of the last step."""
        engine = self.run.engine
        if engine.contact is None:
            return 0.0
        near = zip(engine.places.blocks, engine.contact.near_any, strict=True)
        return float(sum((b.starts[1:] - b.starts[:-1])[marks > 0].sum() for b, marks in near) / self.particles)

    def field_numbers(self) -> dict[str, int]:
        """Stored numbers of each particle field of the first body's material."""
        layout = self.run.plan.composition.groups[0].layout
        return {name: len(layout.stored(name)) for name in layout.fields}

    def node_numbers(self) -> int:
        """Stored numbers of a node."""
        return int(self.run.plan.node_layout.size)

    def compile_seconds(self) -> float:
        """Time spent on making or loading the compiled step so far."""
        return float(self.run.plan.compile_seconds)


def stepper(sim: Any) -> Stepper:
    """Compose a simulation and start its engine; warnings of deliberately rough compositions are dropped."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run = sim.compose()
        run.warm_up()  # compiles the step and the ledger without moving anything
    return Stepper(run)


def field_bytes(sim: Any) -> tuple[int, int]:
    """Bytes of the declared fields of all particles and of all stored nodes of one side."""
    engine = sim.compose().engine
    return sum(s.P.nbytes for s in engine.stores), sum(f.G.itemsize * f.channels * f.n_nodes for f in engine.fields)


@contextlib.contextmanager
def quiet():
    """No warnings about what the benchmarks do on purpose, such as fixed time steps far below the limit."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
