"""Studies: a scene, axes to vary, measures of error and honest cost; what comes out is errors and wall times in one table.

Names are imported when they are first used, as those of `mpmkit` itself.
"""

from __future__ import annotations

import importlib
from typing import Any

_WHERE = {
    "mpmkit.studies.advice": ("Advice",),
    "mpmkit.studies.advising": ("advise",),
    "mpmkit.studies.measures": ("Exact", "Finest", "Quantity"),
    "mpmkit.studies.results": ("StudyResults",),
    "mpmkit.studies.study": ("Study",),
    "mpmkit.studies.plan": ("Run",),
}
_MODULE_OF = {name: module for module, names in _WHERE.items() for name in names}

__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> Any:
    if name in _MODULE_OF:
        value = getattr(importlib.import_module(_MODULE_OF[name]), name)
        globals()[name] = value
        return value
    raise AttributeError(f"module 'mpmkit.studies' has no attribute {name!r}")
