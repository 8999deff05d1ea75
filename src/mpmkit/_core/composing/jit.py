"""The one place where numba's options are chosen and components become compiled functions."""

from __future__ import annotations

import os
import sys
import types
from collections.abc import Callable
from typing import Any

import numpy as np

from mpmkit.kernels import Kernel

# No "nnan" and "ninf": the guards must be able to see a NaN.
FLAGS: dict[str, Any] = {"fastmath": {"contract", "reassoc", "nsz", "arcp", "afn"}, "error_model": "numpy"}


def enabled() -> bool:
    """False with NUMBA_DISABLE_JIT=1: the generated step then runs as plain Python."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator of the loops in a generated module: compiled, and cached on disk beside it."""
    if not enabled():
        return function
    import numba

    return numba.njit(cache=True, **FLAGS)(function)  # type: ignore[no-any-return]


class Linker:
    """Makes compiled versions of component functions for one precision.

    Components are plain functions in the author's file. The linker clones each with its float constants in the
    scene's precision and the functions it calls replaced by their own compiled versions, with explicit flags, so
    that no component inherits options from whoever compiled it first. File, name and line numbers stay the author's.
    """

    def __init__(self, dtype: type) -> None:
        self.dtype = dtype
        self._made: dict[int, Any] = {}
        self._alive: list[Any] = []

    def __call__(self, function: Any) -> Any:
        function = plain(function)
        if not enabled():
            return function
        if id(function) not in self._made:
            import numba

            self._alive.append(function)
            self._made[id(function)] = numba.njit(**FLAGS)(self._typed(function))
        return self._made[id(function)]

    def _typed(self, function: types.FunctionType) -> types.FunctionType:
        code = function.__code__
        scope = {name: self._value(function.__globals__[name]) for name in names_of(code) if name in function.__globals__}
        # numba's cache finds a function by its module, which must exist in the next process too
        module = function.__module__ if function.__module__ in sys.modules else __name__
        scope |= {"__builtins__": __builtins__, "__name__": module}
        closure = tuple(types.CellType(self._value(cell.cell_contents)) for cell in function.__closure__ or ())
        constants = tuple(self._constant(c) for c in code.co_consts)
        clone = types.FunctionType(code.replace(co_consts=constants), scope, function.__name__, function.__defaults__, closure)
        clone.__module__, clone.__qualname__ = module, function.__qualname__
        return clone

    def _constant(self, value: Any) -> Any:
        if type(value) is float:
            return self.dtype(value) if self.dtype is not np.float64 else value
        if type(value) is tuple:
            return tuple(self._constant(v) for v in value)
        return value

    def _value(self, value: Any) -> Any:
        return self(value) if isinstance(plain(value), types.FunctionType) else self._constant(value)


def plain(function: Any) -> Any:
    """The Python function behind a kernel marker or a numba dispatcher."""
    if isinstance(function, Kernel):
        return function.function
    return getattr(function, "py_func", function)


def names_of(code: types.CodeType) -> set[str]:
    """Global names a code object and the functions inside it refer to."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            names |= names_of(constant)
    return names
