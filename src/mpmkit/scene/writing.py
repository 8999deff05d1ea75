"""From a `Simulation` to plain data, with defaults left out and numbers in SI."""

from __future__ import annotations

from typing import Any

import attrs
import cattrs
import numpy as np

from mpmkit._core.registry import entry_of
from mpmkit.description import default_of
from mpmkit.geometry import GEOMETRIES, Geometry
from mpmkit.interfaces import Component, ConstitutiveModel
from mpmkit.parameters import specs
from mpmkit.scene.formula import proposal
from mpmkit.scene.mistakes import WRONG, Mistakes
from mpmkit.scene.parts import LISTS, MATERIALS, SECTIONS, SETTINGS, is_open, is_part


class Table(dict[str, Any]):
    """Keys and values of one object, with the unit of each key for the comments of the file."""

    def __init__(self) -> None:
        super().__init__()
        self.units: dict[str, str] = {}


class Writer:
    """Turns one simulation into tables.

    Parameters
    ----------
    mistakes : Mistakes
        Where things go that a scene file cannot hold: functions, and classes that no plugin registers.
    """

    def __init__(self, mistakes: Mistakes) -> None:
        self.mistakes = mistakes
        self.materials: dict[str, Any] = {}
        self.converter = cattrs.Converter()
        self.converter.register_unstructure_hook_func(is_part, self._table)
        self.converter.register_unstructure_hook_func(lambda cls: is_part(cls) and issubclass(cls, ConstitutiveModel), self._material)

    def simulation(self, simulation: Any) -> Table:
        """All tables of a scene file."""
        data, sections, lists = Table(), Table(), Table()
        for key, spec in SETTINGS.items():
            value = getattr(simulation, key)
            if value is not None and value != SIMULATION_DEFAULTS[key]:
                data[key] = value
                data.units[key] = spec.unit
        for key in SECTIONS:
            part = getattr(simulation, key)
            if part is not None:
                with self.mistakes.at(key):
                    sections[key] = self.converter.unstructure(part)
        for key in LISTS:
            tables = []
            for k, part in enumerate(getattr(simulation, key)):
                with self.mistakes.at(key), self.mistakes.at(k):
                    tables.append(self.converter.unstructure(part))
            if tables:
                lists[key] = tables
        materials = Table()
        for name, material in self.materials.items():
            with self.mistakes.at(MATERIALS), self.mistakes.at(name):
                materials[name] = self._table(material)
        data.update(sections)
        if materials:
            data[MATERIALS] = materials
        data.update(lists)
        return data

    def _material(self, material: Any) -> str:
        """The name of a material's table; bodies of the same material share it."""
        for name, known in self.materials.items():
            if type(known) is type(material) and known == material:
                return name
        name = material_name(material, self.materials)
        self.materials[name] = material
        return name

    def _table(self, part: Any) -> Any:
        cls = type(part)
        table = Table()
        if is_open(cls):
            if isinstance(part, Component) and entry_of(cls) is None:
                return self.mistakes.add(
                    f"{cls.__name__} is a class of {cls.__module__!r} that no plugin registers, so a scene file cannot name it; "
                    "give it an entry point in the group 'mpmkit'"
                )
            if isinstance(part, Geometry) and GEOMETRIES.get(cls.__name__) is not cls:
                return self.mistakes.add(f"is a {cls.__name__}; a scene file names only {', '.join(GEOMETRIES)}; keep the script")
            table["kind"] = cls.__name__
        for name, (attribute, spec) in specs(cls).items():
            value = getattr(part, name)
            if not is_default(value, attribute):
                with self.mistakes.at(name):
                    table[name] = self._value(value)
                table.units[name] = spec.unit
        return table

    def _value(self, value: Any) -> Any:
        if is_part(type(value)):
            return self.converter.unstructure(value)
        if isinstance(value, (bool, int, float, str)):
            return value
        if isinstance(value, np.ndarray):
            return self.mistakes.add(f"is an array of {len(value)} rows, one for each particle; keep the script")
        if isinstance(value, (tuple, list)):
            items = []
            for k, item in enumerate(value):
                with self.mistakes.at(k):
                    items.append(self._value(item))
            return items
        if isinstance(getattr(value, "text", None), str):
            return value.text
        if callable(value):
            return self.mistakes.add(f"is a Python function; give a formula as text instead, {proposal(value)}")
        self.mistakes.add(f"{value!r} cannot be written to a scene file")
        return WRONG


SIMULATION_DEFAULTS = {"until": None, "precision": "float64", "leaving": "stop", "retries": 3}


def is_default(value: Any, attribute: attrs.Attribute[Any]) -> bool:
    """Whether a parameter has its default value, so that it need not be written."""
    default = default_of(attribute)
    if default is attrs.NOTHING:
        return False
    if isinstance(value, np.ndarray) or isinstance(default, np.ndarray):
        return np.array_equal(value, default)
    return type(value) is type(default) and bool(value == default)


def material_name(material: Any, taken: Any) -> str:
    """A name for a material: its class in small letters with underscores, numbered if that is taken."""
    import re

    name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", type(material).__name__).lower()
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name}_{number}"
    return free
