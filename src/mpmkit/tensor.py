"""The words a constitutive law is written in, on plain tuples.

A 3 x 3 tensor is a tuple of nine numbers, row by row: (xx, xy, xz, yx, yy, yz, zx, zy, zz).
A symmetric tensor is a tuple of six in the order xx, yy, zz, xy, yz, xz.
All functions are scalar, pure and free of branches where possible, so that the scheduler can compile them.
"""

from mpmkit.math import sqrt

IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def det(A):
    """Determinant of a 3 x 3 tensor."""
    return (
        A[0] * (A[4] * A[8] - A[5] * A[7])
        - A[1] * (A[3] * A[8] - A[5] * A[6])
        + A[2] * (A[3] * A[7] - A[4] * A[6])
    )


def matmul(A, B):
    """Product A B of two 3 x 3 tensors."""
    return (
        A[0] * B[0] + A[1] * B[3] + A[2] * B[6],
        A[0] * B[1] + A[1] * B[4] + A[2] * B[7],
        A[0] * B[2] + A[1] * B[5] + A[2] * B[8],
        A[3] * B[0] + A[4] * B[3] + A[5] * B[6],
        A[3] * B[1] + A[4] * B[4] + A[5] * B[7],
        A[3] * B[2] + A[4] * B[5] + A[5] * B[8],
        A[6] * B[0] + A[7] * B[3] + A[8] * B[6],
        A[6] * B[1] + A[7] * B[4] + A[8] * B[7],
        A[6] * B[2] + A[7] * B[5] + A[8] * B[8],
    )


def transpose(A):
    """Transpose of a 3 x 3 tensor."""
    return (A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8])


def inverse(A):
    """Inverse of a 3 x 3 tensor."""
    i = 1.0 / det(A)
    return (
        i * (A[4] * A[8] - A[5] * A[7]),
        i * (A[2] * A[7] - A[1] * A[8]),
        i * (A[1] * A[5] - A[2] * A[4]),
        i * (A[5] * A[6] - A[3] * A[8]),
        i * (A[0] * A[8] - A[2] * A[6]),
        i * (A[2] * A[3] - A[0] * A[5]),
        i * (A[3] * A[7] - A[4] * A[6]),
        i * (A[1] * A[6] - A[0] * A[7]),
        i * (A[0] * A[4] - A[1] * A[3]),
    )


def combine(s, A, t, B):
    """Linear combination s A + t B of two 3 x 3 tensors."""
    return (
        s * A[0] + t * B[0],
        s * A[1] + t * B[1],
        s * A[2] + t * B[2],
        s * A[3] + t * B[3],
        s * A[4] + t * B[4],
        s * A[5] + t * B[5],
        s * A[6] + t * B[6],
        s * A[7] + t * B[7],
        s * A[8] + t * B[8],
    )


def sym(A):
    """Symmetric part of a 3 x 3 tensor, as six components."""
    return (A[0], A[4], A[8], 0.5 * (A[1] + A[3]), 0.5 * (A[5] + A[7]), 0.5 * (A[2] + A[6]))


def spin(A):
    """Skew part of a 3 x 3 tensor, as its three components (xy, yz, xz)."""
    return (0.5 * (A[1] - A[3]), 0.5 * (A[5] - A[7]), 0.5 * (A[2] - A[6]))


def left_cauchy_green(F):
    """b = F F^T, as six components."""
    return (
        F[0] * F[0] + F[1] * F[1] + F[2] * F[2],
        F[3] * F[3] + F[4] * F[4] + F[5] * F[5],
        F[6] * F[6] + F[7] * F[7] + F[8] * F[8],
        F[0] * F[3] + F[1] * F[4] + F[2] * F[5],
        F[3] * F[6] + F[4] * F[7] + F[5] * F[8],
        F[0] * F[6] + F[1] * F[7] + F[2] * F[8],
    )


def trace(s):
    """Trace of a symmetric tensor."""
    return s[0] + s[1] + s[2]


def scale(k, s):
    """k s for a symmetric tensor."""
    return (k * s[0], k * s[1], k * s[2], k * s[3], k * s[4], k * s[5])


def add(s, t):
    """s + t for symmetric tensors."""
    return (s[0] + t[0], s[1] + t[1], s[2] + t[2], s[3] + t[3], s[4] + t[4], s[5] + t[5])


def add_diagonal(s, k):
    """s + k I for a symmetric tensor."""
    return (s[0] + k, s[1] + k, s[2] + k, s[3], s[4], s[5])


def dev(s):
    """Deviator s - tr(s)/3 I of a symmetric tensor."""
    return add_diagonal(s, (-1.0 / 3.0) * (s[0] + s[1] + s[2]))


def ddot(s, t):
    """Double contraction s : t of two symmetric tensors."""
    return s[0] * t[0] + s[1] * t[1] + s[2] * t[2] + 2.0 * (s[3] * t[3] + s[4] * t[4] + s[5] * t[5])


def norm(s):
    """Frobenius norm sqrt(s : s) of a symmetric tensor."""
    return sqrt(ddot(s, s))


def von_mises(s):
    """Equivalent stress sqrt(3/2 dev(s) : dev(s))."""
    d = dev(s)
    return sqrt(1.5 * ddot(d, d))


def jaumann(s, L):
    """W s - s W for the spin W = skew(L): the rate a stress gets from rotation alone."""
    wxy, wyz, wxz = spin(L)
    xx, yy, zz, xy, yz, xz = s
    return (
        2.0 * (wxy * xy + wxz * xz),
        2.0 * (wyz * yz - wxy * xy),
        -2.0 * (wxz * xz + wyz * yz),
        wxy * (yy - xx) + wxz * yz + wyz * xz,
        wyz * (zz - yy) - wxy * xz - wxz * xy,
        wxz * (zz - xx) + wxy * yz - wyz * xy,
    )
