"""What all exact solutions have in common: checked parameters and checked points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpmkit.errors import ParameterError

Array = NDArray[np.float64]
"""Result of a field method: one number per point (a zero-dimensional array for one point)."""


class Solution:
    """Base of the exact solutions: frozen classes made by `mpmkit.define`, so bounds and unit strings are checked."""

    def __attrs_post_init__(self) -> None:
        self.check()

    def check(self) -> None:
        """Check parameters against each other; raise `ParameterError` with the remedy."""


def inside(points: ArrayLike, lower: float, upper: float, what: str) -> Array:
    """Return `points` as an array, if all of them lie in [lower, upper].

    Parameters
    ----------
    points : array_like
        Reference positions [m], any shape.
    lower, upper : float
        Allowed range [m]; rounding of 1e-9 of its length is forgiven.
    what : str
        Name of the quantity and its owner, for the message.

    Raises
    ------
    ParameterError
        If a point lies outside or is not finite; names the first such point.
    """
    values = np.asarray(points, dtype=np.float64)
    slack = 1e-9 * (upper - lower)
    bad = ~((values >= lower - slack) & (values <= upper + slack))
    if bad.any():
        first = float(values[bad].ravel()[0])
        raise ParameterError(f"{what} must lie in [{lower:g}, {upper:g}], got {first:g}; give reference positions, not current ones")
    return values
