"""Checks for components of all kinds: declarations, text, pickling, and that compiled kernels are the plain ones."""

from __future__ import annotations

import inspect
import math
import pickle
from functools import cache
from typing import Any

import numpy as np

from mpmkit.errors import ParameterError
from mpmkit.interfaces import SPACES, Component
from mpmkit.parameters import Value, example_arguments, specs
from mpmkit.testing.calling import arguments, call, flat, kernels_of
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.points import sample


def has_kernels(component: Component) -> bool:
    """Condition of the checks on kernels."""
    return bool(kernels_of(component))


@check("all", "parameters are documented", once=True)
def parameters_are_documented(component: Component, rng: Any) -> None:
    """Each parameter has a meaning, a unit that exists and, if it is required, an example."""
    cls = type(component)
    for name, (attribute, spec) in specs(cls).items():
        expect(spec.doc.strip(), f"{cls.__name__}.{name} has no doc")
        if attribute.type in (float, Value):
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
    """``eval(repr(component)) == component``."""
    from mpmkit._core.registry import registry

    names = {e.name: e.component for e in registry().entries} | {type(component).__name__: type(component)}
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
    """Spaces, precisions and names of state fields."""
    cls = type(component)
    expect(cls.spaces and set(cls.spaces) <= set(SPACES), f"{cls.__name__}.spaces must be some of {SPACES}, got {cls.spaces}")
    expect(cls.precisions and set(cls.precisions) <= {"float64", "float32"}, f"{cls.__name__}.precisions: {cls.precisions}")
    for field in component.state:
        expect(
            field.name.isidentifier() and field.doc,
            f"{cls.__name__}: state field {field.name!r} needs a name that is an identifier, and a doc",
        )
        expect(field.name not in specs(cls), f"{cls.__name__}: {field.name!r} is both a parameter and a state field")


@check("all", "kernel arguments resolve", when=has_kernels)
def kernel_arguments_resolve(component: Component, rng: Any) -> None:
    """Every argument is a parameter or property of the component, its state, or a field that its kind may ask for."""
    given = sample(component, rng)
    for kernel in kernels_of(component).values():
        arguments(component, kernel, given)  # raises with the name and the known ones


@check("all", "same input gives the same bits", when=has_kernels)
def same_input_gives_the_same_bits(component: Component, rng: Any) -> None:
    """A kernel keeps nothing from call to call."""
    given = sample(component, rng)
    other = sample(component, rng)
    for hook, kernel in kernels_of(component).items():
        first = flat(call(component, kernel, given))
        call(component, kernel, other)
        expect(
            flat(call(component, kernel, given)) == first, f"{type(component).__name__}.{hook} gives another result when it is called again"
        )


@check("all", "compiled equals plain Python", when=has_kernels)
def compiled_equals_plain_python(component: Component, rng: Any) -> None:
    """The compiled kernel gives the numbers of the Python function.

    Tolerance (rounding): 1e3 machine epsilons of the largest number of the result; the compiler may reorder and contract.
    """
    given = sample(component, rng)
    for hook, kernel in kernels_of(component).items():
        values = arguments(component, kernel, given)
        plain = np.array(flat(kernel.function(*values)))
        fast = np.array(flat(_linker("float64")(kernel)(*values)))
        size = float(np.max(np.abs(plain), initial=0.0))
        expect_close(fast, plain, 1e3 * np.finfo(float).eps * size, f"{type(component).__name__}.{hook}, compiled")


def declares_single(component: Component) -> bool:
    """Condition: works in single precision, and has kernels."""
    return "float32" in component.precisions and has_kernels(component)


@check("all", "single precision stays single", when=declares_single)
def single_precision_stays_single(component: Component, rng: Any) -> None:
    """No kernel turns single into double precision by accident, for example by an integer constant."""
    given = sample(component, rng)
    for hook, kernel in kernels_of(component).items():
        values = [_single(value) for value in arguments(component, kernel, given)]
        fast = _linker("float32")(kernel)
        result = fast(*values)
        expect(np.all(np.isfinite(flat(result))), f"{type(component).__name__}.{hook} is not finite in single precision: {result}")
        if hasattr(fast, "nopython_signatures"):
            made = fast.nopython_signatures[-1].return_type
            expect(
                "float64" not in str(made),
                f"{type(component).__name__}.{hook} returns {made} in single precision; write constants as floats",
            )


@cache
def _linker(precision: str) -> Any:
    """One linker for all checks, so that shared functions are compiled once."""
    from mpmkit._core.composing.jit import Linker

    return Linker(np.float64 if precision == "float64" else np.float32)


def _single(value: Any) -> Any:
    return tuple(_single(v) for v in value) if isinstance(value, tuple) else np.float32(value)
