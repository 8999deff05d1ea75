"""The table of checks, filled by a decorator in the modules of this package."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

CheckFunction = Callable[[Any, Any], None]
Condition = Callable[[Any], bool]


@attrs.frozen
class Declared:
    """One check of the suite: for which kind, under which name, and for which components it makes sense."""

    kind: str
    name: str
    function: CheckFunction
    applies: Condition
    once: bool

    @property
    def doc(self) -> str:
        """What is checked, and how exactly."""
        return inspect.getdoc(self.function) or ""


CHECKS: list[Declared] = []


def check(
    kind: str, name: str, *, when: Condition = lambda component: True, once: bool = False
) -> Callable[[CheckFunction], CheckFunction]:
    """Add a function ``(component, rng)`` that raises `AssertionError` to the suite.

    Parameters
    ----------
    kind : str
        Kind of component, or "all".
    name : str
        What the check is called in reports and in ``expected_failures``.
    when : callable, optional
        True for components that the check applies to.
    once : bool
        Run for the examples only, not for every choice of the parameters.
    """

    def add(function: CheckFunction) -> CheckFunction:
        if any(other.name == name and (other.kind == kind or "all" in (kind, other.kind)) for other in CHECKS):
            raise ValueError(f"two checks of {kind} are named {name!r}")
        CHECKS.append(Declared(kind, name, function, when, once))
        return function

    return add


def expect(condition: Any, message: str) -> None:
    """Raise `AssertionError` with a message that says what was found."""
    if not condition:
        raise AssertionError(message)


def expect_close(found: Any, wanted: Any, tolerance: float, what: str) -> None:
    """Compare numbers with an absolute tolerance; NaN never passes."""
    error = float(np.max(np.abs(np.asarray(found, dtype=float) - np.asarray(wanted, dtype=float)), initial=0.0))
    expect(error <= tolerance, f"{what}: found {_short(found)}, wanted {_short(wanted)}, difference {error:.3g} > {tolerance:.3g}")


def _short(value: Any) -> str:
    return np.array2string(np.asarray(value, dtype=float), precision=6, threshold=12)
