"""The recipe of one step, as a list of verbs."""

from __future__ import annotations

from typing import Any

from mpmkit.testing.collect import expect

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
