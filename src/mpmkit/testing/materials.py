"""Checks of constitutive models, on single points driven along paths of deformation."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import ConstitutiveModel
from mpmkit.testing.calling import call, flat
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.element import SIZES, Array, History, advance, drive, exponential, matrix, start, straight

SLOW = 1e6
"""A time step [s] so long that viscous stress does not count beside elastic stress."""


def modulus(material: ConstitutiveModel) -> float:
    """The scale of all stresses: rho c^2 at the start [Pa]."""
    return material.rho * float(drive(material, np.eye(3)[None]).wave_speed[0]) ** 2


def random_stretch(rng: Any, size: float) -> Array:
    """Matrix of small random entries."""
    return np.asarray(size * rng.uniform(-1.0, 1.0, (3, 3)))


def round_trip(rng: Any, size: float, steps: int = 200) -> Array:
    """Path that loads, unloads beyond the start and comes back."""
    A = random_stretch(rng, size)
    s = np.concatenate([np.linspace(0, 1, steps), np.linspace(1, -1, 2 * steps)[1:], np.linspace(-1, 0, steps)[1:]])
    return np.asarray(np.eye(3) + s[:, None, None] * A)


def has(*names: str) -> Any:
    """Condition: the law supplies these kernels."""
    return lambda material: all(getattr(material, name) is not None for name in names)


def energy_of_deformation(material: ConstitutiveModel) -> bool:
    """Condition: stored energy is a function of F or J alone."""
    return material.energy is not None and not {"stress", "L", *(f.name for f in material.state)} & set(material.energy.arguments)


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
    """A stretched point that is turned by 40 degrees has the turned stress and the same state.

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
    expect_close(
        after.energy[-1], before.energy[-1], 1e-4 * abs(before.energy[-1]) + 1e-12 * modulus(material), "stored energy after the rotation"
    )


@check("material", "finite over stretches")
def finite_over_stretches(material: ConstitutiveModel, rng: Any) -> None:
    """Stress, energies and wave speed are finite, and the wave speed is positive, for stretches from 0.7 to 1.4 and shear up to 0.7."""
    for A in (
        np.diag([0.4, 0, 0]),
        np.diag([-0.3, 0, 0]),
        np.diag([0.4, 0.4, 0.4]),
        -0.3 * np.eye(3),
        np.array([[0, 0.7, 0], [0, 0, 0], [0, 0, 0.0]]),
    ):
        history = drive(material, straight(A, 40))
        for name in ("stress", "energy", "dissipation", "wave_speed"):
            values = getattr(history, name)
            expect(np.all(np.isfinite(values)), f"{name} is not finite on the way to F = I + {A.tolist()}")
        expect(history.wave_speed.min() > 0.0, f"wave speed {history.wave_speed.min():g} on the way to F = I + {A.tolist()}")


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


@check("material", "work is stored or dissipated", when=has("energy"))
def work_is_stored_or_dissipated(material: ConstitutiveModel, rng: Any) -> None:
    """Along a path the work of the stress is the change of stored energy plus the dissipation."""
    _balance(drive(material, straight(random_stretch(rng, 5e-3), 400)))


def _balance(history: History) -> None:
    """Tolerance (rate): first order in the strain of 5e-3 and in its 400 steps, 2.5 % of what was stored and dissipated."""
    stored, lost, work = history.energy[-1] - history.energy[0], history.dissipation[-1], history.work[-1]
    expect(work > 0.0, f"deforming from the start needs work, got {work:g} J/m^3")
    expect_close(work, stored + lost, 0.025 * (abs(stored) + abs(lost)), f"work against stored {stored:.6g} + dissipated {lost:.6g} J/m^3")


@check("material", "dissipation never decreases", when=has("dissipation"))
def dissipation_never_decreases(material: ConstitutiveModel, rng: Any) -> None:
    """Over a round trip of 3 % strain, loading and unloading."""
    lost = drive(material, round_trip(rng, 0.03)).dissipation
    expect(np.diff(lost).min() >= 0.0, f"dissipation falls by {-np.diff(lost).min():g} J/m^3 in a step")
    expect(lost[-1] > 0.0, "a law with dissipation dissipates nothing over a round trip of 3 % strain; choose examples that do")


@check("material", "stays on or inside the yield surface", when=has("yield_function"))
def stays_on_or_inside_the_yield_surface(material: ConstitutiveModel, rng: Any) -> None:
    """``yield_function`` <= 0 along a round trip that yields. Tolerance (rounding): 1e-9 of the largest stress."""
    assert material.yield_function is not None
    path = round_trip(rng, 0.03)
    history = drive(material, path)
    largest, values = float(np.abs(history.stress).max()), []
    for n, F in enumerate(path):
        state = {name: tuple(v[n]) if v.ndim > 1 else float(v[n]) for name, v in history.state.items()}
        values.append(
            float(call(material, material.yield_function, start(material, F, 1e-3) | state | {"stress": tuple(history.stress[n])}))
        )
    expect(max(values) <= 1e-9 * largest, f"the yield function reaches {max(values):g} Pa at step {int(np.argmax(values))}")
    expect(max(values) >= -1e-9 * largest, "3 % strain does not reach the yield surface; choose examples that do")


