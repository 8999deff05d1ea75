"""The words a constitutive law is written in, on plain tuples.

A 3 x 3 tensor is a tuple of nine numbers, row by row: (xx, xy, xz, yx, yy, yz, zx, zy, zz).
A symmetric tensor is a tuple of six in the order xx, yy, zz, xy, yz, xz.
All functions are scalar, pure and free of branches where possible, so that the scheduler can compile them.
"""

from mpmkit.math import sqrt

IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def det(A):
    """Determinant of a 3 x 3 tensor."""
    return A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6]) + A[2] * (A[3] * A[7] - A[4] * A[6])


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


def rotate(R, s):
    """R s R^T for a symmetric tensor s."""
    xx, yy, zz, xy, yz, xz = s
    ax, ay, az = R[0] * xx + R[1] * xy + R[2] * xz, R[0] * xy + R[1] * yy + R[2] * yz, R[0] * xz + R[1] * yz + R[2] * zz
    bx, by, bz = R[3] * xx + R[4] * xy + R[5] * xz, R[3] * xy + R[4] * yy + R[5] * yz, R[3] * xz + R[4] * yz + R[5] * zz
    cx, cy, cz = R[6] * xx + R[7] * xy + R[8] * xz, R[6] * xy + R[7] * yy + R[8] * yz, R[6] * xz + R[7] * yz + R[8] * zz
    return (
        ax * R[0] + ay * R[1] + az * R[2],
        bx * R[3] + by * R[4] + bz * R[5],
        cx * R[6] + cy * R[7] + cz * R[8],
        ax * R[3] + ay * R[4] + az * R[5],
        bx * R[6] + by * R[7] + bz * R[8],
        ax * R[6] + ay * R[7] + az * R[8],
    )


def rotation(L, dt):
    """Rotation by the spin of L during dt: exactly orthogonal, the exponential of dt skew(L) to O(dt^9).

    Cayley's form as in Hughes and Winget (1980, doi:10.1002/nme.1620151210), with the half angle replaced by its tangent.
    """
    wxy, wyz, wxz = spin(L)
    x, y, z = -0.5 * dt * wyz, 0.5 * dt * wxz, -0.5 * dt * wxy  # half the rotation vector
    q = x * x + y * y + z * z
    k = 1.0 + q * (1.0 / 3.0 + q * (2.0 / 15.0 + q * (17.0 / 315.0)))  # tan(a) / a
    x, y, z = k * x, k * y, k * z
    q = x * x + y * y + z * z
    i = 1.0 / (1.0 + q)
    return (
        i * (1.0 - q + 2.0 * x * x),
        2.0 * i * (x * y - z),
        2.0 * i * (x * z + y),
        2.0 * i * (x * y + z),
        i * (1.0 - q + 2.0 * y * y),
        2.0 * i * (y * z - x),
        2.0 * i * (x * z - y),
        2.0 * i * (y * z + x),
        i * (1.0 - q + 2.0 * z * z),
    )


def cosine_of_a_third(r):
    """cos(acos(r) / 3) for -1 <= r <= 1, to 4e-16.

    A minimax polynomial in w = 2 cos(acos(r) / 2) - 1, of which it is a smooth function; without calls of the C library, which would keep
    loops over particles scalar.
    """
    w = sqrt(2.0 + 2.0 * r) - 1.0
    p = 5.2481724144513994e-11
    p = p * w - 1.63683082800312e-10
    p = p * w + 3.0368768606010505e-10
    p = p * w - 1.0522640508575519e-09
    p = p * w + 3.991965122036578e-09
    p = p * w - 1.3482453989586619e-08
    p = p * w + 4.5817102590131354e-08
    p = p * w - 1.5946448982727355e-07
    p = p * w + 5.641692083030359e-07
    p = p * w - 2.035896968937706e-06
    p = p * w + 7.541074100905214e-06
    p = p * w - 2.891993099603434e-05
    p = p * w + 0.00011642545355090997
    p = p * w - 0.0005041246916553288
    p = p * w + 0.002466352815049011
    p = p * w - 0.015509188436466538
    p = p * w + 0.24740906632285375
    return p * w + 0.7660444431189779


def largest_eigenvalue_bound(s):
    """Upper bound of the largest eigenvalue of a symmetric tensor, tr s / 3 + sqrt(2/3) |dev s|; exact if the other two are equal.

    Wolkowicz and Styan (1980), Bounds for eigenvalues using traces, doi:10.1016/0024-3795(80)90258-X, eq 2.2 for n = 3.
    """
    d = dev(s)
    return (1.0 / 3.0) * (s[0] + s[1] + s[2]) + sqrt((2.0 / 3.0) * ddot(d, d))


def largest_eigenvalue(s):
    """Largest eigenvalue of a symmetric tensor, by the trigonometric solution of its cubic."""
    q = (1.0 / 3.0) * (s[0] + s[1] + s[2])
    d = dev(s)
    p = sqrt(ddot(d, d) * (1.0 / 6.0))
    x, y, z, xy, yz, xz = scale(1.0 / max(p, 1e-30), d)  # the bound is for s = q I
    half_det = 0.5 * (x * (y * z - yz * yz) - xy * (xy * z - yz * xz) + xz * (xy * yz - y * xz))
    r = max(-1.0, min(1.0, half_det))  # cosine of three times the angle
    return q + 2.0 * p * cosine_of_a_third(r)
