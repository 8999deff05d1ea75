"""Setting a field of a scene by its path, on the plain data of the scene: "grid.spacing", "bodies.*.particles_per_cell" ..."""

from __future__ import annotations

import copy
import re
import typing
from typing import Any

from mpmkit._core.registry import registry
from mpmkit.description import default_of
from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.interfaces import Component, ConstitutiveModel
from mpmkit.parameters import specs
from mpmkit.scene.mistakes import Mistakes
from mpmkit.scene.parts import LISTS, MATERIALS, SECTIONS, SETTINGS, alternatives, is_open, parts_in
from mpmkit.scene.writing import Writer

Data = dict[str, Any]

NONE = "none"
"""As the value of a list or an optional component: there is none of them."""
MPM = "MPM"
"""As the value of the discretization: the scene's own shape function and integrator."""
TOPS = (*SETTINGS, *SECTIONS, MATERIALS, *LISTS)


def split(path: str) -> list[str]:
    """Steps of a path; ``bodies[0].material`` and ``bodies.0.material`` are the same."""
    steps = re.sub(r"\[(\w+|\*)\]", r".\1", path).split(".")
    if not all(steps):
        raise ParameterError(f"axis {path!r} is no path into a scene; write for example 'grid.spacing' or 'bodies[0].material.E'")
    return steps


def put(data: Data, path: str, value: Any) -> None:
    """Change one field of a scene's plain data in place.

    A name in place of a component ("Linear") changes its class and keeps those of its parameters that the new class also has; a
    table replaces it. ``*`` stands for every item of a list; an item is also found by its name or kind. A body that uses a named
    material gets a material of its own when a parameter of it is set through the body.

    Raises
    ------
    ParameterError
        If the scene has no such field: names the step, what there is, and the nearest name.
    """
    top, *rest = split(path)
    if top not in TOPS:
        raise ParameterError(f"axis {path!r}: a scene has no {top!r}{did_you_mean(top, TOPS)} (it has {', '.join(TOPS)})")
    if top == "discretization" and not rest:
        _discretization(data, value, path)
    elif top in LISTS:
        _list(data, top, rest, value, path)
    elif top == MATERIALS:
        _material(data, rest, value, path)
    elif top in SECTIONS:
        if not rest:
            data[top] = _part(data, SECTIONS[top], value, data.get(top), path)
        elif top not in data:
            raise ParameterError(f"axis {path!r}: the scene has no table [{top}]")
        else:
            _inside(data, data[top], SECTIONS[top], rest, value, path)
    elif rest:
        raise ParameterError(f"axis {path!r}: {top!r} is a single value; use the axis {top!r}")
    else:
        data[top] = value


def _discretization(data: Data, value: Any, path: str) -> None:
    """Another method stands in place of shape function and integrator."""
    if value == MPM:
        data.pop("discretization", None)
        return
    data["discretization"] = _part(data, SECTIONS["discretization"], value, None, path)
    for name in ("shape", "integrator"):
        data.pop(name, None)


def _list(data: Data, top: str, rest: list[str], value: Any, path: str) -> None:
    cls = LISTS[top]
    if not rest:
        items = [] if value == NONE else value if isinstance(value, list) else [value]
        data[top] = [_part(data, cls, item, None, path) for item in items]
        return
    items = data.get(top, [])
    found = _items(items, rest[0])
    if not found:
        names = [str(item.get("name") or item.get("kind") or k) for k, item in enumerate(items)]
        told = f"it has {', '.join(names)}" if names else f"it has no {top}"
        raise ParameterError(f"axis {path!r}: the scene has no {top}[{rest[0]}]{did_you_mean(rest[0], names)} ({told})")
    for k in found:
        if len(rest) == 1:
            items[k] = _part(data, cls, value, items[k], path)
        else:
            _inside(data, items[k], cls, rest[1:], value, path)


def _items(items: list[Any], step: str) -> list[int]:
    """Which items of a list a step means: all, by number, by name, by kind."""
    if step == "*":
        return list(range(len(items)))
    if step.isdigit():
        return [int(step)] if int(step) < len(items) else []
    return [k for k, item in enumerate(items) if step in (item.get("name"), item.get("kind"))]


