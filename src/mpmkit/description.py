"""Everything a component declares about itself, as plain data: for `mpmkit describe`, the docs and other programs."""

from __future__ import annotations

import inspect
import re
import typing
from typing import Any

import attrs

from mpmkit._core.registry import entry_of
from mpmkit.errors import MpmkitError
from mpmkit.interfaces import Component
from mpmkit.kernels import Kernel
from mpmkit.parameters import Value, Vector, example_arguments, specs


def describe(cls: type) -> dict[str, Any]:
    """Facts about a component or scene object class.

    Returns
    -------
    dict
        name, kind, summary, text (rest of the docstring), sections (docstring sections by title), parameters, and for
        components: kernels, state, capabilities, references, known failures, plugin, distribution, version, module.
    """
    text, sections = split_docstring(inspect.getdoc(cls) or "")
    summary, _, rest = text.partition("\n")
    data: dict[str, Any] = {
        "name": cls.__name__,
        "kind": getattr(cls, "kind", "") or "scene object",
        "summary": summary,
        "text": rest.strip(),
        "sections": sections,
        "parameters": [parameter(name, attribute, spec) for name, (attribute, spec) in specs(cls).items()],
        "module": cls.__module__,
    }
    if not issubclass(cls, Component):
        return data
    entry = entry_of(cls)
    return data | {
        "kernels": {
            name: {"arguments": list(kernel.arguments), "summary": first_line(kernel.__doc__)} for name, kernel in kernels(cls).items()
        },
        "state": [{"name": f.name, "unit": f.unit, "doc": f.doc, "shape": f.shape, "initial": f.initial} for f in cls.state],
        "capabilities": cls.capabilities(),
        "references": list(cls.references),
        "known failures": dict(cls.expected_failures),
        "plugin": entry.plugin if entry else None,
        "distribution": entry.distribution if entry else None,
        "version": entry.version if entry else None,
    }


def kernels(cls: type[Component]) -> dict[str, Kernel]:
    """Kernels of a component built from its examples: which ones it supplies may depend on its parameters."""
    try:
        component: Any = cls(**example_arguments(cls))
    except MpmkitError:
        component = cls  # the conformance suite reports examples that do not work; here the class itself must do
    hooks = {name: getattr(component, name, None) for name in [*cls.kernels(), *_hook_names(cls)]}
    return {name: hook for name, hook in hooks.items() if isinstance(hook, Kernel)}


def _hook_names(cls: type[Component]) -> list[str]:
    """Attributes that the interface declares as kernels."""
    return [name for base in cls.__mro__ for name, hint in getattr(base, "__annotations__", {}).items() if "Kernel" in str(hint)]


def parameter(name: str, attribute: Any, spec: Any) -> dict[str, Any]:
    """One parameter as plain data."""
    default = default_of(attribute)
    return {
        "name": name,
        "type": type_text(attribute.type),
        "unit": spec.unit,
        "doc": spec.doc,
        "bounds": spec.bounds,
        "required": attribute.default is attrs.NOTHING,
        "default": None if default is attrs.NOTHING else plain(default),
        "example": plain(spec.example),
    }


def default_of(attribute: Any) -> Any:
    """Default value of a parameter; `attrs.NOTHING` if there is none."""
    factory = getattr(attribute.default, "factory", None)
    return attribute.default if factory is None else factory()


def plain(value: Any) -> Any:
    """A value as numbers, text and lists."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else str(value)


def type_text(hint: Any) -> str:
    """A type in words a user of scene files knows."""
    if hint == Value:
        return "number, vector, formula or function"
    if hint == Vector:
        return "vector"
    names = {float: "number", int: "whole number", bool: "true or false", str: "text", type(None): "none", Any: "any"}
    if hint in names:
        return names[hint]
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is tuple:
        return f"list of {type_text(arguments[0])}"
    if arguments:
        return " or ".join(type_text(a) for a in arguments if a is not type(None))
    return getattr(hint, "__name__", str(hint))


def split_docstring(text: str) -> tuple[str, dict[str, str]]:
    """The part before the first underlined title, and the sections by title."""
    pieces = re.split(r"^([^\n]+)\n-{3,}[ ]*$\n?", text, flags=re.MULTILINE)
    return pieces[0].strip(), {title.strip(): body.strip("\n").rstrip() for title, body in zip(pieces[1::2], pieces[2::2], strict=True)}


def first_line(text: str | None) -> str:
    """The first line of a docstring."""
    return (text or "").strip().split("\n")[0]
