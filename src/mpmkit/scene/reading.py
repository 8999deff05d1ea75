"""From plain data to a `Simulation`: tables structured into the classes that scripts use, every mistake noted."""

from __future__ import annotations

import json
import typing
from typing import Any

import cattrs

from mpmkit._core.registry import registry
from mpmkit.description import plain
from mpmkit.errors import MpmkitError, ParameterError, PluginError, did_you_mean, shown
from mpmkit.interfaces import Component, ConstitutiveModel
from mpmkit.parameters import Spec, convert, specs
from mpmkit.scene.mistakes import WRONG, Mistakes, Wrong
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
    parts_in,
    required,
)
from mpmkit.simulation import Simulation


class Reader:
    """Structures one scene.

    A hook that finds a mistake notes it with its path and returns `WRONG`; reading goes on beside it, so that one
    pass finds all mistakes of all tables. Only checks between the parameters of one object have to wait until each of
    them is right.

    Parameters
    ----------
    mistakes : Mistakes
        Where mistakes go; it also knows the path.
    """

    def __init__(self, mistakes: Mistakes) -> None:
        self.mistakes = mistakes
        self.materials: dict[str, Any] = {}
        self.converter = cattrs.Converter()
        self.converter.register_structure_hook_func(is_part, self._fixed)
        self.converter.register_structure_hook_func(lambda cls: is_part(cls) and is_open(cls), self._by_kind)
        self.converter.register_structure_hook_func(lambda cls: cls is Simulation, self._simulation)

    def simulation(self, data: dict[str, Any]) -> Any:
        """The simulation that `data` describes, or `WRONG`."""
        return self.converter.structure(data, Simulation)

    def _simulation(self, data: dict[str, Any], _: type) -> Any:
        for key in data:
            if key not in KNOWN:
                self._unknown(key, KNOWN[1:], "a scene")
        for key in REQUIRED if "discretization" in data else (*REQUIRED, *REQUIRED_FOR_MPM):
            if key not in data:
                way_out = ", or a table [discretization] in place of MPM" if key in REQUIRED_FOR_MPM else ""
                self.mistakes.add(f"required table [{key}] is missing{way_out}")
        self._read_materials(data.get(MATERIALS, {}))
        arguments: dict[str, Any] = {}
        for key, spec in SETTINGS.items():
            if key in data:
                with self.mistakes.at(key):
                    arguments[key] = self._leaf(data[key], SETTING_TYPES[key], spec)
        for key, cls in SECTIONS.items():
            if key in data:
                with self.mistakes.at(key):
                    arguments[key] = self.converter.structure(data[key], cls)
        items = [item for key, cls in LISTS.items() if key in data for item in self._list(key, data[key], cls)]
        if self.mistakes.found:
            return WRONG
        try:
            simulation = Simulation(**arguments)
            for item in items:
                simulation += item
        except MpmkitError as error:
            return self.mistakes.add(str(error))
        return simulation

    def _read_materials(self, tables: Any) -> None:
        with self.mistakes.at(MATERIALS):
            if not isinstance(tables, dict):
                self.mistakes.add(f"must be tables [materials.NAME], got {shown(tables)}")
                return
            for name, table in tables.items():
                with self.mistakes.at(name):
                    self.materials[name] = self.converter.structure(table, ConstitutiveModel)

    def _list(self, key: str, tables: Any, cls: type) -> list[Any]:
        with self.mistakes.at(key):
            if not isinstance(tables, list):
                self.mistakes.add(f"must be an array of tables, written [[{key}]], got {shown(tables)}")
                return []
            made: list[Any] = []
            for k, table in enumerate(tables):
                with self.mistakes.at(k):
                    made.append(self.converter.structure(table, cls))
            return made

    def _by_kind(self, table: Any, cls: type) -> Any:
        """A component or geometry, chosen by the key "kind"."""
        known = alternatives(cls)
        names = ", ".join(known)
        if not isinstance(table, dict):
            example = next(iter(known), "...")
            return self.mistakes.add(f'must be a table such as {{ kind = "{example}" }}, got {shown(table)}')
        if "kind" not in table:
            return self.mistakes.add(f"required key 'kind' is missing; one of {names}")
        with self.mistakes.at("kind"):
            chosen = self._look_up(table["kind"], cls)
        if isinstance(chosen, Wrong):
            return WRONG
        return self._build({key: value for key, value in table.items() if key != "kind"}, chosen)

    def _look_up(self, name: Any, cls: type) -> Any:
        """The class with this name among the alternatives to `cls`."""
        _, what = interface(cls)
        if not isinstance(name, str):
            return self.mistakes.add(f"must be the name of a {what}, got {shown(name)}")
        if not issubclass(cls, Component):
            known = alternatives(cls)
            if name not in known:
                return self.mistakes.add(f"no {what} named {shown(name)}{did_you_mean(name, known)}\n  known: {', '.join(known)}")
            return known[name]
        try:
            return registry().get(name, *([cls.kind] if cls.kind else [])).component
        except PluginError as error:
            others = sorted({e.kind for e in registry().entries if e.name == name})
            note = (
                f"{shown(name)} is a component of kind {' and '.join(others)}, here a {what} is wanted\n  "
                if others and what not in others
                else ""
            )
            return self.mistakes.add(f"{note}{error}")

    def _fixed(self, table: Any, cls: type) -> Any:
        """An object of a class that has no alternatives, such as `Grid`."""
        if not isinstance(table, dict):
            return self.mistakes.add(f"must be a table with the keys {', '.join(specs(cls))}, got {shown(table)}")
        return self._build(table, cls)

    def _build(self, table: dict[str, Any], cls: type) -> Any:
        """Check every key of a table, then make the object."""
        known = specs(cls)
        before = len(self.mistakes.found)
        for key in table:
            if key not in known:
                self._unknown(key, known, cls.__name__)
        for name in required(cls):
            if name not in table:
                spec = known[name][1]
                self.mistakes.add(f"required key {name!r} is missing ({describe(spec)})")
        values = {}
        for name, value in table.items():
            if name in known:
                attribute, spec = known[name]
                with self.mistakes.at(name):
                    values[name] = self._field(value, attribute.type, spec)
        if len(self.mistakes.found) > before or any(isinstance(value, Wrong) for value in values.values()):
            return WRONG
        try:
            return cls(**values)
        except MpmkitError as error:
            return self.mistakes.add(str(error))
        except Exception as error:  # noqa: BLE001  (a third party's own check may raise anything)
            return self.mistakes.add(f"{cls.__name__} refuses these values: {type(error).__name__}: {error}")

    def _field(self, value: Any, hint: Any, spec: Spec) -> Any:
        """One value, which may hold tables."""
        parts = parts_in(hint)
        if parts:
            value = self._nested(value, hint, parts)
            if isinstance(value, Wrong):
                return WRONG
        return self._leaf(value, hint, spec)

    def _nested(self, value: Any, hint: Any, parts: list[type]) -> Any:
        """The objects that stand for the tables in a value."""
        if isinstance(value, dict):
            return self.converter.structure(value, parts[0])
        if isinstance(value, list):
            inner = typing.get_args(hint)[0] if typing.get_origin(hint) is tuple else hint
            items = []
            for k, item in enumerate(value):
                with self.mistakes.at(k):
                    items.append(self._nested(item, inner, parts))
            return WRONG if any(isinstance(item, Wrong) for item in items) else tuple(items)
        if isinstance(value, str) and any(issubclass(part, ConstitutiveModel) for part in parts):
            if value not in self.materials:
                names = ", ".join(self.materials) or "none"
                hint_ = did_you_mean(value, self.materials)
                return self.mistakes.add(f"no material is named {shown(value)} in [materials]{hint_} (named there: {names})")
            return self.materials[value]
        if is_part(hint):
            return self.converter.structure(value, hint)
        return value

    def _leaf(self, value: Any, hint: Any, spec: Spec) -> Any:
        """One converted and checked value."""
        try:
            return convert(value, hint, spec, self.mistakes.path)
        except ParameterError as error:
            return self.mistakes.add(str(error))

    def _unknown(self, key: str, known: Any, owner: str) -> None:
        with self.mistakes.at(key):
            self.mistakes.add(f"unknown key {shown(key)}{did_you_mean(key, known)} ({owner} has {', '.join(known)})")


def describe(spec: Spec) -> str:
    """Meaning, unit, range and example of a parameter in one line."""
    parts = [f"{spec.doc} [{spec.unit}]" if spec.unit != "1" else spec.doc]
    if spec.bounds:
        parts.append(spec.bounds)
    if spec.example is not None and not holds_parts(spec.example):
        parts.append(f"for example {json.dumps(plain(spec.example))}")
    return ", ".join(parts)