def _material(data: Data, rest: list[str], value: Any, path: str) -> None:
    materials = data.get(MATERIALS, {})
    if not rest or (rest[0] != "*" and rest[0] not in materials):
        near = did_you_mean(rest[0], materials) if rest else ""
        raise ParameterError(f"axis {path!r}: name a material of the scene{near} (it has {', '.join(materials) or 'no named materials'})")
    for name in materials if rest[0] == "*" else rest[:1]:
        if len(rest) == 1:
            materials[name] = _part(data, ConstitutiveModel, value, materials[name], path)
        else:
            _inside(data, materials[name], ConstitutiveModel, rest[1:], value, path)


def _inside(data: Data, table: Any, cls: type, rest: list[str], value: Any, path: str) -> None:
    """Go down into a table that stands for an object of `cls`."""
    owner = alternatives(cls).get(table.get("kind", ""), cls) if is_open(cls) else cls
    known = specs(owner)
    step = rest[0]
    if step == "kind" and is_open(cls) and len(rest) == 1:
        new = _part(data, cls, value, dict(table), path)
        table.clear()
        table.update(new)
        return
    if step not in known:
        raise ParameterError(
            f"axis {path!r}: {owner.__name__} has no field {step!r}{did_you_mean(step, known)} (it has {', '.join(known)})"
        )
    attribute = known[step][0]
    parts = parts_in(attribute.type)
    if len(rest) == 1:
        table[step] = _part(data, parts[0], value, table.get(step), path) if parts else value
        return
    child = table.get(step)
    if isinstance(child, list) and rest[1].isdigit() and not parts:
        if int(rest[1]) >= len(child):
            raise ParameterError(f"axis {path!r}: {step} has {len(child)} numbers")
        child[int(rest[1])] = value
        return
    if not parts:
        raise ParameterError(f"axis {path!r}: {owner.__name__}.{step} is a single value; use the axis without {'.'.join(rest[1:])!r}")
    if isinstance(child, str):
        if child not in data.get(MATERIALS, {}):
            raise ParameterError(f"axis {path!r}: the scene names no material {child!r}")
        child = copy.deepcopy(data[MATERIALS][child])
    if child is None:
        child = table_of(default_of(attribute))
    if not isinstance(child, dict):
        raise ParameterError(f"axis {path!r}: {owner.__name__}.{step} is not given in the scene; give it there first")
    table[step] = child
    _inside(data, child, parts[0], rest[1:], value, path)


def _part(data: Data, cls: type, value: Any, old: Any, path: str) -> Any:
    """What stands in the scene for a value given for an object of `cls`: a table."""
    if not isinstance(value, str) or not is_open(cls):
        return copy.deepcopy(value)
    if issubclass(cls, ConstitutiveModel) and value in data.get(MATERIALS, {}):
        return value
    known = alternatives(cls)
    if value not in known:
        if issubclass(cls, Component):
            registry().get(value, *([cls.kind] if cls.kind else []))  # its message tells of plugins that were not loaded, too
        raise ParameterError(f"axis {path!r}: no {cls.__name__.lower()} named {value!r}{did_you_mean(value, known)}")
    if isinstance(old, str):
        old = data.get(MATERIALS, {}).get(old)
    kept = {k: copy.deepcopy(v) for k, v in old.items() if k in specs(known[value])} if isinstance(old, dict) else {}
    return {"kind": value, **kept}


def table_of(part: Any) -> Any:
    """A component, geometry or other scene object as the table of a scene file; other values as they are.

    Raises
    ------
    SceneError
        If a scene file cannot hold it.
    """
    from mpmkit.scene.parts import is_part

    if isinstance(part, (list, tuple)):
        return [table_of(item) for item in part]
    if not is_part(type(part)):
        return part
    mistakes = Mistakes("a value of an axis cannot be written to a scene")
    table = Writer(mistakes)._table(part)
    mistakes.raise_if_any()
    return typing.cast("Any", table)
