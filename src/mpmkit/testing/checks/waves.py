"""Checks of what constitutive models say about the time step: wave speed and diffusivity against the tangent."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from mpmkit.interfaces import ConstitutiveModel
from mpmkit.testing.calling import call
from mpmkit.testing.collect import check, expect
from mpmkit.testing.element import Array, advance, drive, exponential, matrix, start, straight
from mpmkit.testing.paths import SLOW, has, modulus, random_stretch, turned


@check("material", "wave speed bounds the acoustic tensor")
def wave_speed_bounds_the_acoustic_tensor(material: ConstitutiveModel, rng: Any) -> None:
    """rho c^2 is at least the largest eigenvalue of the acoustic tensor in any direction, and at the start at most four times that.

    At the start, in random states of up to 20 % strain and shear, and all over the declared range: at its corners, and at random principal
    stretches and axes. The tensor is that of the tangent, found numerically.

    Tolerance (rate): 1e-6 of the modulus, of the central differences with strains of 1e-5.
    """
    scale = modulus(material)
    corners = [np.diag(corner) for corner in product(material.stretches, repeat=3)]
    states = [exponential(random_stretch(rng, size)) for size in (0.0, 0.02, 0.1, 0.2)]
    states += [turned(rng, A) for A in (*corners[:4], *corners[-1:], *(np.diag(rng.uniform(*material.stretches, 3)) for _ in range(4)))]
    for k, F in enumerate(states):
        point = end_of(material, straight(F - np.eye(3), 20))
        speed = float(call(material, material.wave_speed, point))
        bound = material.rho / point["J"] * speed**2
        directions = [*rng.normal(size=(8, 3)), *np.linalg.eigh(F @ F.T)[1].T]
        largest = max(stiffest(material, point, n / np.linalg.norm(n)) for n in directions)
        expect(
            bound >= largest * (1.0 - 1e-6) - 1e-6 * scale,
            f"rho c^2 = {bound:.6g} Pa < {largest:.6g} Pa, the stiffness of a wave at F = {F.tolist()}",
        )
        expect(
            k > 0 or bound <= 4.0 * largest,
            f"rho c^2 = {bound:.6g} Pa at the start, more than 4 x {largest:.6g} Pa: the time step would be too short",
        )


def end_of(material: ConstitutiveModel, path: Array) -> dict[str, Any]:
    """A point at the end of a slow path."""
    history = drive(material, path, SLOW)
    point = start(material, path[-1], SLOW)
    point |= {name: tuple(v[-1].tolist()) if v.ndim > 1 else float(v[-1]) for name, v in history.state.items()}
    return point | {"stress": tuple(history.stress[-1].tolist())}


def stiffest(material: ConstitutiveModel, point: dict[str, Any], n: Array, eps: float = 1e-5) -> float:
    """Largest real part of the eigenvalues of Q_ak = d(sigma_ab n_b) / d(grad u) : (e_k n)."""
    Q = np.zeros((3, 3))
    for k in range(3):
        H = np.outer(np.eye(3)[k], n)
        traction = [matrix(increment(material, point, sign * eps * H)) @ n for sign in (1, -1)]
        Q[:, k] = (traction[0] - traction[1]) / (2.0 * eps)
    return float(np.linalg.eigvals(Q).real.max())


def increment(material: ConstitutiveModel, point: dict[str, Any], H: Array) -> Any:
    """Stress after one more step with L dt = H."""
    F = exponential(H) @ np.reshape(point["F"], (3, 3))
    moved = point | {"F": tuple(F.ravel().tolist()), "J": float(np.linalg.det(F)), "L": tuple((H / SLOW).ravel().tolist())}
    advance(material, material.stress, moved)
    return moved["stress"]


@check("material", "diffusivity is finite and not negative", when=has("diffusivity"))
def diffusivity_is_finite(material: ConstitutiveModel, rng: Any) -> None:
    """A negative or infinite diffusivity would set no time step."""
    assert material.diffusivity is not None
    value = float(call(material, material.diffusivity, end_of(material, straight(random_stretch(rng, 0.05), 20))))
    expect(0.0 <= value < np.inf, f"diffusivity is {value}")


@check("material", "diffusivity bounds the viscous stress")
def diffusivity_bounds_the_viscous_stress(material: ConstitutiveModel, rng: Any) -> None:
    """rho nu is at least the stress that a velocity gradient of 1/s adds at once, in any direction; without ``diffusivity`` it adds none.

    The time step is so short that elastic stress does not count. Tolerance (rate): 1e-6 of it, of the central differences; and the elastic
    stress of the step.
    """
    dt = 1e-12
    for size in (0.0, 0.1):
        point = end_of(material, straight(exponential(random_stretch(rng, size)) - np.eye(3), 20)) | {"dt": dt}
        nu = 0.0 if material.diffusivity is None else float(call(material, material.diffusivity, point))
        largest = max(_viscosity(material, point, n / np.linalg.norm(n)) for n in (*np.eye(3), *rng.normal(size=(6, 3))))
        bound = material.rho / point["J"] * nu
        expect(
            bound >= largest * (1.0 - 1e-6) - 10.0 * modulus(material) * dt,
            f"rho nu = {bound:.6g} Pa s < {largest:.6g} Pa s, the viscosity that the stress has; the time step would be too long",
        )


def _viscosity(material: ConstitutiveModel, point: dict[str, Any], n: Array) -> float:
    """Largest real part of the eigenvalues of d(sigma n) / d(L n) at fixed F [Pa s]."""
    Q = np.zeros((3, 3))
    for k in range(3):
        L = np.outer(np.eye(3)[k], n)
        traction = []
        for sign in (1.0, -1.0):
            moved = point | {"L": tuple((sign * L).ravel().tolist())}
            advance(material, material.stress, moved)
            traction.append(matrix(moved["stress"]) @ n)
        Q[:, k] = 0.5 * (traction[0] - traction[1])
    return float(np.linalg.eigvals(Q).real.max())
