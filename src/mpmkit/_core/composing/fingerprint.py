"""Content fingerprints: what the name of a generated module is made of.

Numba's own disk cache looks at one file only, so after an edit of a component it would silently serve the old
physics. The fingerprint of a function covers its bytecode and constants and, recursively, every function and
constant it reaches; comments and line numbers do not matter.
"""

from __future__ import annotations

import hashlib
import types
from typing import Any

import numpy as np

from mpmkit._core.composing.jit import names_of, plain


def fingerprint(functions: dict[str, Any], *texts: str) -> str:
    """Digest of named functions and further texts, as 20 hexadecimal digits."""
    h = hashlib.sha256()
    for text in texts:
        h.update(text.encode())
    for name in sorted(functions):
        h.update(name.encode())
        _function(h, plain(functions[name]), set())
    return h.hexdigest()[:20]


def _function(h: Any, f: Any, seen: set[int]) -> None:
    if id(f) in seen:
        return
    seen.add(id(f))
    h.update(f"{f.__module__}.{f.__qualname__}{f.__defaults__!r}".encode())
    _code(h, f.__code__)
    scope = dict(zip(f.__code__.co_freevars, (c.cell_contents for c in f.__closure__ or ()), strict=True))
    names = sorted(names_of(f.__code__) | set(scope))
    for name in names:
        _value(h, name, scope.get(name, f.__globals__.get(name)), names, seen)


def _value(h: Any, name: str, value: Any, names: list[str], seen: set[int]) -> None:
    """What a name of a function stands for; of a module those of its attributes that have one of the function's `names`."""
    value = plain(value)
    if isinstance(value, types.FunctionType):
        h.update(name.encode())
        _function(h, value, seen)
    elif isinstance(value, (int, float, str, tuple, bool, np.generic)):
        h.update(f"{name}={type(value).__name__}:{value!r}".encode())
    elif isinstance(value, np.ndarray):
        h.update(name.encode() + value.tobytes())
    elif isinstance(value, types.ModuleType):
        h.update(f"{name}=module {value.__name__} {getattr(value, '__version__', '')}".encode())
        if value.__name__.split(".")[0] not in ("numpy", "math"):
            for attribute in names:
                if attribute in vars(value):
                    _value(h, f"{name}.{attribute}", vars(value)[attribute], [n for n in names if n != attribute], seen)


def _code(h: Any, code: types.CodeType) -> None:
    h.update(code.co_code)
    h.update(repr((code.co_names, code.co_varnames[: code.co_argcount])).encode())
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            _code(h, constant)
        else:
            h.update(repr((type(constant).__name__, constant)).encode())
