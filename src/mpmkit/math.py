"""Elementary functions for kernels.

Import them from here: a later release can then supply versions that vectorise, without a change in any component.
"""

from math import atan2, cos, cosh, exp, fabs, floor, hypot, log, pi, pow, sin, sinh, sqrt, tan, tanh

__all__ = ["atan2", "cos", "cosh", "exp", "fabs", "floor", "hypot", "log", "pi", "pow", "sin", "sinh", "sqrt", "tan", "tanh"]
