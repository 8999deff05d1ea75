"""Machine code on disk, in place of numba's own cache files.

Numba keeps an index beside the code of each function. Two processes that write at once can leave an index that names
the other's code, a truncated file ends the next run with an error, and a folder that cannot be written is not read
either. Here each signature has a file of its own, named by what it was compiled for, and `cache.read` returns it whole
or not at all; there is nothing else that could disagree.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import warnings
from collections.abc import Callable
from typing import Any

import numba
from numba.core import config, serialize
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult

from mpmkit._core.composing import cache

_OPTIONS = ("OPT", "BOUNDSCHECK", "DEBUGINFO_DEFAULT", "LOOP_VECTORIZE", "SLP_VECTORIZE")
"""Settings of numba (NUMBA_OPT ...) that change the code."""


class MachineCode(_Cache):
    """What numba asks for compiled versions of one function of a generated module, and gives them to."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = function.__qualname__
        self._file = function.__code__.co_filename
        self._digest = os.path.basename(os.path.dirname(self._file))

    @property
    def cache_path(self) -> str:
        """The module's folder."""
        return str(cache.home(self._digest))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Compiled code for a signature; None if it must be compiled."""
        target_context.refresh()
        data = cache.read(self._digest, self._file_name(sig, target_context.codegen()))
        if data is None:
            return None
        try:
            return CompileResult._rebuild(target_context, *pickle.loads(data))  # type: ignore[no-untyped-call]
        except Exception:  # noqa: BLE001  whole, but of a numba that is built otherwise: it is compiled and written again
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep compiled code."""
        if any(not lifted.can_cache for lifted in data.lifted) or data.library.has_dynamic_globals:
            warnings.warn(f"{self._file}: {self._name} refers to addresses of this process and is compiled in each", stacklevel=2)
            return
        name = self._file_name(sig, data.codegen)
        cache.write(self._digest, name, serialize.dumps(data._reduce()))  # type: ignore[no-untyped-call]

    def enable(self) -> None:
        """Always on."""

    def disable(self) -> None:
        """Not needed: NUMBA_DISABLE_JIT compiles nothing at all."""

    def flush(self) -> None:
        """Nothing is held back."""

    def _file_name(self, sig: Any, codegen: Any) -> str:
        # the digest in the folder's name covers sources and versions; here is what else the code depends on
        options = [str(getattr(config, name)) for name in _OPTIONS]
        key = hashlib.sha256(repr((sig, codegen.magic_tuple(), options)).encode()).hexdigest()
        return f"{self._name}-{key[:20]}.code"


def kept(function: Callable[..., Any], **flags: Any) -> Any:
    """A compiled function of a generated module, whose machine code later processes find."""
    dispatcher = numba.njit(**flags)(function)
    dispatcher._cache = MachineCode(function)
    return dispatcher
