"""Checks of transfers: what a particle's new velocity must keep, at one point and in small scenes."""

from __future__ import annotations

from typing import Any

from mpmkit.interfaces import Transfer
from mpmkit.testing.calling import call
from mpmkit.testing.checks.integrators import check_angular_momentum
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.flight import check_free_fall, check_free_flight
from mpmkit.testing.points import sample
from mpmkit.testing.scenes import check_momentum

INPUTS = ("v", "v_grid", "v_smooth", "dv_grid")


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


@check("transfer", "is linear")
def is_linear(transfer: Transfer, rng: Any) -> None:
    """The velocity of a sum of states is the sum of their velocities; else momentum would depend on the observer (rounding: 1e-14)."""
    for _ in range(50):
        one, other = sample(transfer, rng), sample(transfer, rng)
        both = one | {name: one[name] + other[name] for name in INPUTS}
        found = [float(call(transfer, transfer.velocity, given)) for given in (one, other, both)]
        expect_close(found[2], found[0] + found[1], 1e-14, "velocity of the sum of two states")


@check("transfer", "free flight")
def transfer_free_flight(transfer: Transfer, rng: Any) -> None:
    """A body that nothing acts on keeps its velocity exactly, with MUSL. Tolerance (rounding): 1e-12."""
    from mpmkit import integrators

    check_free_flight(integrator=integrators.MUSL(transfer))


@check("transfer", "free fall", once=True)
def transfer_free_fall(transfer: Transfer, rng: Any) -> None:
    """Under gravity all particles gain g t, to rounding (1e-12), with MUSL."""
    from mpmkit import integrators

    check_free_fall(integrator=integrators.MUSL(transfer))


@check("transfer", "momentum is conserved")
def transfer_momentum(transfer: Transfer, rng: Any) -> None:
    """A trembling body that nothing acts on keeps its momentum. Tolerance (rounding): 1e-13 of the sum of all momenta."""
    check_momentum(transfer)


@check("transfer", "angular momentum is conserved where claimed", when=lambda transfer: transfer.angular_momentum)
def transfer_angular_momentum(transfer: Transfer, rng: Any) -> None:
    """A trembling body keeps its angular momentum, with MUSL and quadratic B-splines. Tolerance (rounding): 1e-12 of all moments."""
    check_angular_momentum(transfer)


@check("transfer", "describes its maps", once=True)
def transfer_facts(transfer: Transfer, rng: Any) -> None:
    """``affine``, ``gradient`` and ``passes`` are known words and numbers, and fit each other and the kernel."""
    name = type(transfer).__name__
    expect(transfer.affine in ("none", "moment", "gradient"), f"{name}.affine is {transfer.affine!r}")
    expect(transfer.gradient in ("shape", "moment"), f"{name}.gradient is {transfer.gradient!r}")
    expect(transfer.gradient == "shape" or transfer.affine == "moment", f"{name} takes gradients from moments it does not carry")
    expect(transfer.passes >= 1, f"{name}.passes is {transfer.passes}")
    expect(
        "v_smooth" not in transfer.velocity.arguments or transfer.passes > 1, f"{name} asks for v_smooth, which exists for passes > 1 only"
    )
