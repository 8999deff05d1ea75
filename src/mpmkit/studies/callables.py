"""Python functions by a name that another process can import: "package.module:name" or "path/to/file.py:name"."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from mpmkit.errors import ParameterError, did_you_mean


def is_name(text: Any) -> bool:
    """Whether text names a function: "module:name" or "file.py:name"."""
    return isinstance(text, str) and ":" in text and text.rpartition(":")[2].isidentifier()


def name_of(function: Callable[..., Any], what: str) -> str:
    """The name under which another process finds a function.

    Raises
    ------
    ParameterError
        If there is none: lambdas, functions inside functions, those typed into an interpreter.
    """
    qualname, module = getattr(function, "__qualname__", "?"), getattr(function, "__module__", None)
    file = None
    if qualname.isidentifier() and qualname != "<lambda>":
        try:
            file = inspect.getsourcefile(inspect.unwrap(function))
        except TypeError:
            file = None
    if file is None or not Path(file).is_file():
        raise ParameterError(
            f"{what}: {qualname} cannot be found by another process; the runs of a study have processes of their own. Define the "
            "function with def at the top level of a file"
        )
    if module != "__main__" and module in sys.modules and "." in str(module):
        return f"{module}:{qualname}"
    return f"{Path(file).resolve()}:{qualname}"


def load(name: str, folder: str | Path = ".") -> Any:
    """What a name stands for; files are looked for relative to `folder`.

    Raises
    ------
    ParameterError
        If it cannot be imported, or has no such attribute.
    """
    place, _, attribute = name.rpartition(":")
    try:
        module = _file(str((Path(folder) / place).resolve())) if place.endswith(".py") else importlib.import_module(place)
    except (ImportError, OSError, SyntaxError) as error:
        raise ParameterError(f"cannot import {name!r}: {type(error).__name__}: {error}") from None
    if not hasattr(module, attribute):
        raise ParameterError(f"{place} has no {attribute!r}{did_you_mean(attribute, vars(module))}")
    return getattr(module, attribute)


@cache
def _file(path: str) -> Any:
    """A file as a module of its own; modules beside it can be imported, as when it is run."""
    for module in list(sys.modules.values()):
        if module.__name__ != "__main__" and getattr(module, "__file__", None) == path:
            return module
    if not Path(path).is_file():
        raise FileNotFoundError(f"there is no file {path}")
    folder = str(Path(path).parent)
    if folder not in sys.path:
        sys.path.append(folder)
    name = f"mpmkit_study_{Path(path).stem}_{hashlib.sha256(path.encode()).hexdigest()[:8]}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def source_digest(name: str, folder: str | Path = ".") -> str:
    """Digest of the file that a name is in; what that file imports is not seen."""
    place = name.rpartition(":")[0]
    path = Path(folder) / place
    if not place.endswith(".py"):
        spec = importlib.util.find_spec(place)
        path = Path(spec.origin) if spec is not None and spec.origin else path
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    except OSError:
        return ""
