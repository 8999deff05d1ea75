"""Building components from their examples, and calling their kernels by argument names."""

from __future__ import annotations

import json
import typing
from collections.abc import Iterator, Mapping
from typing import Any

from mpmkit.errors import FieldContractError, ParameterError, did_you_mean
from mpmkit.interfaces import Component
from mpmkit.kernels import Kernel
from mpmkit.parameters import Value, example_arguments, specs


def variants(cls: type[Component]) -> Iterator[tuple[str, Component]]:
    """Components made from the examples: the required ones, then with each other choice or example in turn.

    The text in front names what differs, for example ``[strain="small"]``; it is empty for the first. Optional parameters
    keep their defaults, unless the component refuses them in this combination: then their examples are taken too.

    Raises
    ------
    ParameterError
        If the component refuses its examples.
    """
    component = _build(cls, {})
    made = [component]
    yield "", component
    for name, (attribute, spec) in specs(cls).items():
        several = typing.get_origin(attribute.type) is tuple
        for value in spec.choices if spec.choices is not None and not several else [spec.example]:
            if value is not None and value != getattr(component, name):
                other = _build(cls, {name: value})
                if other not in made:
                    made.append(other)
                    yield f"[{name}={_text(value)}]", other


def _build(cls: type[Component], chosen: dict[str, Any]) -> Component:
    required = example_arguments(cls)
    try:
        return cls(**(required | chosen))
    except ParameterError:
        examples = {name: spec.example for name, (_, spec) in specs(cls).items() if spec.example is not None}
        return cls(**(examples | chosen))


def _text(value: Any) -> str:
    return json.dumps(value) if isinstance(value, (str, int, float, bool)) else str(value)


def kernels_of(component: Component) -> dict[str, Kernel]:
    """Hook name -> kernel, of this instance (the choice of a kernel may depend on parameters)."""
    found = {name: getattr(component, name) for name in dir(component) if not name.startswith("__")}
    return {name: value for name, value in found.items() if isinstance(value, Kernel)}


def arguments(component: Component, kernel: Kernel, given: Mapping[str, Any]) -> list[Any]:
    """Values of a kernel's arguments: parameters and properties of the component first, then `given`.

    Raises
    ------
    FieldContractError
        If the kernel asks for a name that is neither; says which names there are.
    """
    return [_argument(component, kernel, name, given) for name in kernel.arguments]


def _argument(component: Component, kernel: Kernel, name: str, given: Mapping[str, Any]) -> Any:
    spec = specs(type(component)).get(name)
    hint: Any = spec[0].type if spec else None
    is_value = hint == Value
    own = getattr(component, name, None)
    if not is_value and not isinstance(own, Kernel):
        if isinstance(own, (bool, int, float)):
            return float(own)
        if isinstance(own, tuple) and all(isinstance(v, (int, float)) for v in own):
            return tuple(map(float, own)) + (0.0,) * (3 - len(own))
    if name in given:
        return given[name]
    if is_value:
        return (0.5, -0.25, 0.125)  # the core evaluates formulas; a kernel sees three numbers
    names = [*given, *specs(type(component))]
    raise FieldContractError(
        f"{type(component).__name__}: {kernel} asks for {name!r}, which is no parameter, property or state of it and no field that "
        f"a kernel of this kind may ask for{did_you_mean(name, names)} (known: {', '.join(sorted(names))})"
    )


def call(component: Component, kernel: Kernel, given: Mapping[str, Any]) -> Any:
    """Result of a kernel as plain Python, its arguments filled by name."""
    return kernel.function(*arguments(component, kernel, given))


def flat(result: Any) -> list[float]:
    """All numbers in a kernel's result, in order."""
    if isinstance(result, tuple):
        return [number for part in result for number in flat(part)]
    return [float(result)]
