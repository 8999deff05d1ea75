"""`define` and `parameter`: a component's parameters with unit, bounds, meaning and an example, each said once."""

from __future__ import annotations

import math
import numbers
import os
import types
import typing
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import attrs

from mpmkit.errors import ParameterError, PluginError, did_you_mean, shown
from mpmkit.fields import KERNEL_ARGUMENTS, PARTICLE_FIELDS

T = TypeVar("T")
Vector = tuple[float, ...]
"""A vector parameter: one number per space dimension; a single number is a vector of one component."""
Value = typing.Union[float, tuple[float, ...], str, Callable[..., Any]]  # noqa: UP007  (used at run time)
"""A constant, a formula in text such as "10*sin(2*pi*t)", or a scalar Python function of named arguments."""

_KEY = "mpmkit"


@attrs.frozen
class Spec:
    """What is declared about one parameter."""

    doc: str
    unit: str = "1"
    gt: float | None = None
    ge: float | None = None
    lt: float | None = None
    le: float | None = None
    choices: tuple[Any, ...] | None = None
    example: Any = None

    @property
    def bounds(self) -> str:
        """The allowed range as text, for example "> 0, < 0.5"; empty if there is none."""
        if self.choices is not None:
            return "one of " + ", ".join(repr(c) for c in self.choices)
        signs = (("> ", self.gt), (">= ", self.ge), ("< ", self.lt), ("<= ", self.le))
        return ", ".join(f"{sign}{bound:g}" for sign, bound in signs if bound is not None)


def parameter(
    doc: str,
    *,
    unit: str = "1",
    gt: float | None = None,
    ge: float | None = None,
    lt: float | None = None,
    le: float | None = None,
    choices: typing.Iterable[Any] | None = None,
    default: Any = attrs.NOTHING,
    example: Any = None,
    kw_only: bool = False,
) -> Any:
    """Declare one parameter of a component.

    Parameters
    ----------
    doc : str
        Meaning, in a few words.
    unit : str
        SI unit of the number; a string such as "200 GPa" is converted to it.
    gt, ge, lt, le : float, optional
        Bounds: greater than, greater or equal, less than, less or equal.
    choices : iterable, optional
        The allowed values.
    default : optional
        Value if none is given; without one the parameter is required.
    example : optional
        A sensible value; the conformance suite builds the component from the examples.
    kw_only : bool
        Given by keyword only.
    """
    spec = Spec(doc, unit, gt, ge, lt, le, None if choices is None else tuple(choices), example)
    return attrs.field(default=default, metadata={_KEY: spec}, kw_only=kw_only)


@typing.dataclass_transform(field_specifiers=(parameter,), frozen_default=True)
def define(cls: type[T]) -> type[T]:
    """Make a frozen component (or scene object) class from its annotated parameters.

    Values are converted and checked when an object is made: strings with units become SI numbers, bounds are
    enforced, and the error names the field, the value, the allowed range and the unit. A class may check
    parameters against each other in a method ``check(self)``, which raises `ParameterError`.
    """
    hints = typing.get_type_hints(cls)
    # a name the interface itself declares (the reference density rho of a constitutive model) is meant to be the parameter
    promised = {name for base in cls.__mro__[1:] for name in vars(base).get("__annotations__", {})}
    taken = (set(PARTICLE_FIELDS) | set(KERNEL_ARGUMENTS)) - promised if getattr(cls, "names_reach_kernels", False) else set()

    def transform(owner: type, fields: list[Any]) -> list[Any]:
        out = []
        for f in fields:
            spec = f.metadata.get(_KEY)
            if spec is None:
                raise PluginError(f"{cls.__name__}.{f.name}: declare it with mpm.parameter(doc, unit=..., example=...)")
            if f.name in taken:
                raise PluginError(f"{cls.__name__}.{f.name}: this name is taken by a standard field; kernels could not tell them apart")
            hint = hints.get(f.name, float)
            converter = partial(convert, hint=hint, spec=spec, path=f"{cls.__name__}.{f.name}")
            out.append(f.evolve(converter=converter, type=hint))
        return out

    return attrs.define(cls, frozen=True, slots=False, field_transformer=transform)


def specs(cls: type) -> dict[str, tuple[Any, Spec]]:
    """Parameters of a defined class: name -> (attrs attribute with its type, declaration)."""
    return {f.name: (f, f.metadata[_KEY]) for f in attrs.fields(cls) if _KEY in f.metadata}


def example_arguments(cls: type) -> dict[str, Any]:
    """The examples of all required parameters of `cls`."""
    return {n: s.example for n, (f, s) in specs(cls).items() if f.default is attrs.NOTHING}


