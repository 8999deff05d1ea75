"""Values that may vary in space and time, as kernels take them: constants, or scalar functions that return three floats."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from mpmkit.errors import ParameterError, did_you_mean, shown
from mpmkit.expression import (
    ARGUMENTS,
    Expression,
    all_names,
    arguments_of,
    make_function,
)

Constant = tuple[float, float, float]
_PROBES = (0.123, 0.0, 0.987, 12.3, -0.123)  # numbers at which a user's function is tried, to see what it returns


def as_function(value: Any, dim: int, path: str = "value") -> Constant | Callable[..., Any]:
    """A value as kernels take it.

    Parameters
    ----------
    value : number, tuple of numbers and formulas, text or Python function
        One component for each dimension; a single number or formula only in 1D, or the number 0. A Python function is
        scalar: it asks for any of ``x``, ``X``, ``v`` (tuples of `dim` floats) and ``t`` by name and returns one component
        for each dimension, or three.
    dim : int
        Number of space dimensions.
    path : str
        Name in messages.

    Returns
    -------
    tuple of 3 float, or callable
        The constant, filled up with zeros; or a plain Python function of some of ``x``, ``X``, ``v``, ``t`` that returns three
        floats. The same value gives the same function object again.

    Raises
    ------
    ParameterError
        If the number of components is wrong, a formula cannot be read or names a coordinate that does not exist, or a
        function asks for something else, has defaults, or does not return floats.
    """
    if isinstance(value, str):
        value = (value,)
    if callable(value):
        return _of_function(value, dim, path)
    if isinstance(value, (list, tuple)) or np.ndim(value) == 1:
        parts = tuple(value)
    else:
        parts = (0.0,) * dim if value == 0.0 else (value,)
    if len(parts) != dim:
        raise ParameterError(f"{path} must have {dim} component{'s' if dim > 1 else ''} in {dim}D, got {len(parts)}: {shown(value)}")
    if any(isinstance(p, str) for p in parts):
        return _of_formulas(tuple(str(p) if isinstance(p, str) else float(p) for p in parts), dim, path)
    numbers = [float(p) for p in parts]
    if not all(math.isfinite(n) for n in numbers):
        raise ParameterError(f"{path} must be finite, got {shown(value)}")
    return _padded(numbers, 0.0)


@lru_cache(maxsize=1024)
def _of_formulas(parts: tuple[str | float, ...], dim: int, path: str) -> Constant | Callable[..., Any]:
    names = all_names(dim)
    formulas = [Expression(p if isinstance(p, str) else repr(float(p)), names, path) for p in parts]
    used = {n for f in formulas for n in f.names}
    if not used:
        numbers = [float(f.evaluate()) for f in formulas]
        if not all(math.isfinite(n) for n in numbers):
            raise ParameterError(f"{path} must be finite, got {shown(numbers)} from {shown(parts)}")
        return _padded(numbers, 0.0)
    return make_function(f"({', '.join(_padded([f.code() for f in formulas], '0.0'))})", arguments_of(used))


@lru_cache(maxsize=1024)
def _of_function(function: Callable[..., Any], dim: int, path: str) -> Callable[..., Any]:
    plain = getattr(function, "py_func", getattr(function, "function", function))  # a numba dispatcher, a kernel marker
    if not inspect.isfunction(plain):
        raise ParameterError(f"{path} must be a plain Python function, got {shown(function)}; wrap it: def f(x, t): return ...")
    arguments = _arguments(plain, path)
    result = _probe(plain, arguments, dim, path)
    returned = result if isinstance(result, tuple) else (result,)
    if len(returned) == 3 and all(type(r) is float for r in returned):
        return plain
    # Components are picked here rather than by the caller, so that every value looks the same to the code generator.
    given = "given[{}]" if isinstance(result, tuple) else "given"
    picked = [("{}" if type(r) is float else "1.0 * {}").format(given.format(k)) for k, r in enumerate(returned)]
    name = re.sub(r"\W", "", plain.__name__) or "value"
    call = f"function({', '.join(arguments)})"
    text = f"def {name}_as_vector({', '.join(arguments)}):\n    given = {call}\n    return ({', '.join(_padded(picked, '0.0'))})\n"
    space: dict[str, Any] = {"__builtins__": {}, "__name__": "mpmkit.values", "function": plain}
    exec(compile(text, f"<{name}_as_vector>", "exec"), space)
    wrapper: Callable[..., Any] = space[f"{name}_as_vector"]
    wrapper.source = text  # type: ignore[attr-defined]
    wrapper.given = plain  # type: ignore[attr-defined]
    return wrapper


def _arguments(function: Callable[..., Any], path: str) -> tuple[str, ...]:
    for p in inspect.signature(function).parameters.values():
        if p.kind is not p.POSITIONAL_OR_KEYWORD or p.default is not p.empty:
            raise ParameterError(f"{path}: argument {p.name!r} of the function {function.__name__} must be a plain name without a default")
        if p.name not in ARGUMENTS:
            raise ParameterError(
                f"{path}: the function {function.__name__} asks for {p.name!r}; it can have x (position), X (position at the start), "
                f"v (velocity) and t (time){did_you_mean(p.name, ARGUMENTS)}"
            )
    return tuple(inspect.signature(function).parameters)


def _call(function: Callable[..., Any], arguments: tuple[str, ...], dim: int, probe: float) -> Any:
    return function(*(abs(probe) if a == "t" else (probe,) * dim for a in arguments))


def _probe(function: Callable[..., Any], arguments: tuple[str, ...], dim: int, path: str) -> Any:
    """What the function returns at the first of a few points where it has a value."""
    problem: Exception | None = None
    for probe in _PROBES:
        try:
            result = _call(function, arguments, dim, probe)
        except (ArithmeticError, ValueError) as error:  # no value here, such as 1 / x at 0; perhaps elsewhere
            problem = problem or error
            continue
        except Exception as error:
            raise ParameterError(
                f"{path}: the function {function.__name__}({', '.join(arguments)}) fails: {type(error).__name__}: {error}"
            ) from error
        parts = result if isinstance(result, tuple) else (result,)
        if not all(isinstance(p, (int, float)) and not isinstance(p, bool) for p in parts):
            raise ParameterError(f"{path}: the function {function.__name__} must return a float or a tuple of floats, got {shown(result)}")
        if len(parts) != dim and not (len(parts) == 3 and isinstance(result, tuple)):
            raise ParameterError(
                f"{path}: the function {function.__name__} must return {dim} component{'s' if dim > 1 else ''} in {dim}D, "
                f"got {shown(result)}"
            )
        return result
    raise ParameterError(
        f"{path}: the function {function.__name__} has no value at any of the points tried, first error: {problem}"
    ) from problem


def _padded(parts: list[Any], zero: Any) -> tuple[Any, Any, Any]:
    first, second, third = parts + [zero] * (3 - len(parts))
    return first, second, third
