"""The one place where numba's options are chosen and components become compiled functions."""

from __future__ import annotations

import os
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from mpmkit.kernels import Kernel

# No "nnan" and "ninf": the guards must be able to see a NaN.
# "nogil": the threads of a team run loops side by side, and results are written meanwhile.
FLAGS: dict[str, Any] = {"fastmath": {"contract", "reassoc", "nsz", "arcp", "afn"}, "error_model": "numpy", "nogil": True}


def enabled() -> bool:
    """False with NUMBA_DISABLE_JIT=1: the generated step then runs as plain Python."""
    return os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Decorator of the loops in a generated module: compiled, and cached on disk beside it."""
    if not enabled():
        return function
    from mpmkit._core.composing.machine_code import kept

    return kept(function, **FLAGS)  # type: ignore[no-any-return]


def sources() -> tuple[str, ...]:
    """Texts behind every compiled step that no function of its components leads to: options, vectors and elementary functions."""
    here = Path(__file__).parent
    names = ("jit", "simd_type", "simd_numba", "simd_numpy", "bits", "elementary")
    return tuple((here / f"{name}.py").read_text(encoding="utf-8") for name in names)


class Linker:
    """Makes compiled versions of component functions for one precision.

    Components are plain functions in the author's file. The linker clones each with its float constants in the
    scene's precision and the functions it calls replaced by their own compiled versions, with explicit flags, so
    that no component inherits options from whoever compiled it first. File, name and line numbers stay the author's.
    In place of log, exp and pow of the C library they get those of `elementary`. All are compiled into their callers:
    a call that is left over would keep a loop over particles scalar.
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

            from mpmkit._core.composing import elementary

            own = {"fastmath": set(elementary.FLAGS)} if function.__module__ == elementary.__name__ else {}
            self._alive.append(function)
            self._made[id(function)] = numba.njit(**FLAGS | own, forceinline=True)(self._typed(function))
        return self._made[id(function)]

    def _typed(self, function: types.FunctionType) -> types.FunctionType:
        code = function.__code__
        names = names_of(code)
        scope = {name: self._value(function.__globals__[name], names) for name in names if name in function.__globals__}
        # numba's cache finds a function by its module, which must exist in the next process too
        module = function.__module__ if function.__module__ in sys.modules else __name__
        scope |= {"__builtins__": __builtins__, "__name__": module}
        closure = tuple(types.CellType(self._value(cell.cell_contents, names)) for cell in function.__closure__ or ())
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

    def _value(self, value: Any, names: set[str]) -> Any:
        """What a global name of a function stands for in its clone, which uses the `names` (of a module: as its attributes)."""
        from mpmkit._core.composing.elementary import REPLACED

        if isinstance(value, types.ModuleType) and value.__name__ in ("math", "mpmkit", "mpmkit.math"):
            module = types.ModuleType(value.__name__)
            vars(module).update({name: self._value(vars(value)[name], names) for name in names & set(vars(value))})
            return module
        if isinstance(value, types.BuiltinFunctionType):
            return self(REPLACED[value]) if value in REPLACED else value
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
