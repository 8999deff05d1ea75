"""A single material point driven along a path of deformation, in plain Python: no grid, no compilation."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpmkit.errors import ParameterError
from mpmkit.fields import Field
from mpmkit.interfaces import ConstitutiveModel
from mpmkit.testing.calling import call

Array = NDArray[np.float64]
SIZES = {"scalar": 1, "vector": 3, "symmetric": 6, "tensor": 9}


@attrs.frozen(eq=False)
class History:
    """What a point went through; entry 0 is the start.

    Attributes
    ----------
    F : float64[n, 3, 3]
        Deformation gradient.
    stress : float64[n, 6]
        Cauchy stress, xx yy zz xy yz xz [Pa].
    state : dict of str to float64[n] or float64[n, k]
        The fields that the law adds.
    work : float64[n]
        Work of the stress per initial volume [J/m^3], by the trapezoidal rule.
    energy, dissipation : float64[n]
        As the law says, per initial volume [J/m^3]; zero if it has no such kernel.
    wave_speed : float64[n]
        [m/s].
    """

    F: Array
    stress: Array
    state: dict[str, Array]
    work: Array
    energy: Array
    dissipation: Array
    wave_speed: Array


def drive(material: ConstitutiveModel, F_path: ArrayLike, dt: float = 1e-3, *, bar: bool = False) -> History:
    """Lead one material point along a path.

    Parameters
    ----------
    material : ConstitutiveModel
        The law.
    F_path : array_like[n, 3, 3]
        Deformation gradients, one for each time; the first is the start, usually the identity. In each step L is
        constant with F_new = exp(dt L) F_old.
    dt : float
        Time between two points of the path [s].
    bar : bool
        Uniaxial stress: use the kernels ``bar_stress`` and so on; only F_xx of the path counts.

    Raises
    ------
    ParameterError
        If the path has a wrong shape, inverts the material or makes steps too large for the logarithm.
    """
    path = np.asarray(F_path, dtype=float)
    if path.ndim != 3 or path.shape[1:] != (3, 3) or len(path) < 1:
        raise ParameterError(f"drive: F_path must have the shape (n, 3, 3), got {path.shape}")
    if np.any(np.linalg.det(path) <= 0.0):
        raise ParameterError(f"drive: F_path inverts the material (det F <= 0) at step {int(np.argmax(np.linalg.det(path) <= 0.0))}")
    hooks = {name: getattr(material, ("bar_" if bar else "") + name) for name in ("stress", "energy", "dissipation", "wave_speed")}
    if hooks["stress"] is None:
        raise ParameterError(f"drive: {type(material).__name__} has no kernel bar_stress for uniaxial stress; leave out bar=True")
    point = start(material, path[0], dt)
    columns: dict[str, list[Any]] = {
        name: [] for name in ("stress", "work", "energy", "dissipation", "wave_speed", *(f.name for f in material.state))
    }
    work, power = 0.0, np.zeros(3)
    for n, F in enumerate(path):
        L = np.zeros((3, 3)) if n == 0 else logarithm(F @ np.linalg.inv(path[n - 1]), n) / dt
        before = kirchhoff(point) if n else np.zeros((3, 3))
        point |= {"F": tuple(F.ravel().tolist()), "J": float(np.linalg.det(F)), "L": tuple(L.ravel().tolist()), "t": n * dt}
        advance(material, hooks["stress"], point)
        power = 0.5 * (before + kirchhoff(point)) * L
        work += dt * float(np.sum(power))
        columns["stress"].append(point["stress"])
        columns["work"].append(work)
        for name in ("energy", "dissipation", "wave_speed"):
            columns[name].append(call(material, hooks[name], point) if hooks[name] is not None else 0.0)
        for field in material.state:
            columns[field.name].append(point[field.name])
    out = {name: np.asarray(values, dtype=float) for name, values in columns.items()}
    state = {field.name: out[field.name] for field in material.state}
    return History(path, out["stress"], state, out["work"], out["energy"], out["dissipation"], out["wave_speed"])


def start(material: ConstitutiveModel, F: ArrayLike, dt: float) -> dict[str, Any]:
    """A point without stress, with the initial state: everything a kernel of a constitutive model may ask for."""
    F = np.asarray(F, dtype=float)
    point: dict[str, Any] = {"F": tuple(F.ravel().tolist()), "J": float(np.linalg.det(F)), "L": (0.0,) * 9, "stress": (0.0,) * 6}
    point |= {"dt": dt, "t": 0.0, "h": 0.1, "dim": 3.0}
    return point | {field.name: initial(field) for field in material.state}


def initial(field: Field) -> Any:
    """Initial value of a state field: a number, or a tuple with this number in each component."""
    return field.initial if field.shape == "scalar" else (field.initial,) * SIZES[field.shape]


def advance(material: ConstitutiveModel, kernel: Any, point: dict[str, Any]) -> None:
    """Call the stress kernel and put the new stress and state into `point`."""
    result = call(material, kernel, point)
    if not material.state:
        point["stress"] = result
        return
    point["stress"] = result[0]
    for field, value in zip(material.state, result[1:], strict=True):
        point[field.name] = value


def matrix(stress: Any) -> Array:
    """3 x 3 matrix of six components."""
    xx, yy, zz, xy, yz, xz = stress
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], dtype=float)


def kirchhoff(point: dict[str, Any]) -> Array:
    """J sigma, the stress whose work counts per initial volume."""
    return float(point["J"]) * matrix(point["stress"])


def logarithm(A: Array, step: int = 0) -> Array:
    """Logarithm of a 3 x 3 matrix near the identity, log A = 2 artanh((A - I) (A + I)^-1), by its series."""
    eye = np.eye(3)
    X = (A - eye) @ np.linalg.inv(A + eye)
    size = float(np.linalg.norm(X))
    if size > 0.5:
        raise ParameterError(
            f"drive: step {step} of the path is too large (|F_new F_old^-1 - I| = {np.linalg.norm(A - eye):.3g}); use smaller steps"
        )
    square, term, total, k = X @ X, X, X.copy(), 1
    while np.linalg.norm(term) > 1e-18 and k < 80:
        k += 2
        term = term @ square
        total += term / k
    return 2.0 * total


def exponential(A: Array) -> Array:
    """Exponential of a small 3 x 3 matrix, by its series."""
    term, total = np.eye(3), np.eye(3)
    for k in range(1, 30):
        term = term @ A / k
        total = total + term
    return total


def straight(A: ArrayLike, steps: int) -> Array:
    """Path from the identity to I + A in equal steps."""
    path: Array = np.eye(3) + np.linspace(0.0, 1.0, steps + 1)[:, None, None] * np.asarray(A, dtype=float)
    return path
