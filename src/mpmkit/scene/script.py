"""From a `Simulation` to a Python script that composes it again."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from mpmkit._core.registry import entry_of
from mpmkit.geometry import GEOMETRIES, Geometry
from mpmkit.interfaces import Component, ConstitutiveModel
from mpmkit.parameters import specs
from mpmkit.scene.formula import proposal
from mpmkit.scene.mistakes import Mistakes
from mpmkit.scene.parts import LISTS, SECTIONS, SETTINGS, is_part
from mpmkit.scene.writing import SIMULATION_DEFAULTS, is_default, material_name

NAMESPACES = {
    "shape": "shapes",
    "material": "materials",
    "contact": "contacts",
    "boundary": "boundaries",
    "integrator": "integrators",
    "transfer": "integrators",
    "effect": "effects",
    "discretization": "discretizations",
}
"""Module of `mpmkit` that shows the components of each kind."""

WIDTH = 100


class Script:
    """Writes one script.

    Parameters
    ----------
    mistakes : Mistakes
        Where things go that cannot be written: functions, and classes that cannot be imported.
    """

    def __init__(self, mistakes: Mistakes) -> None:
        self.mistakes = mistakes
        self.imports: dict[tuple[str, str], str] = {}
        self.materials: dict[str, Any] = {}

    def text(self, simulation: Any) -> str:
        """The script."""
        arguments = []
        for key in SECTIONS:
            part = getattr(simulation, key)
            if part is not None and key != "grid":
                with self.mistakes.at(key):
                    arguments.append((key, self._value(part, 1)))
        for key in SETTINGS:
            value = getattr(simulation, key)
            if value is not None and value != SIMULATION_DEFAULTS[key]:
                arguments.append((key, self._value(value, 1)))
        with self.mistakes.at("grid"):
            grid = self._value(simulation.grid, 0)
        added = []
        for key in LISTS:
            for k, part in enumerate(getattr(simulation, key)):
                with self.mistakes.at(key), self.mistakes.at(k):
                    added.append(f"sim += {self._value(part, 0)}")
        materials = []
        for name, material in self.materials.items():
            with self.mistakes.at("materials"), self.mistakes.at(name):
                materials.append(f"{name} = {self._call(material, 0)}")
        composed = _call("mpm.Simulation", [("", "grid"), *arguments], 0)
        blocks = [
            '"""Composes a simulation; running this file runs it."""',
            "import mpmkit as mpm" + "".join(f"\n{line}" for line in self._import_lines()),
            "\n".join([f"grid = {grid}", *materials]),
            "\n".join([f"sim = {composed}", *added]),
            'if __name__ == "__main__":\n    print(sim.explain())\n    sim.run()',
        ]
        return "\n\n".join(blocks) + "\n"

    def _import_lines(self) -> list[str]:
        modules: dict[str, list[str]] = {}
        for (module, name), local in sorted(self.imports.items()):
            modules.setdefault(module, []).append(name if name == local else f"{name} as {local}")
        return [f"from {module} import {', '.join(names)}" for module, names in modules.items()]

    def _value(self, value: Any, depth: int) -> str:
        if isinstance(value, ConstitutiveModel):
            return self._material(value)
        if is_part(type(value)):
            return self._call(value, depth)
        if isinstance(value, (tuple, list)):
            items = []
            for k, item in enumerate(value):
                with self.mistakes.at(k):
                    items.append(self._value(item, depth + 1))
            return _bracket("(", items, ")", depth, last_comma=len(items) == 1)
        if isinstance(value, np.ndarray):
            self.mistakes.add(f"is an array of {len(value)} rows, one for each particle; write this script by hand")
            return "..."
        if isinstance(value, str):
            return json.dumps(value, ensure_ascii=False)  # as Python, with the double quotes of the rest
        if isinstance(getattr(value, "text", None), str):
            return json.dumps(value.text, ensure_ascii=False)
        if callable(value):
            self.mistakes.add(f"is a Python function; give a formula as text instead, {proposal(value)}")
            return "..."
        return f'float("{value}")' if isinstance(value, float) and math.isinf(value) else repr(value)

    def _material(self, material: Any) -> str:
        for name, known in self.materials.items():
            if type(known) is type(material) and known == material:
                return name
        name = material_name(material, {*self.materials, "grid", "sim", "mpm"})
        self.materials[name] = material
        return name

    def _call(self, part: Any, depth: int) -> str:
        if isinstance(part, Geometry) and GEOMETRIES.get(type(part).__name__) is not type(part):
            self.mistakes.add(f"is a {type(part).__name__}, which holds arrays; write this script by hand")
            return "..."
        arguments = []
        for name, (attribute, _) in specs(type(part)).items():
            value = getattr(part, name)
            if not is_default(value, attribute):
                with self.mistakes.at(name):
                    arguments.append((name, self._value(value, depth + 1)))
        return _call(self._name(type(part)), arguments, depth)

    def _name(self, cls: type) -> str:
        """How the script calls a class; notes what it must import."""
        import mpmkit

        if not issubclass(cls, Component):
            if getattr(mpmkit, cls.__name__, None) is cls:
                return f"mpm.{cls.__name__}"
            return self._import(cls.__module__, cls.__name__, "object")
        if entry_of(cls) is not None:
            return self._import(f"mpmkit.{NAMESPACES[cls.kind]}", cls.__name__, cls.kind)
        if cls.__module__ == "__main__" or "<locals>" in cls.__qualname__:
            self.mistakes.add(
                f"{cls.__name__} is defined in a script, from where another one cannot import it; move it to a module or plugin"
            )
        return self._import(cls.__module__, cls.__name__, cls.kind)

    def _import(self, module: str, name: str, kind: str) -> str:
        if (module, name) not in self.imports:
            taken = set(self.imports.values())
            self.imports[module, name] = name if name not in taken else f"{name}_{kind}"
        return self.imports[module, name]


def _call(name: str, arguments: list[tuple[str, str]], depth: int) -> str:
    return name + _bracket("(", [f"{key}={value}" if key else value for key, value in arguments], ")", depth)


def _bracket(opening: str, items: list[str], closing: str, depth: int, last_comma: bool = False) -> str:
    """Items in brackets, on one line or one item a line."""
    line = opening + ", ".join(items) + ("," if last_comma else "") + closing
    if len(line) + 4 * depth <= WIDTH and "\n" not in line:
        return line
    pad = "    " * (depth + 1)
    return opening + "".join(f"\n{pad}{item}," for item in items) + "\n" + "    " * depth + closing
