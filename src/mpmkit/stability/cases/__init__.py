"""The hard cases, one module each; they are found, not listed."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from mpmkit.stability.case import Case


def cases() -> dict[str, Case]:
    """All cases by name, in alphabetical order of their modules."""
    found: dict[str, Case] = {}
    for module in sorted(m.name for m in iter_modules(__path__) if not m.name.startswith("_")):
        loaded = import_module(f"{__name__}.{module}")
        for case in getattr(loaded, "CASES", None) or (loaded.CASE,):
            if case.name in found:
                raise ValueError(f"two hard cases are named {case.name!r}")
            found[case.name] = case
    return found
