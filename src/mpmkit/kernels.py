"""The marker that turns a plain scalar function into a component's kernel."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from mpmkit.errors import PluginError


class Kernel:
    """A pure function of one point, whose argument names say what it needs.

    Nothing is compiled here: the scheduler does that when a simulation is composed. Calling the
    marker calls the plain Python function, which is how tests and single-point drivers use it.

    Parameters
    ----------
    function : callable
        Takes floats and tuples by name, returns floats and tuples; no loop over particles.

    Raises
    ------
    PluginError
        If the function has default values, ``*args`` or ``**kwargs``: each argument is filled by its name.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        self.__doc__ = function.__doc__
        parameters = inspect.signature(function).parameters.values()
        for parameter in parameters:
            if parameter.kind is not parameter.POSITIONAL_OR_KEYWORD or parameter.default is not parameter.empty:
                raise PluginError(
                    f"kernel {function.__module__}.{function.__qualname__}: argument {parameter.name!r} must be a plain "
                    "name without a default; the scheduler fills every argument by its name"
                )
        self.arguments: tuple[str, ...] = tuple(p.name for p in parameters)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self.function(*args, **kwargs)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Kernel, (self.function,))

    def __repr__(self) -> str:
        return f"kernel {self.function.__module__}.{self.function.__qualname__}({', '.join(self.arguments)})"


def kernel(function: Callable[..., Any]) -> Kernel:
    """Mark `function` as a component's kernel (see `Kernel`)."""
    return Kernel(function)
