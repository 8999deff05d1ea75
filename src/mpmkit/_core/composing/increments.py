"""Updates of the deformation gradient over one step, F <- increment(L, dt) F, as scalar functions.

L is taken at the positions x of one end of the displacement, along which velocities are constant. With velocities that are those of a
rigid rotation there (prescribed ones), L is skew: the exponential and Cayley's midpoint form are orthogonal, the first-order form (eq 13 of
Guilkey's introduction, eq 3-13c of SAND2002-0482) gives J = (1 + w^2 dt^2)^n. A body that spins freely goes along chords:
x + dt v = R x, so that dt L = R - I is not skew but has the trace -(w dt)^2, and it is I + dt L that is orthogonal. Then the exponential
loses (w dt)^2 of J in each step, and the body swells by as much to keep its stress. `centred` takes L to the middle of the chord.
"""

from mpmkit.math import exp
from mpmkit.tensor import IDENTITY, combine, det, inverse, matmul, transpose


def first_order_increment(L, dt):
    """I + dt L."""
    return combine(1.0, IDENTITY, dt, L)


def midpoint_increment(L, dt):
    """(I - dt/2 L)^-1 (I + dt/2 L), exact for a velocity gradient that is constant in the half-step configuration."""
    return matmul(inverse(combine(1.0, IDENTITY, -0.5 * dt, L)), combine(1.0, IDENTITY, 0.5 * dt, L))


def centred(L, dt):
    """L (I + dt/2 L)^-1, the velocity gradient with respect to the middle of the displacement dt v; dt < 0 if that led to x.

    Cayley's form of it is I + dt L, or (I - |dt| L)^-1 for dt < 0: F follows the positions exactly, and a rotation along chords
    has a skew gradient (Hughes and Winget (1980), doi:10.1002/nme.1620151210).
    """
    return matmul(L, inverse(combine(1.0, IDENTITY, 0.5 * dt, L)))


def exponential_increment(L, dt):
    """exp(dt L) by its diagonal Pade approximant of degree 4, D(A)^-1 D(-A) with D(A) = I - A/2 + 3 A^2/28 - A^3/84 + A^4/1680.

    Written as I + D^-1 (D(-A) - D(A)), so that what is rounded is small when dt L is, and many steps do not add up roundings of I.

    Exactly orthogonal for a skew L whatever its size, and of positive determinant up to |dt L| = 5. The relative error is
    4e-8 |dt L|^9: rounding up to |dt L| = 1/8, 8e-11 at 1/2, 4e-8 at 1 and 2e-5 at 2 (measured). Free of branches, so that loops over
    particles vectorise, and without powers above the square of a small dt L, which would underflow in float32.

    C. Moler, C. Van Loan (2003), Nineteen dubious ways to compute the exponential of a matrix, doi:10.1137/S00361445024180, method 2
    """
    A = combine(dt, L, 0.0, IDENTITY)
    A2 = matmul(A, A)
    even = combine(1.0, IDENTITY, 1.0, matmul(A2, combine(3.0 / 28.0, IDENTITY, 1.0 / 1680.0, A2)))
    odd = matmul(A, combine(0.5, IDENTITY, 1.0 / 84.0, A2))
    return combine(1.0, IDENTITY, 2.0, matmul(inverse(combine(1.0, even, -1.0, odd)), odd))


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
