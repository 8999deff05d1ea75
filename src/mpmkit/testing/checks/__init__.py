"""The checks, a module for each kind of component or for one side of it; all modules of this folder are found, none is listed."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from mpmkit.testing.collect import CHECKS, Declared


@cache
def _load() -> None:
    for module in sorted(found.name for found in pkgutil.iter_modules(__path__)):
        importlib.import_module(f"{__name__}.{module}")
    CHECKS.sort(key=lambda declared: declared.kind != "all")  # the general ones first; the others keep their order


def table() -> list[Declared]:
    """All checks, those of all kinds first, else by the names of their modules; imported here and not before, as they need numpy."""
    _load()
    return CHECKS
