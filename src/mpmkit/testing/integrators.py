"""Checks of integrators, transfers and discretizations: recipes, and what a transfer must leave alone."""

from __future__ import annotations

from typing import Any

from mpmkit.errors import CompositionError
from mpmkit.interfaces import Discretization, Integrator, Transfer
from mpmkit.parameters import example_arguments
from mpmkit.testing.calling import call
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.flight import check_free_flight

NEEDED = ("forces", "momentum", "contact", "boundary", "strain", "stress")
"""Verbs without which bodies, contact or boundary layers of a scene would have no effect."""


def recipe(component: Any) -> list[str]:
    """The verbs of one step."""
    from mpmkit.interfaces.recipe import Recipe

    written = Recipe()
    component.step(written)
    return written.verbs


def check_recipe(component: Any, needed: tuple[str, ...]) -> None:
    """Verbs that must be there, and that come after what they need."""
    name, verbs = type(component).__name__, recipe(component)
    for verb in needed:
        expect(verb in verbs, f"{name}.step never calls {verb}: what a scene asks of it would be ignored")
    last = {verb: len(verbs) - 1 - verbs[::-1].index(verb) for verb in verbs}
    for first, then in (("forces", "momentum"), ("momentum", "contact"), ("momentum", "boundary"), ("strain", "stress")):
        # an integrator that strains first makes contact and boundaries twice: the last one must follow the momentum update
        expect(verbs.index(first) < last[then], f"{name}.step does not call {then} after {first}")


@check("integrator", "recipe is complete and in order")
def integrator_recipe(integrator: Integrator, rng: Any) -> None:
    """Particles to grid first, momentum from forces, then contact and boundaries, then back to the particles."""
    check_recipe(integrator, ("p2g", *NEEDED, "g2p", "advect"))
    verbs = recipe(integrator)
    expect(verbs[0] == "p2g", f"{type(integrator).__name__}.step must begin with p2g, begins with {verbs[0]}")
    updated = verbs[verbs.index("momentum") :]
    for verb in ("g2p", "advect"):
        between = updated[: updated.index(verb)] if verb in updated else []
        expect(
            "boundary" in between and "contact" in between,
            f"{type(integrator).__name__}.step must call contact and boundary between momentum and {verb}",
        )


@check("integrator", "same recipe every time")
def same_recipe_every_time(integrator: Integrator, rng: Any) -> None:
    """The recipe is written once, when a simulation is composed, and must not depend on how often it was asked for."""
    expect(recipe(integrator) == recipe(integrator), f"{type(integrator).__name__}.step writes another recipe when it is called again")


@check("integrator", "free flight")
def integrator_free_flight(integrator: Integrator, rng: Any) -> None:
    """A body that nothing acts on keeps its velocity exactly.

    A choice beside the defaults may be refused, with a reason, when it is composed.
    """
    try:
        check_free_flight(integrator=integrator)
    except CompositionError:
        if integrator == type(integrator)(**example_arguments(type(integrator))):
            raise


@check("discretization", "recipe is complete and in order")
def discretization_recipe(discretization: Discretization, rng: Any) -> None:
    """The verbs every discretization needs, in an order that makes sense."""
    check_recipe(discretization, NEEDED)
    name = type(discretization).__name__
    expect(discretization.operator in ("grid", "stored"), f"{name}.operator is {discretization.operator!r}")
    expect(discretization.configuration in ("current", "reference"), f"{name}.configuration is {discretization.configuration!r}")


@check("transfer", "keeps a constant velocity")
def keeps_a_constant_velocity(transfer: Transfer, rng: Any) -> None:
    """Where particle, grid and filtered grid have one velocity and nothing accelerates, it stays. Tolerance (rounding): 1e-15."""
    for velocity in rng.uniform(-1.0, 1.0, 50):
        given = {"v": velocity, "v_grid": velocity, "v_smooth": velocity, "dv_grid": 0.0}
        expect_close(call(transfer, transfer.velocity, given), velocity, 1e-15, "particle velocity")


@check("transfer", "falls freely")
def falls_freely(transfer: Transfer, rng: Any) -> None:
    """A uniform change of velocity reaches the particles in full. Tolerance (rounding): 1e-15."""
    for velocity, change in rng.uniform(-1.0, 1.0, (50, 2)):
        given = {"v": velocity, "v_grid": velocity + change, "v_smooth": velocity, "dv_grid": change}
        expect_close(call(transfer, transfer.velocity, given), velocity + change, 1e-15, "particle velocity")


@check("transfer", "free flight")
def transfer_free_flight(transfer: Transfer, rng: Any) -> None:
    """A body that nothing acts on keeps its velocity exactly, with MUSL."""
    from mpmkit import integrators

    check_free_flight(integrator=integrators.MUSL(transfer))


@check("transfer", "declared facts are known words", once=True)
def transfer_facts(transfer: Transfer, rng: Any) -> None:
    """``affine`` and ``passes``."""
    name = type(transfer).__name__
    expect(transfer.affine in ("none", "moment", "gradient"), f"{name}.affine is {transfer.affine!r}")
    expect(transfer.gradient in ("shape", "moment"), f"{name}.gradient is {transfer.gradient!r}")
    expect(transfer.gradient == "shape" or transfer.affine == "moment", f"{name} takes gradients from moments it does not carry")
    expect(transfer.passes >= 1, f"{name}.passes is {transfer.passes}")
    expect(
        "v_smooth" not in transfer.velocity.arguments or transfer.passes > 1, f"{name} asks for v_smooth, which exists for passes > 1 only"
    )
