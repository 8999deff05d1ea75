"""Checks of components of all kinds in the smallest scene that uses them: spaces, bits, threads, results, checkpoints, scene files."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from mpmkit._core.registry import entry_of
from mpmkit.errors import CompositionError
from mpmkit.interfaces import Component
from mpmkit.testing.collect import check, expect
from mpmkit.testing.element import Array
from mpmkit.testing.scenes import advance, difference, fields, fitted, has_no_place, plain_python, scene

STEPS = 2
_REFERENCE: list[tuple[Component, dict[str, Array]]] = []


def reference(component: Component) -> dict[str, Array]:
    """Fields after a run with one thread, done once for checks that follow each other."""
    if not (_REFERENCE and _REFERENCE[0][0] is component):
        sim = scene(component)
        advance(sim, STEPS)
        _REFERENCE[:] = [(component, fields(sim))]
    return _REFERENCE[0][1]


@check("all", "runs in every declared space", once=True)
def runs_in_every_declared_space(component: Component, rng: Any) -> None:
    """In each of ``spaces`` two steps of a small body are composed, run and stay finite."""
    for space in component.spaces:
        if has_no_place(component, space):
            continue
        try:
            sim = scene(component, space)
            advance(sim, 2)
        except CompositionError as error:
            raise AssertionError(f"{type(component).__name__} declares {space} and is refused there: {error}") from error
        for name, value in fields(sim).items():
            expect(np.all(np.isfinite(value)), f"{space}: {name} is not finite after two steps")


@check("all", "same scene gives the same bits", once=True)
def same_scene_gives_the_same_bits(component: Component, rng: Any) -> None:
    """A second simulation of the same scene ends in the same state, to the bit: nothing is kept from the first."""
    wanted = reference(component)
    again = scene(component)
    advance(again, STEPS)
    told = difference(fields(again), wanted)
    expect(not told, f"the same scene, run again, differs: {told}")


@check("all", "one thread equals two", once=True)
def one_thread_equals_two(component: Component, rng: Any) -> None:
    """Two threads give the bits of one. On a machine with one core nothing is compared but two runs."""
    from mpmkit._core.running.workers import available

    wanted = reference(component)
    shared = scene(component)
    advance(shared, STEPS, threads=min(2, available()))
    told = difference(fields(shared), wanted)
    expect(not told, f"two threads give another result than one: {told}")


@check("all", "results come back from a record", once=True)
def results_come_back_from_a_record(component: Component, rng: Any) -> None:
    """All fields of all particles, the component's own among them, are read from a file as they were in memory.

    Files hold single precision: what is read is the state, rounded once.
    """
    import mpmkit as mpm

    names = tuple(dict.fromkeys(name.split(".", 1)[1] for name in reference(component)))
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "run.vtkhdf")
        sim = scene(component, records=(mpm.Record(path, fields=names, checkpoint=False),))
        advance(sim, STEPS)
        last = mpm.Results(path).frames[-1]
        stores = sim.compose().engine.stores
        for name in names:
            found = np.asarray(last[name])
            wanted = np.concatenate([np.asarray(store.get(name), dtype=found.dtype) for store in stores])
            expect(np.array_equal(found, wanted), f"{name} is read back with other values than it had")


@check("all", "goes on from a checkpoint", once=True)
def goes_on_from_a_checkpoint(component: Component, rng: Any) -> None:
    """A run that is resumed ends in the state of one that was not interrupted, to the bit."""
    import mpmkit as mpm

    whole = scene(component)
    advance(whole, 2)
    middle = whole.t
    with tempfile.TemporaryDirectory() as folder, plain_python():
        record = mpm.Record(str(Path(folder) / "run.vtkhdf"))
        first = scene(component, records=(record,))
        first.run(until=middle, quiet=True, threads=1)
        whole.run(until=1.5 * middle, quiet=True, threads=1)
        second = scene(component, records=(record,)).resume(Path(folder) / "run.ckpt.h5")
        second.run(until=1.5 * middle, quiet=True, threads=1)
    told = difference(fields(second), fields(whole))
    expect(not told, f"resumed from a checkpoint, the run differs: {told}")


@check("all", "a scene file keeps it", when=lambda component: entry_of(component) is not None)
def a_scene_file_keeps_it(component: Component, rng: Any) -> None:
    """Written into a scene file and read from it, the component is equal; registered components only, files know no others."""
    from mpmkit.scene import dumps, loads

    sim = scene(component)
    again = loads(dumps(sim))
    where: Any = {
        "material": lambda s: s.bodies[0].material,
        "shape": lambda s: s.shape,
        "integrator": lambda s: s.integrator,
        "transfer": lambda s: s.integrator.transfer,
        "discretization": lambda s: s.discretization,
        "contact": lambda s: s.contacts[0],
        "boundary": lambda s: s.boundaries[0],
        "effect": lambda s: s.effects[0],
    }[component.kind]
    wanted = fitted(component, sim.grid.dim)
    expect(where(again) == wanted, f"written as a scene and read again, {wanted!r} is {where(again)!r}")
