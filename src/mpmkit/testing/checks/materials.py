"""Checks of constitutive models at single points: reference state, symmetry of the observer, range, and energy."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from mpmkit.interfaces import ConstitutiveModel
from mpmkit.testing.calling import call, flat
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.element import SIZES, advance, drive, exponential, matrix, start, straight
from mpmkit.testing.paths import SLOW, energy_of_deformation, modulus, random_stretch, turned


@check("material", "returns stress and state")
def returns_stress_and_state(material: ConstitutiveModel, rng: Any) -> None:
    """Six numbers, and one value of the declared shape for each state field."""
    point = start(material, exponential(random_stretch(rng, 0.05)), 1e-3)
    result = call(material, material.stress, point)
    stress, state = (result[0], result[1:]) if material.state else (result, ())
    name = type(material).__name__
    expect(len(flat(stress)) == 6, f"{name}.stress must return xx, yy, zz, xy, yz, xz, got {stress!r}")
    expect(
        len(state) == len(material.state), f"{name}.stress must return the stress and {len(material.state)} state values, got {len(state)}"
    )
    for field, value in zip(material.state, state, strict=True):
        expect(len(flat(value)) == SIZES[field.shape], f"{name}.stress returns {value!r} for the {field.shape} {field.name}")


@check("material", "stress-free at the start")
def stress_free_at_the_start(material: ConstitutiveModel, rng: Any) -> None:
    """No stress, energy or dissipation without deformation. Tolerance (rounding): 1e-13 of the modulus."""
    history = drive(material, np.eye(3)[None].repeat(3, axis=0))
    scale = modulus(material)
    expect_close(history.stress, np.zeros((3, 6)), 1e-13 * scale, "stress at F = I")
    expect_close(history.energy, np.zeros(3), 1e-13 * scale, "stored energy at F = I")
    expect_close(history.dissipation, np.zeros(3), 1e-13 * scale, "dissipation at F = I")


@check("material", "objectivity")
def objectivity(material: ConstitutiveModel, rng: Any) -> None:
    """A stretched point that is turned by 40 degrees has the turned stress, and the same energy, wave speed and scalars of its state.

    Tolerance (rate): 1e-4 of the stress for 200 steps; an incremental rotation has an error of order (angle of a step)^2.
    """
    F1 = np.eye(3) + random_stretch(rng, 0.05)
    axis = rng.normal(size=3)
    x, y, z = np.deg2rad(40.0) * axis / np.linalg.norm(axis) / 200
    small_turn = exponential(np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]))
    stretch = [*straight(F1 - np.eye(3), 50), F1]  # the last step holds, so that viscous stress is gone
    turned, turn = [F1], np.eye(3)
    for _ in range(200):
        turn = small_turn @ turn
        turned.append(turn @ F1)
    before = drive(material, stretch)
    after = drive(material, [*stretch, *turned[1:]])
    size = float(np.linalg.norm(before.stress[-1]))
    wanted = turn @ matrix(before.stress[-1]) @ turn.T
    expect_close(matrix(after.stress[-1]), wanted, 1e-4 * size + 1e-12 * modulus(material), "stress after the rotation")
    scalars = {"stored energy": (before.energy, after.energy), "wave speed": (before.wave_speed, after.wave_speed)}
    scalars |= {f.name: (before.state[f.name], after.state[f.name]) for f in material.state if f.shape == "scalar"}
    for name, (old, new) in scalars.items():
        expect_close(new[-1], old[-1], 1e-4 * abs(old[-1]) + 1e-12 * modulus(material), f"{name} after the rotation")


@check("material", "finite over the declared range")
def finite_over_the_declared_range(material: ConstitutiveModel, rng: Any) -> None:
    """Stress, energies and wave speed are finite, and the wave speed is positive, up to all corners of ``stretches``, and in shear."""
    low, high = material.stretches
    expect(0.0 < low < 1.0 < high, f"{type(material).__name__}.stretches must be a range around 1, got {material.stretches}")
    shear = min(high - 1.0 / high, 1.0 / low - low)  # whose principal stretches are in the range
    ends = [turned(rng, np.diag(corner)) for corner in product((low, high), repeat=3)]
    ends += [np.eye(3) + np.outer(np.eye(3)[a], np.eye(3)[b]) * shear for a, b in ((0, 1), (2, 1))]
    for F in ends:
        history = drive(material, straight(F - np.eye(3), 40))
        for name in ("stress", "energy", "dissipation", "wave_speed"):
            expect(np.all(np.isfinite(getattr(history, name))), f"{name} is not finite on the way to F = {F.tolist()}")
        expect(history.wave_speed.min() > 0.0, f"wave speed {history.wave_speed.min():g} on the way to F = {F.tolist()}")


@check("material", "stress is the derivative of the energy", when=energy_of_deformation)
def stress_is_the_derivative_of_the_energy(material: ConstitutiveModel, rng: Any) -> None:
    """sigma = dW/dF F^T / J, by central differences.

    Tolerance (rate): 1e-7 of the modulus for the differences; for a law of small strain moreover 10 times strain times stress, as it
    distinguishes no configurations.
    """
    assert material.energy is not None
    size = 0.2 if material.finite_strain else 1e-3
    scale = modulus(material)
    for _ in range(3):
        F = np.eye(3) + random_stretch(rng, size)
        P = np.zeros((3, 3))
        for i in range(9):
            step = np.zeros(9)
            step[i] = 1e-4 * size
            ahead, behind = (
                float(call(material, material.energy, start(material, F + sign * step.reshape(3, 3), SLOW))) for sign in (1, -1)
            )
            P.flat[i] = (ahead - behind) / (2.0 * step[i])
        point = start(material, F, SLOW)
        advance(material, material.stress, point)
        found = matrix(point["stress"])
        small = 0.0 if material.finite_strain else 10.0 * size * float(np.abs(found).max())
        expect_close(found, P @ F.T / np.linalg.det(F), 1e-7 * scale + small, "Cauchy stress")