@check("material", "wave speed bounds the acoustic tensor")
def wave_speed_bounds_the_acoustic_tensor(material: ConstitutiveModel, rng: Any) -> None:
    """rho c^2 is at least the largest eigenvalue of the acoustic tensor in any direction, and at the start at most four times that.

    Tolerance (rate): 1e-6 of the modulus, of the central differences with strains of 1e-5.
    """
    scale = modulus(material)
    for k, size in enumerate((0.0, 0.02, 0.1, 0.1, 0.2, 0.2)):
        F = exponential(random_stretch(rng, size))
        path = straight(F - np.eye(3), 20)
        point = _end(material, path)
        speed = float(call(material, material.wave_speed, point))
        bound = material.rho / point["J"] * speed**2
        largest = max(_largest(material, point, n / np.linalg.norm(n)) for n in rng.normal(size=(12, 3)))
        expect(
            bound >= largest * (1.0 - 1e-6) - 1e-6 * scale,
            f"rho c^2 = {bound:.6g} Pa < {largest:.6g} Pa, the stiffness of a wave at F = {F.tolist()}",
        )
        expect(
            k > 0 or bound <= 4.0 * largest,
            f"rho c^2 = {bound:.6g} Pa at the start, more than 4 x {largest:.6g} Pa: the time step would be too short",
        )


def _end(material: ConstitutiveModel, path: Array) -> dict[str, Any]:
    """A point at the end of a slow path."""
    history = drive(material, path, SLOW)
    point = start(material, path[-1], SLOW)
    point |= {name: tuple(v[-1].tolist()) if v.ndim > 1 else float(v[-1]) for name, v in history.state.items()}
    return point | {"stress": tuple(history.stress[-1].tolist())}


def _largest(material: ConstitutiveModel, point: dict[str, Any], n: Array, eps: float = 1e-5) -> float:
    """Largest real part of the eigenvalues of Q_ak = d(sigma_ab n_b) / d(grad u) : (e_k n)."""
    Q = np.zeros((3, 3))
    for k in range(3):
        H = np.outer(np.eye(3)[k], n)
        traction = [matrix(_increment(material, point, sign * eps * H)) @ n for sign in (1, -1)]
        Q[:, k] = (traction[0] - traction[1]) / (2.0 * eps)
    return float(np.linalg.eigvals(Q).real.max())


def _increment(material: ConstitutiveModel, point: dict[str, Any], H: Array) -> Any:
    """Stress after one more step with L dt = H."""
    F = exponential(H) @ np.reshape(point["F"], (3, 3))
    moved = point | {"F": tuple(F.ravel().tolist()), "J": float(np.linalg.det(F)), "L": tuple((H / SLOW).ravel().tolist())}
    advance(material, material.stress, moved)
    return moved["stress"]


@check("material", "diffusivity is finite and not negative", when=has("diffusivity"))
def diffusivity_is_finite(material: ConstitutiveModel, rng: Any) -> None:
    """A negative or infinite diffusivity would set no time step."""
    assert material.diffusivity is not None
    value = float(call(material, material.diffusivity, _end(material, straight(random_stretch(rng, 0.05), 20))))
    expect(0.0 <= value < np.inf, f"diffusivity is {value}")


@check("material", "bar has Young's modulus of the law", when=has("bar_stress"))
def bar_has_youngs_modulus(material: ConstitutiveModel, rng: Any) -> None:
    """The slope in uniaxial stress is C11 - 2 C12^2 / (C11 + C12) of the full law. Tolerance (rate): 1e-4 for strains of 1e-6."""
    eps = 1e-6
    point = start(material, np.eye(3), SLOW)
    full = np.asarray(_increment(material, point, np.diag([eps, 0, 0]))) / eps
    wanted = full[0] - 2.0 * full[1] ** 2 / (full[0] + full[1])
    found = drive(material, straight(np.diag([eps, 0, 0]), 1), SLOW, bar=True).stress[-1] / eps
    expect_close(found, [wanted, 0, 0, 0, 0, 0], 1e-4 * wanted, "stress over strain of the bar")


@check("material", "bar stores or dissipates the work", when=has("bar_stress", "bar_energy"))
def bar_stores_or_dissipates_the_work(material: ConstitutiveModel, rng: Any) -> None:
    """As for the full law, under uniaxial stress, in tension and compression."""
    for sign in (1, -1):
        _balance(drive(material, straight(np.diag([sign * 5e-3, 0, 0]), 400), bar=True))


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
