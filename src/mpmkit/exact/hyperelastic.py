"""The two neo-Hookean forms as array functions, apart from the kernels of the components, so that both can be compared.

"quadratic": W = lam/4 (J^2 - 1) - (lam/2 + mu) ln J + mu/2 (tr C - 3);
"log":       W = lam/2 (ln J)^2  -              mu ln J + mu/2 (tr C - 3).
For both P = (c(J) - mu) F^-T + mu F, with c = lam/2 (J^2 - 1) and c = lam ln J.
"""

from __future__ import annotations

import numpy as np

from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.exact.solution import Array

FORMS = ("quadratic", "log")


def lame(E: float, nu: float) -> tuple[float, float]:
    """Lame's constants (lambda, mu) [Pa] from Young's modulus E [Pa] > 0 and Poisson's ratio -1 < nu < 0.5.

    Raises
    ------
    ParameterError
        If E or nu is out of range.
    """
    if not E > 0.0:
        raise ParameterError(f"lame: E must be > 0, got {E:g} (Young's modulus [Pa])")
    if not -1.0 < nu < 0.5:
        raise ParameterError(f"lame: nu must be > -1, < 0.5, got {nu:g} (Poisson's ratio [1])")
    return E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), E / (2.0 * (1.0 + nu))


def volume_coefficients(lam: float, form: str) -> tuple[float, float]:
    """Coefficients (a, q) of c(J) = a ln J + q/2 (J^2 - 1): one formula for both forms, so J c'(J) = a + q J^2.

    Raises
    ------
    ParameterError
        If `form` is unknown.
    """
    if form not in FORMS:
        raise ParameterError(f"form must be one of {', '.join(map(repr, FORMS))}, got {form!r}{did_you_mean(form, FORMS)}")
    return (lam, 0.0) if form == "log" else (0.0, lam)


def energy(F: Array, lam: float, mu: float, form: str) -> Array:
    """Stored energy per reference volume W, float64[n] [J/m^3], of deformation gradients F, float64[n, 3, 3]."""
    a, q = volume_coefficients(lam, form)
    J = np.linalg.det(F)
    volumetric = 0.5 * a * np.log(J) ** 2 + 0.25 * q * (J**2 - 1.0) - 0.5 * q * np.log(J)
    return np.asarray(volumetric - mu * np.log(J) + 0.5 * mu * (np.einsum("nij,nij->n", F, F) - 3.0))


def first_piola(F: Array, lam: float, mu: float, form: str) -> Array:
    """First Piola-Kirchhoff stress dW/dF, float64[n, 3, 3] [Pa], of deformation gradients F, float64[n, 3, 3]."""
    a, q = volume_coefficients(lam, form)
    J = np.linalg.det(F)
    c = a * np.log(J) + 0.5 * q * (J**2 - 1.0)
    return np.asarray((c - mu)[:, None, None] * np.linalg.inv(F).transpose(0, 2, 1) + mu * F)


def cauchy(F: Array, lam: float, mu: float, form: str) -> Array:
    """Cauchy stress P F^T / J, float64[n, 3, 3] [Pa], of deformation gradients F, float64[n, 3, 3]."""
    return np.asarray(first_piola(F, lam, mu, form) @ F.transpose(0, 2, 1) / np.linalg.det(F)[:, None, None])


def embed(F: Array) -> Array:
    """Deformation gradients float64[n, dim, dim] as float64[n, 3, 3], with no strain in the missing directions."""
    full = np.tile(np.eye(3), (len(F), 1, 1))
    full[:, : F.shape[1], : F.shape[2]] = F
    return full