def convert(value: Any, hint: Any, spec: Spec, path: str) -> Any:
    """Convert and check one value; raise `ParameterError` with path, value, range and remedy."""
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType) and hint != Value:
        if value is None and type(None) in args:
            return None
        if set(typing.get_args(Value)) <= set(args):
            return convert(value, Value, spec, path)
        kinds = [a for a in args if a is not type(None)]
        if len(kinds) == 1:
            return convert(value, kinds[0], spec, path)
        errors = []
        for kind in kinds:
            try:
                return convert(value, kind, spec, path)
            except ParameterError as error:
                errors.append(str(error))
        raise ParameterError(errors[0])
    if hint is float:
        return _in_bounds(_number(value, spec, path), spec, path)
    if hint is int:
        if isinstance(value, bool) or not isinstance(value, numbers.Integral):
            raise ParameterError(f"{path} must be a whole number, got {shown(value)} ({spec.doc})")
        return _in_bounds(int(value), spec, path)
    if hint is bool:
        if not isinstance(value, bool):
            raise ParameterError(f"{path} must be true or false, got {shown(value)} ({spec.doc})")
        return value
    if hint is str:
        value = os.fspath(value) if isinstance(value, os.PathLike) else value
        if not isinstance(value, str):
            raise ParameterError(f"{path} must be text, got {shown(value)} ({spec.doc})")
        return _chosen(value, spec, path)
    if hint == Vector:
        items = value if isinstance(value, (list, tuple)) or getattr(value, "ndim", None) else (value,)
        return tuple(_in_bounds(_number(v, spec, f"{path}[{k}]"), spec, f"{path}[{k}]") for k, v in enumerate(items))
    if hint == Value:
        if callable(value) or getattr(value, "ndim", 0) > 1:  # rows of many points are checked by the class that takes them
            return value
        if isinstance(value, str):
            return _formula(value, spec, path)
        if isinstance(value, (list, tuple)) or getattr(value, "ndim", None) == 1:
            return tuple(convert(v, Value if isinstance(v, str) else float, spec, f"{path}[{k}]") for k, v in enumerate(value))
        return convert(value, float, spec, path)
    if origin is tuple:
        items = value if isinstance(value, (list, tuple)) or getattr(value, "ndim", None) else (value,)
        return tuple(convert(v, args[0], spec, f"{path}[{k}]") for k, v in enumerate(items))
    if isinstance(hint, type) and hint is not Any:  # a class since Python 3.11
        if not isinstance(value, hint):
            raise ParameterError(f"{path} must be a {hint.__name__}, got {shown(value)} ({spec.doc})")
        return value
    return value


def _formula(text: str, spec: Spec, path: str) -> float | str:
    """The text of a formula, checked; or the number in SI if it is a quantity such as "3 mm/s"."""
    import re

    from mpmkit.expression import Expression
    from mpmkit.units import QUANTITY, to_si

    try:
        Expression(text, path=path)
    except ParameterError:
        if not re.fullmatch(QUANTITY, text):
            raise
        return _in_bounds(to_si(text, spec.unit, path), spec, path)  # type: ignore[no-any-return]
    return text


def _number(value: Any, spec: Spec, path: str) -> float:
    if isinstance(value, str):
        from mpmkit.units import to_si

        return to_si(value, spec.unit, path)
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise ParameterError(f"{path} must be a number [{spec.unit}], got {shown(value)} ({spec.doc})")
    try:
        number = float(value)
    except OverflowError:
        raise ParameterError(f"{path} is too large for a floating point number, got {shown(value)} ({spec.doc} [{spec.unit}])") from None
    if math.isnan(number):
        raise ParameterError(f"{path} must be a number [{spec.unit}], got nan ({spec.doc})")
    return number


def _in_bounds(value: Any, spec: Spec, path: str) -> Any:
    ok = (
        (spec.gt is None or value > spec.gt)
        and (spec.ge is None or value >= spec.ge)
        and (spec.lt is None or value < spec.lt)
        and (spec.le is None or value <= spec.le)
    )
    if not ok:
        raise ParameterError(f"{path} must be {spec.bounds}, got {_text(value)} ({spec.doc} [{spec.unit}])")
    return _chosen(value, spec, path)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else shown(value)


def _chosen(value: Any, spec: Spec, path: str) -> Any:
    if spec.choices is not None and value not in spec.choices:
        hint = did_you_mean(str(value), [str(c) for c in spec.choices])
        raise ParameterError(f"{path} must be {spec.bounds}, got {shown(value)}{hint} ({spec.doc})")
    return value
