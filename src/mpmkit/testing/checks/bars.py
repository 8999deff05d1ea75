"""Checks of the forms of constitutive models for slender bars, under uniaxial stress."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import ConstitutiveModel
from mpmkit.testing.checks.dissipation import check_balance
from mpmkit.testing.checks.waves import increment
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.element import drive, start, straight
from mpmkit.testing.paths import SLOW, has, modulus, wander


@check("material", "bar has Young's modulus of the law", when=has("bar_stress"))
def bar_has_youngs_modulus(material: ConstitutiveModel, rng: Any) -> None:
    """The slope in uniaxial stress is C11 - 2 C12^2 / (C11 + C12) of the full law. Tolerance (rate): 1e-4 for strains of 1e-6."""
    eps = 1e-6
    point = start(material, np.eye(3), SLOW)
    full = np.asarray(increment(material, point, np.diag([eps, 0, 0]))) / eps
    wanted = full[0] - 2.0 * full[1] ** 2 / (full[0] + full[1])
    found = drive(material, straight(np.diag([eps, 0, 0]), 1), SLOW, bar=True).stress[-1] / eps
    expect_close(found, [wanted, 0, 0, 0, 0, 0], 1e-4 * wanted, "stress over strain of the bar")


@check("material", "bar stores or dissipates the work", when=has("bar_stress", "bar_energy"))
def bar_stores_or_dissipates_the_work(material: ConstitutiveModel, rng: Any) -> None:
    """As for the full law, under uniaxial stress, in tension and compression."""
    for sign in (1, -1):
        check_balance(drive(material, straight(np.diag([sign * 5e-3, 0, 0]), 400), bar=True))


@check("material", "bar wave speed bounds the slope", when=has("bar_stress", "bar_wave_speed"))
def bar_wave_speed_bounds_the_slope(material: ConstitutiveModel, rng: Any) -> None:
    """rho c^2 >= d(sigma) / d(ln F_xx) all along 20 % of tension and of compression. Tolerance (rate): 1 % for steps of 0.1 % strain."""
    for sign in (1, -1):
        history = drive(material, straight(np.diag([sign * 0.2, 0, 0]), 200), SLOW, bar=True)
        slope = np.diff(history.stress[:, 0]) / np.diff(np.log(history.F[:, 0, 0]))
        bound = material.rho / history.F[:, 0, 0] * history.wave_speed**2
        expect(
            np.all(np.maximum(bound[1:], bound[:-1]) >= 0.99 * slope),
            f"rho c^2 falls below the slope of the bar by {np.max(slope / bound[1:]):.4g}",
        )


@check("material", "bar is finite over the declared range", when=has("bar_stress"))
def bar_is_finite(material: ConstitutiveModel, rng: Any) -> None:
    """As for the full law, under uniaxial stress: no stress at the start, finite to both ends of ``stretches``, wave speed positive."""
    for end in material.stretches:
        history = drive(material, straight(np.diag([end - 1.0, 0, 0]), 40), bar=True)
        expect_close(history.stress[0], np.zeros(6), 1e-13 * modulus(material), "stress of the bar at the start")
        for name in ("stress", "energy", "dissipation", "wave_speed"):
            expect(np.all(np.isfinite(getattr(history, name))), f"{name} of the bar is not finite on the way to a stretch of {end:g}")
        if material.bar_wave_speed is not None:
            expect(history.wave_speed.min() > 0.0, f"wave speed of the bar is {history.wave_speed.min():g} m/s at a stretch up to {end:g}")


@check("material", "bar dissipation never decreases", when=has("bar_stress", "bar_dissipation"))
def bar_dissipation_never_decreases(material: ConstitutiveModel, rng: Any) -> None:
    """Along random paths of 3 % strain under uniaxial stress; exactly."""
    for _ in range(3):
        lost = drive(material, wander(rng, 0.03), bar=True).dissipation
        expect(np.diff(lost).min() >= 0.0, f"dissipation of the bar falls by {-np.diff(lost).min():g} J/m^3 in a step")
        expect(lost[-1] > 0.0, "the bar dissipates nothing on a closed path of 3 % strain; choose examples that do")
