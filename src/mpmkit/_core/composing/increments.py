"""Updates of the deformation gradient over one step, F <- increment(L, dt) F, as scalar functions.

The first-order form (eq 13 of Guilkey's introduction, eq 3-13c of SAND2002-0482) inflates a rotating body, J =
(1 + w^2 dt^2)^n; the exponential and Cayley's midpoint form are orthogonal for a skew L.
"""

from mpmkit.math import exp
from mpmkit.tensor import IDENTITY, combine, det, inverse, matmul, transpose


def first_order_increment(L, dt):
    """I + dt L."""
    return combine(1.0, IDENTITY, dt, L)


def midpoint_increment(L, dt):
    """(I - dt/2 L)^-1 (I + dt/2 L), exact for a velocity gradient that is constant in the half-step configuration."""
    return matmul(inverse(combine(1.0, IDENTITY, -0.5 * dt, L)), combine(1.0, IDENTITY, 0.5 * dt, L))


def exponential_increment(L, dt):
    """exp(dt L) by a Taylor series of order 8 of dt L / 2^s, |dt L| / 2^s < 1/8, squared s times: error below 1e-13.

    Below |dt L| = 1e-4 three terms are exact to rounding (and higher powers would underflow in float32).
    """
    size = dt * (abs(L[0]) + abs(L[1]) + abs(L[2]) + abs(L[3]) + abs(L[4]) + abs(L[5]) + abs(L[6]) + abs(L[7]) + abs(L[8]))
    if size < 1e-4:
        A = combine(dt, L, 0.0, IDENTITY)
        A2 = matmul(A, A)
        return combine(1.0, combine(1.0, IDENTITY, 1.0, A), 1.0, combine(0.5, A2, 1.0 / 6.0, matmul(A, A2)))
    squarings = 0
    while size > 0.125 and squarings < 16:
        size = 0.5 * size
        dt = 0.5 * dt
        squarings += 1
    A = combine(dt, L, 0.0, IDENTITY)
    A2 = matmul(A, A)
    A4 = matmul(A2, A2)
    # I + A + A^2/2 + A^3/6 + A^4 (I/24 + A/120 + A^2/720 + A^3/5040 + A^4/40320), with A^3 = A A^2
    A3 = matmul(A, A2)
    low = combine(1.0, combine(1.0, IDENTITY, 1.0, A), 1.0, combine(0.5, A2, 1.0 / 6.0, A3))
    high = combine(1.0, combine(1.0 / 24.0, IDENTITY, 1.0 / 120.0, A), 1.0, combine(1.0 / 720.0, A2, 1.0 / 5040.0, A3))
    E = combine(1.0, low, 1.0, matmul(A4, combine(1.0, high, 1.0 / 40320.0, A4)))
    for _ in range(squarings):
        E = matmul(E, E)
    return E


def first_order_volume_ratio(L, dt):
    """det(I + dt L)."""
    return det(first_order_increment(L, dt))


def midpoint_volume_ratio(L, dt):
    """Determinant of the midpoint increment."""
    return det(midpoint_increment(L, dt))


def exponential_volume_ratio(L, dt):
    """det exp(dt L) = exp(dt tr L)."""
    return exp(dt * (L[0] + L[4] + L[8]))


def first_piola(s, F):
    """P = J sigma F^-T from the Cauchy stress (six components)."""
    S = (s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2])
    J = det(F)
    return combine(J, matmul(S, transpose(inverse(F))), 0.0, S)


def reference_step(F, D, dt):
    """F + dt D for the material velocity gradient D = grad_X v, and L = D F^-1 in the middle of the step."""
    F1 = combine(1.0, F, dt, D)
    return F1, matmul(D, inverse(combine(0.5, F, 0.5, F1)))
