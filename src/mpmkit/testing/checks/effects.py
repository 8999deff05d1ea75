"""Checks of effects: accelerations, body forces, viscous pressures."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import Effect
from mpmkit.testing.calling import call, flat, kernels_of
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.points import sample

POINTS = 100


@check("effect", "supplies a hook", once=True)
def supplies_a_hook(effect: Effect, rng: Any) -> None:
    """An effect without a hook has no effect."""
    expect(kernels_of(effect), f"{type(effect).__name__} supplies no kernel")
    expect(effect.work in ("external", "dissipated"), f"{type(effect).__name__}.work is {effect.work!r}")


@check("effect", "finite")
def finite(effect: Effect, rng: Any) -> None:
    """All hooks, at random points, with the number of results that the interface asks for."""
    sizes = {"acceleration": 3, "body_force": 3, "viscous_pressure": 1, "signal_speed": 1}
    for _ in range(POINTS):
        given = sample(effect, rng)
        for hook, kernel in kernels_of(effect).items():
            result = flat(call(effect, kernel, given))
            expect(np.all(np.isfinite(result)), f"{hook} is not finite: {result}")
            expect(len(result) <= 3 if sizes.get(hook) == 3 else len(result) == 1, f"{hook} returns {len(result)} numbers")


@check("effect", "viscous pressure only in compression", when=lambda effect: effect.viscous_pressure is not None)
def viscous_pressure_only_in_compression(effect: Effect, rng: Any) -> None:
    """q >= 0, and q = 0 in expansion: it dissipates and never pulls."""
    assert effect.viscous_pressure is not None
    acted = False
    for _ in range(POINTS):
        given = sample(effect, rng)
        q = float(call(effect, effect.viscous_pressure, given))
        rate = given["L"][0] + given["L"][4] + given["L"][8]
        expect(q >= 0.0, f"viscous pressure {q:g} Pa < 0 at div v = {rate:g} 1/s")
        expect(q == 0.0 or rate < 0.0, f"viscous pressure {q:g} Pa in expansion, div v = {rate:g} 1/s")
        acted = acted or q > 0.0
    expect(acted, "no viscous pressure in any of the compressions tried; choose examples that act")


@check("effect", "signal is not slower than the wave", when=lambda effect: effect.signal_speed is not None)
def signal_is_not_slower(effect: Effect, rng: Any) -> None:
    """The speed that replaces c in the time step is at least c."""
    assert effect.signal_speed is not None
    for _ in range(POINTS):
        given = sample(effect, rng)
        speed = float(call(effect, effect.signal_speed, given))
        expect(speed >= given["c"] * (1.0 - 1e-12), f"signal speed {speed:g} m/s is below the wave speed {given['c']:g} m/s")


@check("effect", "damping brakes", when=lambda effect: effect.work == "dissipated" and effect.acceleration is not None)
def damping_brakes(effect: Effect, rng: Any) -> None:
    """What is booked as dissipated takes energy: acceleration . v <= 0, and nothing acts at rest."""
    assert effect.acceleration is not None
    for _ in range(POINTS):
        given = sample(effect, rng)
        a = np.array(call(effect, effect.acceleration, given))
        expect(a @ given["v"] <= 0.0, f"acceleration . v = {a @ given['v']:g} > 0")
        expect_close(call(effect, effect.acceleration, given | {"v": (0.0, 0.0, 0.0)}), np.zeros(3), 0.0, "acceleration at rest")


@check("effect", "rates are rates")
def rates_are_rates(effect: Effect, rng: Any) -> None:
    """Limits of the time step are finite and not negative, and have names."""
    for rule, rate in effect.rates().items():
        expect(rule and 0.0 <= rate < np.inf, f"rate {rule!r} is {rate}")


@check("effect", "rates keep damping stable", when=lambda effect: effect.work == "dissipated" and effect.acceleration is not None)
def rates_keep_damping_stable(effect: Effect, rng: Any) -> None:
    """In a time step of 1 / rate, the longest that ``rates`` allows, no node becomes faster. Tolerance (rounding): 1e-12."""
    assert effect.acceleration is not None
    rate = max(effect.rates().values(), default=0.0)
    dt = 1.0 / rate if rate > 0.0 else 1.0
    for _ in range(POINTS):
        given = sample(effect, rng)
        v = np.array(given["v"])
        after = v + dt * np.array(call(effect, effect.acceleration, given))
        fast = float(np.linalg.norm(after) / np.linalg.norm(v))
        expect(fast <= 1.0 + 1e-12, f"a step of {dt:g} s, which rates() allows, makes a node {fast:.3g} times as fast")
