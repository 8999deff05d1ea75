"""Checks of constitutive models along paths of deformation: where the work goes, and the yield surface."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import ConstitutiveModel
from mpmkit.testing.calling import call
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.element import History, drive, start, straight
from mpmkit.testing.paths import has, random_stretch, round_trip, wander


@check("material", "work is stored or dissipated", when=has("energy"))
def work_is_stored_or_dissipated(material: ConstitutiveModel, rng: Any) -> None:
    """Along a path the work of the stress is the change of stored energy plus the dissipation."""
    check_balance(drive(material, straight(random_stretch(rng, 5e-3), 400)))


def check_balance(history: History) -> None:
    """Tolerance (rate): first order in the strain of 5e-3 and in its 400 steps, 2.5 % of what was stored and dissipated."""
    stored, lost, work = history.energy[-1] - history.energy[0], history.dissipation[-1], history.work[-1]
    expect(work > 0.0, f"deforming from the start needs work, got {work:g} J/m^3")
    expect_close(work, stored + lost, 0.025 * (abs(stored) + abs(lost)), f"work against stored {stored:.6g} + dissipated {lost:.6g} J/m^3")


@check("material", "dissipation never decreases", when=has("dissipation"))
def dissipation_never_decreases(material: ConstitutiveModel, rng: Any) -> None:
    """Along a round trip and three random paths of 3 % strain, loading and unloading; exactly."""
    for path in (round_trip(rng, 0.03), *(wander(rng, 0.03) for _ in range(3))):
        lost = drive(material, path).dissipation
        expect(np.diff(lost).min() >= 0.0, f"dissipation falls by {-np.diff(lost).min():g} J/m^3 in a step")
        expect(lost[-1] > 0.0, "a law with dissipation dissipates nothing on a closed path of 3 % strain; choose examples that do")


@check("material", "stays on or inside the yield surface", when=has("yield_function"))
def stays_on_or_inside_the_yield_surface(material: ConstitutiveModel, rng: Any) -> None:
    """``yield_function`` <= 0 along a round trip and two random paths that yield. Tolerance (rounding): 1e-9 of the largest stress."""
    assert material.yield_function is not None
    for path in (round_trip(rng, 0.03), *(wander(rng, 0.03) for _ in range(2))):
        history = drive(material, path)
        largest, values = float(np.abs(history.stress).max()), []
        for n, F in enumerate(path):
            state = {name: tuple(v[n]) if v.ndim > 1 else float(v[n]) for name, v in history.state.items()}
            point = start(material, F, 1e-3) | state | {"stress": tuple(history.stress[n])}
            values.append(float(call(material, material.yield_function, point)))
        expect(max(values) <= 1e-9 * largest, f"the yield function reaches {max(values):g} Pa at step {int(np.argmax(values))}")
        expect(max(values) >= -1e-9 * largest, "3 % strain does not reach the yield surface; choose examples that do")
