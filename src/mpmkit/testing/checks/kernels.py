"""Checks of kernels of all kinds: arguments, results, and that the compiled ones are the plain ones."""

from __future__ import annotations

import dis
import types
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from mpmkit.interfaces import Component, ConstitutiveModel
from mpmkit.testing.calling import arguments, call, flat, kernels_of
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.points import sample

WRITES = {"STORE_GLOBAL", "DELETE_GLOBAL", "STORE_ATTR", "DELETE_ATTR", "STORE_SUBSCR", "DELETE_SUBSCR", "STORE_SLICE"}
"""Instructions that change something outside a function."""
SIZES = {
    "contact": {"impulse": 3},
    "boundary": {"constrain": 3, "hold": 3, "rub": 3, "load": 6},
    "transfer": {"velocity": 1},
    "material": dict.fromkeys(("wave_speed", "energy", "dissipation", "diffusivity", "yield_function"), 1)
    | dict.fromkeys(("bar_wave_speed", "bar_energy", "bar_dissipation"), 1),
}
"""How many numbers the kernel of a hook returns; shape functions, stresses and effects have checks of their own."""


def has_kernels(component: Component) -> bool:
    """Condition of the checks on kernels."""
    return bool(kernels_of(component))


@check("all", "kernel arguments resolve", when=has_kernels)
def kernel_arguments_resolve(component: Component, rng: Any) -> None:
    """Every argument is a parameter or property of the component, its state, or a field that its kind may ask for."""
    given = sample(component, rng)
    for kernel in kernels_of(component).values():
        arguments(component, kernel, given)  # raises with the name and the known ones


@check("all", "kernels write nothing", when=has_kernels)
def kernels_write_nothing(component: Component, rng: Any) -> None:
    """No instruction of a kernel, or of a function it calls, stores anywhere but in its own variables; the result is all it gives."""
    for hook, kernel in kernels_of(component).items():
        for code in _codes(kernel.function):
            for one in dis.get_instructions(code):
                outside = one.opname in WRITES or (one.opname in ("STORE_DEREF", "DELETE_DEREF") and one.argval in code.co_freevars)
                where = f"{type(component).__name__}.{hook}, {code.co_name}, line {code.co_firstlineno} ff"
                expect(not outside, f"{where}: writes {one.argval if one.argval is not None else 'into an object'} ({one.opname})")


def _codes(function: Any) -> Iterator[types.CodeType]:
    """The code of a function, of those inside it, and of those it refers to."""
    from mpmkit._core.composing.jit import names_of, plain

    waiting, seen = [function], set()
    while waiting:
        found = plain(waiting.pop())
        if not isinstance(found, types.FunctionType) or found in seen:
            continue
        seen.add(found)
        inside = [found.__code__]
        while inside:
            code = inside.pop()
            yield code
            inside += [c for c in code.co_consts if isinstance(c, types.CodeType)]
        waiting += [found.__globals__[name] for name in names_of(found.__code__) if name in found.__globals__]
        waiting += [cell.cell_contents for cell in found.__closure__ or ()]


@check("all", "results have the form of the hook", when=lambda component: component.kind in SIZES)
def results_have_the_form_of_the_hook(component: Component, rng: Any) -> None:
    """As many finite numbers as the core stores: three for a vector, one for a speed or an energy."""
    given = sample(component, rng)
    for hook, kernel in kernels_of(component).items():
        wanted = SIZES[component.kind].get(hook)
        if wanted is not None:
            result = flat(call(component, kernel, given))
            expect(len(result) == wanted, f"{type(component).__name__}.{hook} returns {len(result)} numbers, wanted {wanted}: {result}")
            expect(np.all(np.isfinite(result)), f"{type(component).__name__}.{hook} is not finite: {result}")


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

    Tolerance (rounding): 1e3 machine epsilons of the largest number of the result; the compiler may reorder and contract. Of the modulus
    for stresses and energies of a constitutive model, which may be small differences of large terms.
    """
    given = sample(component, rng)
    for hook, kernel in kernels_of(component).items():
        values = arguments(component, kernel, given)
        plain = np.array(flat(kernel.function(*values)))
        fast = np.array(flat(_linker("float64")(kernel)(*values)))
        size = max(float(np.max(np.abs(plain), initial=0.0)), _stiffness(component, hook))
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


@check("all", "single precision is close to double", when=declares_single)
def single_precision_is_close_to_double(component: Component, rng: Any) -> None:
    """In single precision a kernel has the result of double precision, for arguments that both can hold.

    Tolerance (rounding): 200 machine epsilons of the largest number of the result; of the modulus for what a constitutive model computes
    from the deformation, where differences of larger terms are natural.
    """
    given = sample(component, rng)
    for hook, kernel in kernels_of(component).items():
        values = [_single(value) for value in arguments(component, kernel, given)]
        double = np.array(flat(kernel.function(*[_double(value) for value in values])))
        single = np.array(flat(_linker("float32")(kernel)(*values)))
        size = max(float(np.max(np.abs(double), initial=0.0)), _stiffness(component, hook))
        expect_close(single, double, 200.0 * float(np.finfo(np.float32).eps) * size, f"{type(component).__name__}.{hook}, single precision")


def _stiffness(component: Any, hook: str) -> float:
    """The modulus, for hooks of a constitutive model that are stresses or energies; else 0."""
    from mpmkit.testing.scenes import wave_speed

    if not isinstance(component, ConstitutiveModel) or hook.endswith(("wave_speed", "diffusivity")):
        return 0.0
    return component.rho * wave_speed(component) ** 2


@cache
def _linker(precision: str) -> Any:
    """One linker for all checks, so that shared functions are compiled once."""
    from mpmkit._core.composing.jit import Linker

    return Linker(np.float64 if precision == "float64" else np.float32)


def _single(value: Any) -> Any:
    return tuple(_single(v) for v in value) if isinstance(value, tuple) else np.float32(value)


def _double(value: Any) -> Any:
    return tuple(_double(v) for v in value) if isinstance(value, tuple) else float(value)
