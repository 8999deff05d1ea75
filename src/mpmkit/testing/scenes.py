"""The smallest scene that uses a component, whatever its kind; run as plain Python in a fraction of a second."""

from __future__ import annotations

import os
import typing
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import attrs
import numpy as np

from mpmkit.errors import CompositionError
from mpmkit.interfaces import Component, ConstitutiveModel
from mpmkit.parameters import Vector, example_arguments, specs
from mpmkit.testing.calling import call
from mpmkit.testing.collect import expect
from mpmkit.testing.element import Array, start

DENSITY = 1000.0
MACH = 0.02
"""Speed of the particles in units of the wave speed."""
CELLS = {"1D": (20,), "plane strain": (20, 2), "axisymmetric": (20, 2), "3D": (6, 2, 2)}
"""Twenty cells are three blocks in two dimensions, so that two threads have something to share."""
H = 0.1


@contextmanager
def plain_python() -> Iterator[None]:
    """Compose without compilation: a few particles and steps are done before a compiler has started."""
    before = os.environ.get("NUMBA_DISABLE_JIT")
    os.environ["NUMBA_DISABLE_JIT"] = "1"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # coarse scenes make the ledger warn; what matters is compared
            yield
    finally:
        if before is None:
            del os.environ["NUMBA_DISABLE_JIT"]
        else:
            os.environ["NUMBA_DISABLE_JIT"] = before


def standard_space(component: Component) -> str:
    """Plane strain if the component works there, for which examples of vectors are written; else the first space that will do."""
    spaces = ["plane strain"] * ("plane strain" in component.spaces) + list(component.spaces)
    return next((space for space in spaces if not has_no_place(component, space)), spaces[0])


def has_no_place(component: Any, space: str) -> bool:
    """A layer on a face that a space of fewer dimensions does not have."""
    named = (*(getattr(component, "faces", None) or ()), getattr(component, "face", None))
    return component.kind == "boundary" and any(face and face[0] in "xyz"[len(CELLS[space]) :] for face in named)


def fitted(component: Any, dim: int) -> Any:
    """The component with its vectors cut or filled up with zeros to `dim` numbers."""
    changes = {}
    for name, (attribute, _) in specs(type(component)).items():
        value = getattr(component, name)
        if isinstance(value, tuple) and (
            Vector in (attribute.type, *typing.get_args(attribute.type)) or name in getattr(component, "values", ())
        ):
            changes[name] = (value + (0.0,) * dim)[:dim]
    return attrs.evolve(component, **changes) if changes else component


def rubber(speed: float = 0.0) -> ConstitutiveModel:
    """An elastic law whose waves are fifty times faster than `speed`."""
    from mpmkit.materials import NeoHookean

    made: ConstitutiveModel = NeoHookean(E=DENSITY * (50.0 * max(speed, 1.0)) ** 2, nu=0.3, rho=DENSITY)
    return made


def wave_speed(material: ConstitutiveModel) -> float:
    """Of the material at rest [m/s]."""
    return float(call(material, material.wave_speed, start(material, np.eye(3), 1e-3)))


def scene(component: Any, space: str | None = None, *, precision: str = "float64", records: tuple[Any, ...] = ()) -> Any:
    """A simulation of a trembling body, one particle in each cell, that uses `component`.

    Contact gets two bodies that run against each other; a layer on faces or in a region a body that fills the domain.
    """
    import mpmkit as mpm
    from mpmkit import integrators, shapes

    space = space or standard_space(component)
    cells = CELLS[space]
    dim = len(cells)
    component = fitted(component, dim)
    kind = component.kind
    lower = np.zeros(dim)
    lower[0] = 1.0 if space == "axisymmetric" else 0.0  # away from the axis, which would need a condition
    on_nodes = kind == "boundary" and component.constrain is not None
    room = 0 if on_nodes else 3  # cells between body and domain
    size = (np.array(cells) + 2 * room) * H
    grid = mpm.Grid(tuple(lower), tuple(lower + size), H, coordinates="axisymmetric" if space == "axisymmetric" else "cartesian")
    choices: dict[str, Any] = {"shape": shapes.QuadraticBSpline(), "integrator": integrators.MUSL()}
    if kind in ("shape", "integrator"):
        choices[kind] = component
    elif kind == "transfer":
        choices["integrator"] = integrators.MUSL(component)
    elif kind == "discretization":
        choices = {"discretization": component}
    sim = mpm.Simulation(grid, precision=precision, **choices)
    speed = component.speed() if kind == "boundary" else 0.0
    material = component if kind == "material" else rubber(speed)
    name = getattr(component, "body", "body")
    low, high = lower + room * H, lower + size - room * H
    v = MACH * wave_speed(material)
    if kind == "contact":
        middle = 0.5 * (low[0] + high[0])
        for k, (a, b, way) in enumerate(((low[0], middle, 1.0), (middle, high[0], -1.0))):
            box = mpm.Box((a, *low[1:]), (b, *high[1:]))
            sim += mpm.Body(box, material, trembling(dim, v, way * v), particles_per_cell=1, name=f"body{k + 1}")
    else:
        sim += mpm.Body(mpm.Box(tuple(low), tuple(high)), material, trembling(dim, v), particles_per_cell=1, name=name)
    if kind in ("contact", "boundary", "effect"):
        sim += component
    for record in records:
        sim += record
    return sim


def trembling(dim: int, size: float, drift: float = 0.0) -> tuple[str, ...]:
    """Formulas of a velocity that differs from particle to particle, in all directions, of about `size`."""
    return tuple(f"{drift if not a else 0.0!r} + {size!r}*sin({7 + 4 * a}*x{' + 5*y' if dim > 1 else ''} + {a})" for a in range(dim))


def advance(sim: Any, steps: int, threads: int = 1) -> Any:
    """Run that many steps, all of the size of the first; returns the composed run."""
    from mpmkit._core.running.timestep import next_step

    with plain_python():
        run = sim.compose()
        dt = next_step(run.engine).dt
        sim.run(until=run.engine.t + steps * dt, quiet=True, threads=threads)
    return run


def fields(sim: Any) -> dict[str, Array]:
    """All stored fields of all bodies, by body and field."""
    return {f"{store.name}.{field}": np.array(store.get(field)) for store in sim.compose().engine.stores for field in store.available()}


def refused_variant(component: Component, error: CompositionError) -> bool:
    """Whether `component` differs from its examples, so that a composition with it may be refused."""
    return component != type(component)(**example_arguments(type(component)))


def difference(found: dict[str, Array], wanted: dict[str, Array]) -> str:
    """Names of what is not the same to the bit, with the largest difference; "" if nothing is."""
    if set(found) != set(wanted):
        return f"other fields: {', '.join(sorted(set(found) ^ set(wanted)))}"
    told = []
    for name, value in wanted.items():
        if found[name].shape != value.shape:
            told.append(f"{name} has the shape {found[name].shape} instead of {value.shape}")
        elif found[name].tobytes() != value.tobytes():
            told.append(f"{name} by {float(np.max(np.abs(np.asarray(found[name], float) - np.asarray(value, float)))):.3g}")
    return ", ".join(told)


def check_momentum(component: Any, steps: int = 4) -> Any:
    """Momentum changes by the impulses in the ledger only; tolerance (rounding): 1e-13 of the sum of all momenta. Returns the run."""
    sim = scene(component)
    run = advance(sim, steps)
    error = run.momentum_error()
    expect(error <= 1e-13, f"{error:.3g} of the momentum appeared or was lost in {steps} steps, without an impulse")
    return run
