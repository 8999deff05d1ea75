"""Norms of errors over particles and instants."""

from __future__ import annotations

from typing import Any

import numpy as np

NORMS = ("L1", "L2", "max")
OVER = ("all", "largest")


def norm(kind: str, over: str, sizes: list[Any], weights: list[Any]) -> float:
    """Norm of the sizes of errors at some instants, an array each, with the weights of the particles.

    "L1" is the weighted mean, "L2" the root of the weighted mean square, "max" the largest. Over "all" instants together, or the
    "largest" of the norms at each of them.
    """
    if not sizes:
        return 0.0
    if kind == "max":
        return max(float(np.max(e, initial=0.0)) for e in sizes)
    power = 1 if kind == "L1" else 2
    at_times = [float((w * e**power).sum() / w.sum()) for e, w in zip(sizes, weights, strict=True)]
    value = max(at_times) if over == "largest" else sum(at_times) / len(at_times)
    return float(value if power == 1 else np.sqrt(value))
