"""Checks of contact algorithms, on pairs of nodal velocities."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import ContactAlgorithm
from mpmkit.testing.calling import call
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.element import Array
from mpmkit.testing.points import sample

PAIRS = 200


def impulse(contact: ContactAlgorithm, given: dict[str, Any]) -> Array:
    """The impulse on body a."""
    return np.array(call(contact, contact.impulse, given), dtype=float)


def approach(given: dict[str, Any]) -> float:
    """Speed at which a moves towards b."""
    return float(np.dot(np.subtract(given["v_a"], given["v_b"]), given["normal"]))


def momentum(given: dict[str, Any]) -> float:
    """Scale of the impulses: reduced mass times relative speed."""
    reduced = given["m_a"] * given["m_b"] / (given["m_a"] + given["m_b"])
    return float(reduced * np.linalg.norm(np.subtract(given["v_a"], given["v_b"])))


@check("contact", "no pull")
def no_pull(contact: ContactAlgorithm, rng: Any) -> None:
    """Bodies that separate feel nothing, and no impulse pulls. Tolerance (rounding): 1e-13 of the momentum."""
    for _ in range(PAIRS):
        given = sample(contact, rng)
        p = impulse(contact, given)
        expect(p @ given["normal"] <= 1e-13 * momentum(given), f"normal impulse {p @ given['normal']:g} N s pulls body a towards b")
        if approach(given) < 0.0 and given["gap"] > 0.0:
            expect_close(p, np.zeros(3), 1e-13 * momentum(given), f"impulse on bodies that separate with a gap of {given['gap']:g} m")


@check("contact", "no effect at a distance")
def no_effect_at_a_distance(contact: ContactAlgorithm, rng: Any) -> None:
    """A gap that the bodies cannot close in the step keeps them free."""
    for _ in range(PAIRS):
        given = sample(contact, rng) | {"gap": 1.0, "dt": 1e-3}
        expect_close(impulse(contact, given), np.zeros(3), 0.0, "impulse over a gap of 1 m at about 1 m/s and dt = 1e-3 s")


@check("contact", "acts on overlapping bodies that approach")
def acts_on_overlap(contact: ContactAlgorithm, rng: Any) -> None:
    """Contact that never acts would pass all other checks."""
    for _ in range(PAIRS):
        given = sample(contact, rng) | {"gap": -0.01}
        if approach(given) > 0.1:
            expect(
                impulse(contact, given) @ given["normal"] < 0.0,
                f"no impulse on overlapping bodies that approach at {approach(given):g} m/s",
            )


@check("contact", "equal under swap")
def equal_under_swap(contact: ContactAlgorithm, rng: Any) -> None:
    """Which body is called a does not matter. Tolerance (rounding): 1e-13 of the momentum."""
    for _ in range(PAIRS):
        given = sample(contact, rng)
        swapped = given | {"m_a": given["m_b"], "m_b": given["m_a"], "v_a": given["v_b"], "v_b": given["v_a"]}
        swapped["normal"] = tuple(-c for c in given["normal"])
        expect_close(impulse(contact, swapped), -impulse(contact, given), 1e-13 * momentum(given), "impulse after renaming the bodies")


@check("contact", "seen alike by a moving observer")
def seen_alike_by_a_moving_observer(contact: ContactAlgorithm, rng: Any) -> None:
    """Only the relative velocity counts. Tolerance (rounding): 1e-12 of the momentum, for a common velocity of some 10 m/s."""
    for _ in range(PAIRS):
        given = sample(contact, rng)
        shift = 10.0 * rng.normal(size=3)
        moving = given | {name: tuple(np.add(given[name], shift).tolist()) for name in ("v_a", "v_b")}
        masses = given["m_a"] * given["m_b"] / (given["m_a"] + given["m_b"])
        expect_close(
            impulse(contact, moving),
            impulse(contact, given),
            1e-12 * masses * (1.0 + float(np.linalg.norm(shift))),
            "impulse in a moving frame",
        )


@check("contact", "friction is bounded", when=lambda contact: isinstance(getattr(contact, "friction", None), float))
def friction_is_bounded(contact: Any, rng: Any) -> None:
    """The tangential impulse is at most friction times the normal one and opposes sliding. Tolerance (rounding): 1e-12 of the momentum."""
    for _ in range(PAIRS):
        given = sample(contact, rng)
        p, n = impulse(contact, given), np.array(given["normal"])
        u = np.subtract(given["v_a"], given["v_b"])
        tangential = p - (p @ n) * n
        slack = 1e-12 * momentum(given)
        expect(
            np.linalg.norm(tangential) <= contact.friction * abs(p @ n) + slack,
            f"tangential impulse {np.linalg.norm(tangential):g} N s exceeds friction",
        )
        expect(tangential @ u <= slack, "the tangential impulse pushes in the direction of sliding")


@check("contact", "no energy from friction and impact")
def no_energy_from_contact(contact: ContactAlgorithm, rng: Any) -> None:
    """Bodies that just touch do not leave with more kinetic energy. Tolerance (rounding): 1e-12 of the energy."""
    for _ in range(PAIRS):
        given = sample(contact, rng) | {"gap": 0.0}
        p = impulse(contact, given)
        m_a, m_b, v_a, v_b = given["m_a"], given["m_b"], np.array(given["v_a"]), np.array(given["v_b"])
        before = 0.5 * m_a * v_a @ v_a + 0.5 * m_b * v_b @ v_b
        after = 0.5 * m_a * np.sum((v_a + p / m_a) ** 2) + 0.5 * m_b * np.sum((v_b - p / m_b) ** 2)
        expect(after <= before * (1.0 + 1e-12), f"kinetic energy grows from {before:g} to {after:g} J")
