"""Names of the components of vectors and tensors as they are stored."""

from __future__ import annotations

_AXES = "xyz"
SYMMETRIC = ("xx", "yy", "zz", "xy", "yz", "xz")
FULL = tuple(a + b for a in _AXES for b in _AXES)


def component_names(count: int) -> tuple[str, ...]:
    """Names of `count` components: x y z, xx yy zz xy yz xz, or the nine of a full tensor; else numbers.

    Four components are the tensor of a plane (xx, xy, yx, yy); one is a vector of a 1D run.
    """
    known = {1: ("x",), 2: ("x", "y"), 3: ("x", "y", "z"), 4: ("xx", "xy", "yx", "yy"), 6: SYMMETRIC, 9: FULL}
    return known.get(count, tuple(str(k) for k in range(count)))
