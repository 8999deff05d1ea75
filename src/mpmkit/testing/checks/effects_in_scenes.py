"""Checks of effects in a small scene: what they change, what they keep, and that a scene without them knows nothing of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import Effect
from mpmkit.testing.collect import check, expect
from mpmkit.testing.scenes import advance, check_momentum, difference, fields, scene

STEPS = 3


def only_inside(effect: Effect) -> bool:
    """Condition: neither accelerates nodes nor pulls particles, so that only forces between particles can change."""
    return effect.acceleration is None and effect.body_force is None


def dissipates(effect: Effect) -> bool:
    """Condition: its work is counted as dissipated."""
    return effect.work == "dissipated" or effect.viscous_pressure is not None


def without(effect: Effect) -> Any:
    """The scene of the effect, without it."""
    sim = scene(effect)
    sim.effects.clear()
    return sim


@check("effect", "acts", once=True)
def acts(effect: Effect, rng: Any) -> None:
    """A trembling body ends in another state than without the effect."""
    one, other = scene(effect), without(effect)
    for sim in (one, other):
        advance(sim, STEPS)
    plain = fields(other)
    found = {name: value for name, value in fields(one).items() if name in plain}
    expect(difference(found, plain), f"{type(effect).__name__} changes nothing in a body that trembles; choose examples that act")


@check("effect", "a scene without it knows nothing of it", once=True)
def a_scene_without_it_knows_nothing_of_it(effect: Effect, rng: Any) -> None:
    """Before and after a run with the effect, a scene without it has the same step, the same fields and the same bits."""
    before = without(effect)
    advance(before, STEPS)
    advance(scene(effect), STEPS)
    after = without(effect)
    advance(after, STEPS)
    told = difference(fields(after), fields(before))
    expect(not told, f"after a run with {type(effect).__name__} a scene without it differs: {told}")
    texts = [sim.compose().plan.text for sim in (before, after)]
    expect(texts[0] == texts[1], f"after a run with {type(effect).__name__} the step of a scene without it is another one")
    expect(type(effect).__name__ not in texts[1], f"the step of a scene without {type(effect).__name__} names it")


@check("effect", "impulses are booked", once=True)
def impulses_are_booked(effect: Effect, rng: Any) -> None:
    """The momentum of the body changes by the impulse of the effect in the ledger. Tolerance (rounding): 1e-13 of all momenta."""
    check_momentum(effect)


@check("effect", "inner forces keep momentum", when=only_inside)
def inner_forces_keep_momentum(effect: Effect, rng: Any) -> None:
    """An effect without ``acceleration`` and ``body_force`` gives no impulse at all. Tolerance (rounding): 1e-13 of all momenta."""
    run = check_momentum(effect)
    given = max(abs(run.ledger.last[f"force_impulse_{a}"]) for a in "xyz")
    scale = sum(float((s.get("m")[:, None] * np.abs(s.get("v"))).sum()) for s in run.engine.stores)
    expect(given <= 1e-13 * scale, f"{type(effect).__name__} acts between particles only, and gives an impulse of {given:g} N s")


@check("effect", "dissipation never decreases", when=dissipates)
def dissipation_never_decreases(effect: Effect, rng: Any) -> None:
    """What is counted as dissipated grows from step to step in a trembling body; the effect never gives energy back."""
    sim = scene(effect)
    lost = []
    for _ in range(STEPS):
        run = advance(sim, 1)
        lost.append(run.ledger.last["dissipated"])
    expect(np.diff([0.0, *lost]).min() >= 0.0, f"dissipated energy falls: {', '.join(f'{x:.6g}' for x in lost)} J after each step")
    expect(lost[-1] > 0.0, f"{type(effect).__name__} is said to dissipate and dissipates nothing; choose examples that do")
