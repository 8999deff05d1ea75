"""mpmkit: simulate solids, soils, soft matter and impact with the material point method, by composition.

Names are imported when they are first used, so that ``import mpmkit`` and the command line start at once.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_WHERE = {
    "mpmkit.bodies": ("Body",),
    "mpmkit.errors": (
        "CompositionError", "FieldContractError", "MpmkitError", "ParameterError", "PluginError", "ResultsError", "SceneError",
        "StabilityError",
    ),
    "mpmkit.expression": ("Expression",),
    "mpmkit.fields": ("Field",),
    "mpmkit.geometry": (
        "Box", "Cylinder", "Difference", "Disk", "HalfSpace", "Intersection", "Polygon", "Sphere", "Transformed", "Union",
    ),
    "mpmkit.grid": ("Grid",),
    "mpmkit.hookspecs": ("hookimpl",),
    "mpmkit.interfaces": (
        "BoundaryLayer", "Component", "ConstitutiveModel", "ContactAlgorithm", "Discretization", "Effect", "ExplicitIntegrator",
        "Integrator", "ShapeFunction", "Transfer",
    ),
    "mpmkit.kernels": ("kernel",),
    "mpmkit.parameters": ("Value", "Vector", "define", "parameter"),
    "mpmkit.record": ("Record",),
    "mpmkit.results": ("Results",),
    "mpmkit.scene": ("load", "save"),
    "mpmkit.simulation": ("Simulation",),
    "mpmkit.studies": ("Study",),
}  # fmt: skip
_MODULE_OF = {name: module for module, names in _WHERE.items() for name in names}

__all__ = sorted(_MODULE_OF)


def __getattr__(name: str) -> Any:
    if name in _MODULE_OF:
        value = getattr(importlib.import_module(_MODULE_OF[name]), name)
        globals()[name] = value
        return value
    try:
        return importlib.import_module(f"mpmkit.{name}")
    except ModuleNotFoundError:
        from mpmkit.errors import did_you_mean

        raise AttributeError(f"module 'mpmkit' has no attribute {name!r}{did_you_mean(name, _MODULE_OF)}") from None


def __dir__() -> list[str]:
    return sorted(set(globals()) | set(_MODULE_OF))
