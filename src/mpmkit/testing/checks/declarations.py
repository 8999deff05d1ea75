"""Checks for components of all kinds: what they declare and say about themselves, text, pickling."""

from __future__ import annotations

import inspect
import math
import pickle
import typing
from typing import Any

from mpmkit.errors import ParameterError
from mpmkit.fields import KERNEL_ARGUMENTS, PARTICLE_FIELDS
from mpmkit.interfaces import SPACES, Component
from mpmkit.parameters import Value, Vector, example_arguments, specs
from mpmkit.testing.calling import kernels_of
from mpmkit.testing.collect import check, expect


@check("all", "parameters are documented", once=True)
def parameters_are_documented(component: Component, rng: Any) -> None:
    """Each parameter has a meaning, a unit that exists and, if it is required, an example."""
    cls = type(component)
    for name, (attribute, spec) in specs(cls).items():
        expect(spec.doc.strip(), f"{cls.__name__}.{name} has no doc")
        if {float, Vector} & {attribute.type, *typing.get_args(attribute.type)} or attribute.type == Value:
            _unit(f"{cls.__name__}.{name}", spec.unit)
        if name in example_arguments(cls):
            expect(spec.example is not None, f"{cls.__name__}.{name} is required and has no example")


def _unit(path: str, unit: str) -> None:
    import pint

    try:
        pint.application_registry.Unit("" if unit == "1" else unit)
    except (AttributeError, ValueError) as error:
        raise AssertionError(f"{path}: {unit!r} is no unit ({error})") from None


@check("all", "bad values are refused", once=True)
def bad_values_are_refused(component: Component, rng: Any) -> None:
    """A number outside the declared bounds and a text where a number belongs raise `ParameterError`."""
    cls = type(component)
    for name, (attribute, spec) in specs(cls).items():
        if attribute.type is not float:
            continue
        sides = ((spec.gt, 0.0), (spec.lt, 0.0), (spec.ge, -1.0), (spec.le, 1.0))
        bad = [bound + shift * max(1.0, abs(bound)) for bound, shift in sides if bound is not None and math.isfinite(bound)]
        for value in [*bad, math.nan, "nonsense"]:
            try:
                cls(**(example_arguments(cls) | {name: value}))
            except ParameterError as error:
                expect(name in str(error), f"{cls.__name__}.{name} = {value!r}: the error does not name the parameter: {error}")
            else:
                raise AssertionError(f"{cls.__name__}.{name} accepts {value!r} (declared range: {spec.bounds or 'any number'})")


@check("all", "repr rebuilds it")
def repr_rebuilds_it(component: Component, rng: Any) -> None:
    """``eval(repr(component)) == component``, with the names of all registered components and of those it is made of."""
    from mpmkit._core.registry import registry

    own = [component, *(value for value in component.parameters().values() if isinstance(value, Component))]
    names = {e.name: e.component for e in registry().entries} | {type(one).__name__: type(one) for one in own}
    text = repr(component)
    expect(eval(text, names) == component, f"{text} does not rebuild an equal component")


@check("all", "pickles")
def pickles(component: Component, rng: Any) -> None:
    """A pickled copy is equal and has the same kernels."""
    copy = pickle.loads(pickle.dumps(component))
    expect(copy == component, f"the pickled copy of {component} differs")
    expect(set(kernels_of(copy)) == set(kernels_of(component)), f"the pickled copy of {component} has other kernels")


@check("all", "is frozen", once=True)
def is_frozen(component: Component, rng: Any) -> None:
    """Parameters cannot be changed after construction; a simulation is composed once."""
    for name in specs(type(component)):
        try:
            setattr(component, name, getattr(component, name))
        except AttributeError:
            continue
        raise AssertionError(f"{type(component).__name__}.{name} can be assigned: make the class with mpm.define")


@check("all", "docstring has equation and reference", once=True)
def docstring_has_equation_and_reference(component: Component, rng: Any) -> None:
    """One line of summary, an equation and, in ``references`` or in the docstring, a source."""
    cls = type(component)
    text = inspect.getdoc(cls) if cls.__doc__ else ""
    expect(text, f"{cls.__name__} has no docstring")
    assert text is not None
    summary = text.split("\n")[0].strip()
    expect(summary.endswith("."), f"the docstring of {cls.__name__} does not start with one sentence on one line: {summary!r}")
    everything = text + " ".join(k.__doc__ or "" for k in kernels_of(component).values())
    recipe = cls.kind in ("integrator", "discretization")  # their equations are the verbs of the step
    expect(
        recipe or "=" in everything or ".. math::" in text,
        f"neither the docstring of {cls.__name__} nor those of its kernels have an equation",
    )
    expect(cls.references or "References" in text, f"{cls.__name__} names no reference")


@check("all", "declared facts are known words", once=True)
def declared_facts_are_known_words(component: Component, rng: Any) -> None:
    """Spaces, precisions, and names of state fields, which no parameter, standard field, kernel argument or ledger column may have."""
    from mpmkit._core.running.ledger import COLUMNS

    cls = type(component)
    expect(cls.spaces and set(cls.spaces) <= set(SPACES), f"{cls.__name__}.spaces must be some of {SPACES}, got {cls.spaces}")
    expect(cls.precisions and set(cls.precisions) <= {"float64", "float32"}, f"{cls.__name__}.precisions: {cls.precisions}")
    taken: dict[str, Any] = {"a parameter": specs(cls), "a standard field": PARTICLE_FIELDS, "a kernel argument": KERNEL_ARGUMENTS}
    for field in component.state:
        who = f"{cls.__name__}: state field {field.name!r}"
        expect(field.name.isidentifier() and field.doc, f"{who} needs a name that is an identifier, and a doc")
        _unit(who, field.unit)
        for what, names in (taken | {"a column of the history": COLUMNS}).items():
            expect(field.name not in names, f"{who} has the name of {what}; results could not tell them apart")
