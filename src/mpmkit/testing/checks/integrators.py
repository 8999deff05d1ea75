"""Checks of integrators: the recipe, and what it keeps in small scenes."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from mpmkit.errors import CompositionError
from mpmkit.interfaces import Integrator, Transfer
from mpmkit.testing.collect import check, expect
from mpmkit.testing.flight import check_free_fall, check_free_flight
from mpmkit.testing.recipes import NEEDED, check_recipe, recipe
from mpmkit.testing.scenes import check_momentum, plain_python, refused_variant, scene
from mpmkit.testing.time_order import check_time_order


def carries(integrator: Integrator) -> bool:
    """Condition: a claim of angular momentum that can be tried, with a transfer that makes the same claim."""
    return integrator.angular_momentum and (claiming(integrator) is not None)


def claiming(integrator: Any) -> Any:
    """The integrator with its own transfer if that claims to conserve angular momentum, else with APIC; None if it has no transfer."""
    from mpmkit import integrators

    transfer = getattr(integrator, "transfer", None)
    if not isinstance(transfer, Transfer):
        return None
    return integrator if transfer.angular_momentum else attrs.evolve(integrator, transfer=integrators.APIC())


def may_be_refused(integrator: Integrator, run: Any) -> None:
    """Run a check; a choice beside the defaults may be refused, with a reason, when it is composed."""
    try:
        run()
    except CompositionError as error:
        if not refused_variant(integrator, error):
            raise


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
    """A body that nothing acts on keeps its velocity exactly. Tolerance (rounding): 1e-12."""
    may_be_refused(integrator, lambda: check_free_flight(integrator=integrator))


@check("integrator", "free fall")
def integrator_free_fall(integrator: Integrator, rng: Any) -> None:
    """Under gravity all particles gain g t, to rounding (1e-12), and their places follow to half a step."""
    may_be_refused(integrator, lambda: check_free_fall(integrator=integrator))


@check("integrator", "momentum is conserved")
def integrator_momentum(integrator: Integrator, rng: Any) -> None:
    """A trembling body that nothing acts on keeps its momentum. Tolerance (rounding): 1e-13 of the sum of all momenta."""
    may_be_refused(integrator, lambda: check_momentum(integrator))


@check("integrator", "angular momentum is conserved where claimed", when=carries)
def integrator_angular_momentum(integrator: Integrator, rng: Any) -> None:
    """A trembling body keeps its angular momentum with a transfer that claims the same. Tolerance (rounding): 1e-12 of all moments."""
    may_be_refused(integrator, lambda: check_angular_momentum(claiming(integrator)))


def check_angular_momentum(component: Any, steps: int = 5) -> None:
    """Angular momentum of a trembling body in the ledger, affine velocity fields included, stays as it is."""
    sim = scene(component, "plane strain" if "plane strain" in component.spaces else "3D")
    with plain_python():
        run = sim.compose()
        from mpmkit._core.running.timestep import next_step

        sim.run(until=steps * next_step(run.engine).dt, quiet=True, threads=1)
    p, rows = sim.particles(), sim.history
    scale = float((p["m"] * np.linalg.norm(p["x"], axis=1) * np.linalg.norm(p["v"], axis=1)).sum())
    for axis in ("angular_x", "angular_y", "angular_z"):
        change = abs(float(rows[axis][-1] - rows[axis][0]))
        expect(change <= 1e-12 * scale, f"{axis} changes by {change / scale:.3g} of the sum of all moments of momentum in {steps} steps")


@check("integrator", "order in time as claimed", when=lambda i: i.time_order > 0 and hasattr(i, "dt"), once=True)
def integrator_time_order(integrator: Integrator, rng: Any) -> None:
    """The observed order over four step sizes is at least ``time_order`` - 0.1, for a vibrating bar on one grid (rate)."""
    check_time_order(integrator.time_order, integrator=integrator)
