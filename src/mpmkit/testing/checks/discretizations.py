"""Checks of discretizations: the recipe, stored operators, and what they keep in small scenes."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import Discretization
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.flight import check_free_fall, check_free_flight
from mpmkit.testing.recipes import NEEDED, check_recipe, recipe
from mpmkit.testing.scenes import check_momentum, scene, standard_space
from mpmkit.testing.time_order import check_time_order


def stores(discretization: Discretization) -> bool:
    """Condition: neighbour lists are made once."""
    return discretization.operator == "stored"


def in_the_plane(discretization: Discretization) -> bool:
    """Condition: works where the free flight is."""
    return "plane strain" in discretization.spaces


@check("discretization", "recipe is complete and in order")
def discretization_recipe(discretization: Discretization, rng: Any) -> None:
    """The verbs every discretization needs, in an order that makes sense, and the same ones every time."""
    check_recipe(discretization, NEEDED)
    name = type(discretization).__name__
    expect(discretization.operator in ("grid", "stored"), f"{name}.operator is {discretization.operator!r}")
    expect(discretization.configuration in ("current", "reference"), f"{name}.configuration is {discretization.configuration!r}")
    expect(recipe(discretization) == recipe(discretization), f"{name}.step writes another recipe when it is called again")


@check("discretization", "stored operators are consistent", when=stores)
def stored_operators_are_consistent(discretization: Discretization, rng: Any) -> None:
    """In every space: lists of ``nodes_per_point`` nodes that exist, all nodes used, volumes positive and in sum that of the body;
    weights add up to 1 and interpolate places, gradients add up to 0 and differentiate places to the identity.

    Tolerance (rounding): 1e-12 of sizes of the body. The body is left as it was.
    """
    name = type(discretization).__name__
    for space in discretization.spaces:
        sim = scene(discretization, space)
        grid, body = sim.grid, sim.bodies[0]
        before = repr(body)
        points = sim.discretization.mesh(grid, body)
        expect(repr(body) == before, f"{name}.mesh changes the body it is given")
        n, m, dim = len(points.x), discretization.nodes_per_point(grid.dim), grid.dim
        shapes = {"connectivity": (n, m), "N": (n, m), "dN": (n, m, dim), "V0": (n,), "x": (n, dim), "nodes": (len(points.nodes), dim)}
        for field, wanted in shapes.items():
            expect(
                np.shape(getattr(points, field)) == wanted,
                f"{space}: {field} has the shape {np.shape(getattr(points, field))}, not {wanted}",
            )
        used = np.unique(points.connectivity)
        expect(
            np.array_equal(used, np.arange(len(points.nodes))), f"{space}: connectivity must name every node, 0 to {len(points.nodes) - 1}"
        )
        expect(np.all(points.V0 > 0.0), f"{space}: a point has the volume {points.V0.min():g}")
        if space != "axisymmetric":  # whose volumes are those of rings
            volume = float(np.prod(np.subtract(*reversed(body.geometry.bounds()))))
            expect_close(points.V0.sum(), volume, 1e-12 * volume, f"{space}: volume of all points")
        places = points.nodes[points.connectivity]
        expect_close(points.N.sum(axis=1), np.ones(n), 1e-12, f"{space}: sum of weights")
        expect_close(
            np.einsum("pi,pia->pa", points.N, places), points.x, 1e-12 * float(np.abs(places).max()), f"{space}: interpolated places"
        )
        expect_close(points.dN.sum(axis=1), np.zeros((n, dim)), 1e-12 / grid.h, f"{space}: sum of gradients")
        identity = np.broadcast_to(np.eye(dim), (n, dim, dim))
        expect_close(np.einsum("pia,pib->pab", places, points.dN), identity, 1e-11, f"{space}: gradient of the places")


@check("discretization", "free flight", when=in_the_plane)
def discretization_free_flight(discretization: Discretization, rng: Any) -> None:
    """A body that nothing acts on keeps its velocity exactly. Tolerance (rounding): 1e-12."""
    check_free_flight(discretization=discretization)


@check("discretization", "free fall", when=in_the_plane)
def discretization_free_fall(discretization: Discretization, rng: Any) -> None:
    """Under gravity all points gain g t, to rounding (1e-12), and their places follow to half a step."""
    check_free_fall(discretization=discretization)


@check("discretization", "momentum is conserved")
def discretization_momentum(discretization: Discretization, rng: Any) -> None:
    """A trembling body that nothing acts on keeps its momentum. Tolerance (rounding): 1e-13 of the sum of all momenta."""
    check_momentum(discretization)


@check("discretization", "order in time as claimed", when=lambda d: d.time_order > 0 and hasattr(d, "dt"), once=True)
def discretization_time_order(discretization: Discretization, rng: Any) -> None:
    """The observed order over four step sizes is at least ``time_order`` - 0.1, for a vibrating bar on one mesh (rate)."""
    expect(
        "1D" in discretization.spaces,
        f"order in time is observed in 1D; {type(discretization).__name__} works in {standard_space(discretization)}",
    )
    check_time_order(discretization.time_order, discretization=discretization)
