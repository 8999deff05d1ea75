"""Elementary functions for kernels.

In compiled components log, exp and pow are replaced by versions that vectorise, at most two units of the last digit from exact
(`mpmkit._core.composing.elementary`); sqrt, fabs and floor vectorise as they are. The others are calls of the C library, one particle after
the other: they keep the whole loop over particles scalar, five to ten times slower.
"""

from math import atan2, cos, cosh, exp, fabs, floor, hypot, log, pi, pow, sin, sinh, sqrt, tan, tanh

__all__ = ["atan2", "cos", "cosh", "exp", "fabs", "floor", "hypot", "log", "pi", "pow", "sin", "sinh", "sqrt", "tan", "tanh"]
