"""Checks of contact algorithms between two bodies on the grid."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import ContactAlgorithm
from mpmkit.kernels import Kernel
from mpmkit.testing.calling import call
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.scenes import advance, check_momentum, fields, scene

STEPS = 4


@check("contact", "a collision conserves momentum")
def a_collision_conserves_momentum(contact: ContactAlgorithm, rng: Any) -> None:
    """Two trembling bodies run against each other. Tolerance (rounding): 1e-13 of the sum of all momenta."""
    check_momentum(contact, STEPS)


@check("contact", "bodies in another order")
def bodies_in_another_order(contact: ContactAlgorithm, rng: Any) -> None:
    """A scene with the bodies added the other way round ends in the same state. Tolerance (rounding): 1e-12 of the largest number."""
    one, other = scene(contact), scene(contact)
    other.bodies.reverse()
    for sim in (one, other):
        advance(sim, STEPS)
    found = fields(other)
    for name, wanted in fields(one).items():
        expect_close(found[name], wanted, 1e-12 * (1.0 + float(np.abs(wanted).max())), f"{name} with the bodies in another order")


@check("contact", "the kernel sees unit normals and finite gaps")
def the_kernel_sees_unit_normals(contact: ContactAlgorithm, rng: Any) -> None:
    """What the core gives to ``impulse`` in a collision: unit normals, positive masses, and a and b in one order for the whole scene.

    Tolerance (rounding): 1e-12 of a unit vector.
    """
    seen: list[Any] = []

    def watched(m_a: Any, v_a: Any, m_b: Any, v_b: Any, normal: Any, gap: Any, dt: Any) -> Any:
        seen.append((m_a, m_b, normal, gap))
        given = {"m_a": m_a, "v_a": v_a, "m_b": m_b, "v_b": v_b, "normal": normal, "gap": gap, "dt": dt}
        return call(contact, contact.impulse, given)

    sim = scene(contact)
    sim.contacts[0] = type(type(contact).__name__, (type(contact),), {"impulse": Kernel(watched)})(**contact.parameters())
    advance(sim, STEPS)
    expect(seen, "two bodies run against each other, and impulse is never asked")
    for m_a, m_b, normal, gap in seen:
        expect(m_a > 0.0 and m_b > 0.0 and np.isfinite(gap), f"masses {m_a:g} and {m_b:g} kg, gap {gap:g} m")
        expect_close(np.linalg.norm(normal), 1.0, 1e-12, "length of the normal")
    ways = {bool(normal[0] > 0.0) for *_, normal, _ in seen}
    expect(len(ways) == 1, "of two bodies side by side, a is sometimes the left one and sometimes the right one")
