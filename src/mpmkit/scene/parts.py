"""Which classes a table of a scene file can stand for: components by kind, geometries, and the fixed scene objects."""

from __future__ import annotations

import typing
from typing import Any

import attrs

from mpmkit._core.registry import registry
from mpmkit.bodies import Body
from mpmkit.geometry import GEOMETRIES, Geometry
from mpmkit.grid import Grid
from mpmkit.interfaces import BoundaryLayer, Component, ContactAlgorithm, Discretization, Effect, Integrator, ShapeFunction
from mpmkit.parameters import Spec, specs
from mpmkit.record import Record

SETTINGS: dict[str, Spec] = {
    "until": Spec("end time of the run", "s", gt=0.0, example=1.0),
    "precision": Spec("floating point numbers of the run", choices=("float64", "float32"), example="float64"),
    "leaving": Spec("what happens to particles that leave the domain", choices=("stop", "remove", "clamp"), example="stop"),
    "retries": Spec(
        "how many times in a row failed steps are repeated with half the Courant number; 0: not at all", ge=0.0, le=20.0, example=3
    ),
}
"""Top level values of a scene file."""

SETTING_TYPES: dict[str, type] = {"until": float, "precision": str, "leaving": str, "retries": int}

SECTIONS: dict[str, type] = {"grid": Grid, "shape": ShapeFunction, "integrator": Integrator, "discretization": Discretization}
"""Top level tables of a scene file; each is an argument of `Simulation`."""

LISTS: dict[str, type] = {"bodies": Body, "boundaries": BoundaryLayer, "contacts": ContactAlgorithm, "effects": Effect, "records": Record}
"""Arrays of tables of a scene file; each is a list of `Simulation`."""

MATERIALS = "materials"
"""Table of named materials, which bodies refer to."""

KNOWN = ("$schema", *SETTINGS, *SECTIONS, MATERIALS, *LISTS)
"""All top level keys; the first is for editors and means nothing here."""

REQUIRED = ("grid",)
REQUIRED_FOR_MPM = ("shape", "integrator")
"""Required unless another discretization is given."""


def is_part(hint: Any) -> bool:
    """Whether `hint` is a class whose objects are written as tables."""
    return isinstance(hint, type) and (issubclass(hint, (Component, Geometry)) or (attrs.has(hint) and bool(specs(hint))))


def parts_in(hint: Any) -> list[type]:
    """The part classes that a type hint mentions, such as Geometry in ``tuple[Geometry, ...]``."""
    if is_part(hint):
        return [hint]
    return [part for argument in typing.get_args(hint) for part in parts_in(argument)]


def holds_parts(value: Any) -> bool:
    """Whether a value is, or has among its items, an object that is written as a table."""
    return is_part(type(value)) or (isinstance(value, (tuple, list)) and any(holds_parts(item) for item in value))


def is_open(cls: type) -> bool:
    """Whether a table must say with its key "kind" which class it stands for."""
    return issubclass(cls, (Component, Geometry))


def interface(cls: type) -> tuple[type, str]:
    """The class whose subclasses are alternatives to `cls`, and its name in messages."""
    if issubclass(cls, Component):
        return cls, cls.kind or "component"
    return Geometry, "geometry"


def alternatives(cls: type) -> dict[str, type]:
    """Name -> class of everything a table of type `cls` can stand for."""
    if issubclass(cls, Component):
        return {name: entry.component for name, entry in registry().of(*([cls.kind] if cls.kind else [])).items()}
    return dict(GEOMETRIES) if issubclass(cls, Geometry) else {cls.__name__: cls}


def scene_objects() -> dict[str, type]:
    """Everything but components that a scene file holds, by name."""
    return {"Grid": Grid, "Body": Body, "Record": Record, **GEOMETRIES}


def required(cls: type) -> list[str]:
    """Names of the parameters without a default."""
    return [name for name, (attribute, _) in specs(cls).items() if attribute.default is attrs.NOTHING]
