"""Checks of boundary layers in a small scene: where they act, whose momentum they take, and that walls at rest do no work."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import BoundaryLayer
from mpmkit.testing.checks.boundaries import at_rest, constrained, constrains
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.points import sample
from mpmkit.testing.scenes import advance, check_momentum, fitted, scene


def loads(layer: BoundaryLayer) -> bool:
    """Condition: the layer acts on particles."""
    return layer.load is not None


def fixed(layer: BoundaryLayer) -> bool:
    """Condition: a layer on nodes whose parameters of type `Value` are numbers."""
    values = [getattr(layer, name) for name in layer.values]
    return constrains(layer) and all(isinstance(x, float) for v in values for x in (v if isinstance(v, tuple) else (v,)))


@check("boundary", "acts on nodes that exist", when=constrains)
def acts_on_nodes_that_exist(layer: BoundaryLayer, rng: Any) -> None:
    """Either faces that the grid has, or a choice of nodes: one truth value for each, and the positions are left as they were."""
    sim = scene(layer)
    grid, layer, name = sim.grid, sim.boundaries[0], type(layer).__name__
    faces = layer.faces_of(grid)
    expect(set(faces) <= set(grid.faces), f"{name}.faces_of returns {faces}; the grid has {grid.faces}")
    x = rng.uniform(grid.lower, grid.upper, (50, grid.dim))
    kept = x.copy()
    inside = layer.nodes_in(x, 0.25)
    expect(np.array_equal(x, kept), f"{name}.nodes_in changes the positions it is given")
    expect(bool(faces) != (inside is not None), f"{name} must act either on faces or on nodes of its own choice")
    if inside is not None:
        expect(np.shape(inside) == (50,) and np.asarray(inside).dtype == bool, f"{name}.nodes_in must return bool[n], got {inside!r}")


@check("boundary", "selects particles of its body", when=loads)
def selects_particles_of_its_body(layer: BoundaryLayer, rng: Any) -> None:
    """Different numbers of particles that exist, positive areas, unit normals (or none), finite arms; the points are left as they were.

    Tolerance (rounding): 1e-12 of a unit vector.
    """
    sim = scene(layer)
    points = sim.bodies[0].sample(sim.grid)
    kept = {name: np.array(getattr(points, name)) for name in ("x", "V0", "size", "v")}
    found = sim.boundaries[0].select(points, sim.grid)
    name = type(layer).__name__
    for field, value in kept.items():
        expect(np.array_equal(getattr(points, field), value), f"{name}.select changes the particles' {field}")
    expect(found is not None, f"{name} supplies load and must select particles")
    assert found is not None
    n = len(found.chosen)
    expect(0 < n == len(set(found.chosen.tolist())), f"{name}.select returns no particle, or one of them twice")
    expect(0 <= found.chosen.min() and found.chosen.max() < points.n, f"{name}.select returns numbers of particles that do not exist")
    expect(np.shape(found.area) == (n,) and np.all(found.area > 0.0), f"{name}.select must return n positive areas")
    for what, rows in (("normals", found.normals), ("arms", found.arms)):
        expect(np.shape(rows) == (n, 3) and np.all(np.isfinite(rows)), f"{name}.select must return finite {what} float[n, 3]")
    length = np.linalg.norm(found.normals, axis=1)
    expect(np.all((np.abs(length - 1.0) < 1e-12) | (length == 0.0)), f"{name}.select returns normals of length {length.min():g}")


@check("boundary", "loads the whole face", when=lambda layer: loads(layer) and getattr(layer, "face", None) is not None)
def loads_the_whole_face(layer: Any, rng: Any) -> None:
    """The areas of all particles of a box add up to that of its face, times the number of particle rows in the layer's thickness.

    Tolerance (rounding): 1e-12 of the area.
    """
    sim = scene(layer)
    body, axis = sim.bodies[0], "xyz".index(layer.face[0])
    points = body.sample(sim.grid)
    found = sim.boundaries[0].select(points, sim.grid)
    assert found is not None
    sides = np.ptp(points.x, axis=0) + 2.0 * points.size[0]
    wanted = float(np.prod(np.delete(sides, axis)))
    expect_close(found.area.sum(), wanted, 1e-12 * wanted, "area that the layer loads")


@check("boundary", "speed bounds what it prescribes", when=fixed)
def speed_bounds_what_it_prescribes(layer: BoundaryLayer, rng: Any) -> None:
    """No component of the velocity that a node at rest is given exceeds ``speed()``, which limits the time step."""
    values = {name: getattr(fitted(layer, 3), name) for name in layer.values}
    for _ in range(20):
        v = constrained(layer, sample(layer, rng) | values | {"v": (0.0, 0.0, 0.0)})
        expect(np.abs(v).max() <= layer.speed() * (1.0 + 1e-12), f"prescribes {np.abs(v).max():g} m/s, speed() is {layer.speed():g} m/s")


@check("boundary", "impulses are booked", once=True)
def impulses_are_booked(layer: BoundaryLayer, rng: Any) -> None:
    """The momentum of a body changes by what the ledger says the layer gave. Tolerance (rounding): 1e-13 of the sum of all momenta."""
    check_momentum(layer)


@check("boundary", "a wall at rest does no work", when=at_rest)
def a_wall_at_rest_does_no_work(layer: BoundaryLayer, rng: Any) -> None:
    """What presses on it and leaves it, and slides along it, gains no energy. Tolerance (rounding): 1e-12 of the kinetic energy."""
    sim = scene(layer)
    advance(sim, 4)
    work, kinetic = sim.history["boundary_work"], sim.history["kinetic"]
    expect(work.max() <= 1e-12 * kinetic.max(), f"the wall gives {work.max():g} J to a body of {kinetic[0]:g} J")
