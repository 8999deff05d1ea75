"""JSON Schema (draft 2020-12) of scene files, from the declarations of all registered components.

Editors use it to complete and check scene files while they are written. What it cannot say (units that fit, parameters
checked against each other) is said when the scene is loaded.
"""

from __future__ import annotations

import types
import typing
from typing import Any

import attrs

from mpmkit._core.registry import registry
from mpmkit.description import default_of, plain
from mpmkit.interfaces import Component, ConstitutiveModel
from mpmkit.parameters import Spec, Value, Vector, specs
from mpmkit.scene.parts import (
    KNOWN,
    LISTS,
    MATERIALS,
    REQUIRED,
    REQUIRED_FOR_MPM,
    SECTIONS,
    SETTING_TYPES,
    SETTINGS,
    alternatives,
    holds_parts,
    interface,
    is_open,
    is_part,
    required,
)
from mpmkit.units import QUANTITY

DRAFT = "https://json-schema.org/draft/2020-12/schema"
QUANTITY_PATTERN = f"^(?:{QUANTITY})$"


def schema() -> dict[str, Any]:
    """The schema of scene files with the components of all installed plugins."""
    maker = Maker()
    properties: dict[str, Any] = {"$schema": {"type": "string", "description": "for editors; has no other meaning"}}
    for key, spec in SETTINGS.items():
        properties[key] = maker.value(SETTING_TYPES[key], spec) | {"description": text_of(spec)}
    for key, cls in SECTIONS.items():
        properties[key] = maker.part(cls)
    materials = {
        "type": "object",
        "additionalProperties": maker.part(ConstitutiveModel),
        "description": "materials by name, for bodies to refer to",
    }
    properties[MATERIALS] = materials
    for key, cls in LISTS.items():
        properties[key] = {"type": "array", "items": maker.part(cls)}
    return {
        "$schema": DRAFT,
        "title": "mpmkit scene",
        "type": "object",
        "properties": {key: properties[key] for key in KNOWN},
        "required": list(REQUIRED),
        "anyOf": [{"required": list(REQUIRED_FOR_MPM)}, {"required": ["discretization"]}],
        "additionalProperties": False,
        "$defs": maker.definitions,
    }


class Maker:
    """Collects one definition per class, so that nested and recursive ones can refer to them."""

    def __init__(self) -> None:
        self.definitions: dict[str, Any] = {}

    def part(self, cls: type) -> dict[str, Any]:
        """A table that stands for `cls` or, if it has alternatives, for one of them."""
        if not is_open(cls):
            return self._reference(cls.__name__, cls, None)
        _, what = interface(cls)
        if what not in self.definitions:
            self.definitions[what] = {}  # a union of geometries holds geometries: the name must exist before its content
            choices = [self._reference(f"{what}.{name}", each, name) for name, each in alternatives(cls).items()]
            # anyOf, not oneOf: "kind" already decides, and editors explain a failing anyOf better
            kinds = {"kind": {"enum": list(alternatives(cls))}}
            self.definitions[what] = {
                "type": "object",
                "required": ["kind"],
                "properties": kinds,
                **({"anyOf": choices} if choices else {}),
            }
        return {"$ref": f"#/$defs/{what}"}

    def _reference(self, key: str, cls: type, kind: str | None) -> dict[str, Any]:
        if key not in self.definitions:
            self.definitions[key] = {}
            self.definitions[key] = self._table(cls, kind)
        return {"$ref": f"#/$defs/{key}"}

    def _table(self, cls: type, kind: str | None) -> dict[str, Any]:
        properties: dict[str, Any] = {}
        if kind is not None:
            properties["kind"] = {"const": kind, "description": _summary(cls)}
        for name, (attribute, spec) in specs(cls).items():
            entry = self.value(attribute.type, spec) | {"description": text_of(spec)}
            default = default_of(attribute)
            if default is not attrs.NOTHING and default is not None and not is_part(type(default)):
                entry["default"] = plain(default)
            if spec.example is not None and not holds_parts(spec.example):
                entry["examples"] = [plain(spec.example)]
            properties[name] = entry
        return {
            "type": "object",
            "title": cls.__name__,
            "description": _summary(cls),
            "properties": properties,
            "required": (["kind"] if kind is not None else []) + required(cls),
            "additionalProperties": False,
        }

    def value(self, hint: Any, spec: Spec) -> dict[str, Any]:
        """What one key may hold."""
        if spec.choices is not None and hint in (str, float, int):
            return {"enum": [plain(c) for c in spec.choices]}
        if set(typing.get_args(Value)) <= set(typing.get_args(hint)):
            one = {"anyOf": [number(spec), {"type": "string", "description": "a formula"}]}
            return {"anyOf": [one, {"type": "array", "items": one}]}
        if hint == Vector:
            return {"anyOf": [number(spec), {"type": "array", "items": number(spec)}]}
        if hint is float:
            return number(spec)
        if hint is int:
            return {"type": "integer", **bounds(spec)}
        if hint in (bool, str):
            return {"type": "boolean" if hint is bool else "string"}
        if is_part(hint):
            reference = self.part(hint)
            if issubclass(hint, ConstitutiveModel):
                return {"anyOf": [{"type": "string", "description": f"name of a table in [{MATERIALS}]"}, reference]}
            return reference
        origin, arguments = typing.get_origin(hint), typing.get_args(hint)
        if origin is tuple:
            item = self.value(arguments[0], spec)
            # one item may stand for a list of one, as everywhere in mpmkit
            return {"anyOf": [{"type": "array", "items": item}, item]}
        if origin in (typing.Union, types.UnionType):
            options = [self.value(a, spec) for a in arguments if a is not type(None)]  # TOML has no none: a key is left out
            return options[0] if len(options) == 1 else {"anyOf": options}
        return {}


def number(spec: Spec) -> dict[str, Any]:
    """A number in SI with its bounds, or text with a unit."""
    return {"anyOf": [{"type": "number", **bounds(spec)}, {"type": "string", "pattern": QUANTITY_PATTERN}]}


def bounds(spec: Spec) -> dict[str, float]:
    """Bounds in the words of JSON Schema; an infinite bound only excludes infinity, which JSON cannot write."""
    names = {"exclusiveMinimum": spec.gt, "minimum": spec.ge, "exclusiveMaximum": spec.lt, "maximum": spec.le}
    return {name: bound for name, bound in names.items() if bound is not None and abs(bound) != float("inf")}


def text_of(spec: Spec) -> str:
    """Meaning, unit and range."""
    unit = f" [{spec.unit}]" if spec.unit != "1" else ""
    return f"{spec.doc}{unit}" + (f", {spec.bounds}" if spec.bounds else "")


def _summary(cls: type) -> str:
    if issubclass(cls, Component):
        entry = registry().of(cls.kind).get(cls.__name__)
        return cls.summary() + (f" ({entry.distribution} {entry.version})" if entry else "")
    return (cls.__doc__ or "").strip().split("\n")[0]
