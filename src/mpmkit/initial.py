"""Initial values of particles: constants, formulas in text, functions of position, or arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpmkit.errors import ParameterError, shown
from mpmkit.geometry.cloud import frozen_array
from mpmkit.parameters import Spec, Value, convert

Array = NDArray[np.float64]


def as_constant(value: Any, shape: tuple[int, ...], path: str, dim: int, count: int | None, unit: str) -> Any:
    """Check an initial value as far as that is possible without the positions, and freeze it.

    Parameters
    ----------
    value : None, number, sequence of numbers and formulas, array or callable
        What was given.
    shape : tuple of int
        Shape of one particle's value.
    path : str
        Name in messages.
    dim : int
        Number of space dimensions.
    count : int or None
        Number of particles, if already known.
    unit : str
        SI unit, for texts such as "20 MPa".

    Returns
    -------
    None, callable, nested tuples, or read-only float64[n, ...]
    """
    if value is None or callable(value):
        return value
    if isinstance(value, str) or (isinstance(value, (list, tuple)) and _has_text(value)):
        value = _converted(value, Spec("at the start", unit), path)
        if _has_text(value):
            formulas(value, shape, path, dim)
            return value
    array = np.asarray(frozen_array(value, path, (None,) * np.ndim(value)))
    if array.ndim == 0 and shape == (dim,) and (dim == 1 or array == 0.0):
        return float(array)
    if array.shape == (9,) and shape == (3, 3):
        array = array.reshape(3, 3)
    if array.shape == shape:
        return _nested(array.tolist())
    if array.shape[1:] == (9,) and shape == (3, 3):
        array = array.reshape(-1, 3, 3)
    if array.shape == (count,) and shape == (1,):
        array = array[:, None]
    if array.ndim == len(shape) + 1 and array.shape[1:] == shape and (count is None or len(array) == count):
        return frozen_array(array, path, (None, *shape))
    one = "1 number" if shape == (1,) else f"{shape[0]} numbers" if len(shape) == 1 else "3 x 3 numbers"
    rows = f", or {count} rows of them," if count is not None else ""
    raise ParameterError(f"{path} must be {one}{rows} for a body in {dim}D, got {_shown(value, array)}")


def initial_values(value: Any, x: Array, shape: tuple[int, ...], path: str) -> Array | None:
    """Values at the positions x float64[n, dim] as float64[n, *shape]; None stays None.

    Raises
    ------
    ParameterError
        If a function or an array has a wrong shape, or a value is not finite; names the first such particle.
    """
    if value is None:
        return None
    n, dim = x.shape
    if callable(value):
        given = value(x)
        array = np.asarray(given, dtype=np.float64)
        if array.shape in ((9,), (n, 9)) and shape == (3, 3):
            array = array.reshape(*array.shape[:-1], 3, 3)
        if array.shape == (n,) and shape == (1,):
            array = array[:, None]
        allowed: tuple[tuple[int, ...], ...] = (shape, (n, *shape)) if shape != (1,) else ((), shape, (n, 1))
        if array.shape not in allowed:
            raise ParameterError(
                f"{path}: the function returned the shape {array.shape}; it must return {(n, *shape)} or {shape} for x of shape {x.shape}"
            )
    elif isinstance(value, str) or (isinstance(value, tuple) and _has_text(value)):
        columns = [f.evaluate(x=x, X=x) if f is not None else c for f, c in formulas(value, shape, path, dim)]
        array = np.stack([np.broadcast_to(c, (n,)) for c in columns], axis=1).reshape(n, *shape)
    else:
        array = np.asarray(value, dtype=np.float64)
        if array.ndim == len(shape) + 1 and len(array) != n:
            raise ParameterError(f"{path}: {len(array)} rows were given for {n} particles")
    out = np.broadcast_to(np.array(array), (n, *shape))  # one value for all takes the memory of one
    bad = np.flatnonzero(~np.isfinite(out).reshape(n, -1).all(axis=1))
    if len(bad):
        raise ParameterError(
            f"{path} must be finite, got {out[bad[0]].tolist()} at x = {tuple(x[bad[0]].tolist())} ({len(bad)} such particles)"
        )
    return out


def formulas(value: Any, shape: tuple[int, ...], path: str, dim: int) -> list[tuple[Any, float]]:
    """(Expression or None, constant) of each component, row by row; `ParameterError` if their number is wrong."""
    from mpmkit.expression import Expression, position_names

    parts = list(_flat(value))
    wanted = int(np.prod(shape))
    if len(parts) != wanted:
        raise ParameterError(f"{path} must be {wanted} formulas or numbers for a body in {dim}D, got {len(parts)}: {shown(value)}")
    names = position_names(dim)
    return [(Expression(p, names, path), 0.0) if isinstance(p, str) else (None, float(p)) for p in parts]


def same(a: Any, b: Any) -> bool:
    """Equality that compares arrays as a whole."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and np.array_equal(a, b)
    return bool(a == b)


def _flat(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        for part in value:
            yield from _flat(part)
    else:
        yield value


def _has_text(value: Any) -> bool:
    return any(isinstance(part, str) for part in _flat(value))


def _converted(value: Any, spec: Spec, path: str) -> Any:
    """The same nested tuples with quantities turned into numbers and formulas checked."""
    if isinstance(value, (list, tuple)):
        return tuple(_converted(part, spec, path) for part in value)
    return convert(value, Value, spec, path)


def _nested(value: Any) -> Any:
    return tuple(_nested(part) for part in value) if isinstance(value, (list, tuple)) else value


def _shown(value: Any, array: Array) -> str:
    return repr(value) if array.size <= 9 else f"an array of shape {array.shape}"
