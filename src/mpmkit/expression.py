"""Formulas in text, such as "10*sin(2*pi*t)": read by a parser with a short list of what is allowed, never evaluated as code."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterable
from typing import Any, Self

import numpy as np

from mpmkit._core.formula import Formula, parse
from mpmkit.errors import ParameterError

ARGUMENT_OF: dict[str, str] = {
    **{name: f"x[{k}]" for k, name in enumerate("xyz")},
    **{name: f"X[{k}]" for k, name in enumerate("XYZ")},
    **{f"v{name}": f"v[{k}]" for k, name in enumerate("xyz")},
    "t": "t",
}
"""What each name of a formula is in a kernel: positions now (x, y, z) and at the start (X, Y, Z), velocity (vx, vy, vz), time (t)."""
ARGUMENTS = ("x", "X", "v", "t")
"""Order of the arguments of a formula's function."""


def position_names(dim: int) -> tuple[str, ...]:
    """Names of the coordinates in a space of `dim` dimensions."""
    return tuple("xyz"[:dim]) + tuple("XYZ"[:dim])


def all_names(dim: int = 3) -> tuple[str, ...]:
    """All names a formula may use in a space of `dim` dimensions."""
    return (*position_names(dim), *(f"v{c}" for c in "xyz"[:dim]), "t")


class Expression(str):
    """A formula of position, velocity and time: text that has been checked.

    Allowed are numbers, + - * / ** and parentheses, comparisons, and, or, not, ``a if t < 1 else b``, min, max, abs, sqrt, exp,
    log, sin, cos, tan, tanh, pi, and the given names.

    Parameters
    ----------
    text : str
        The formula, at most 1000 characters.
    names : iterable of str, optional
        The names it may use; a subset of `ARGUMENT_OF`, by default all.
    path : str
        Where the formula stands, for messages.

    Raises
    ------
    ParameterError
        With the position of the first thing that is not allowed, and the nearest known name.
    """

    _formula: Formula

    def __new__(cls, text: str, names: Iterable[str] | None = None, path: str = "formula") -> Self:
        formula = parse(text, tuple(ARGUMENT_OF if names is None else names), path)
        self = super().__new__(cls, text)
        self._formula = formula
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The names the formula uses, sorted."""
        return self._formula.names

    @property
    def arguments(self) -> tuple[str, ...]:
        """The arguments its function needs, of ("x", "X", "v", "t") in this order."""
        return arguments_of(self.names)

    def evaluate(self, **values: Any) -> Any:
        """Evaluate for many points at once.

        Parameters
        ----------
        x, X, v : float[..., dim]
            Positions, initial positions, velocities; those the formula uses.
        t : float
            Time.

        Returns
        -------
        float64[...]
            Not finite where the formula has no value.
        """
        missing = [a for a in self.arguments if a not in values]
        if missing:
            raise ParameterError(f"the formula {str(self)!r} needs {', '.join(missing)}")
        named = {n: values[n] if n == "t" else np.asarray(values[_argument(n)])[..., _component(n)] for n in self.names}
        with np.errstate(all="ignore"):  # a branch that is not taken may have no value; the caller checks the result
            return self._formula.evaluate(named)

    def code(self) -> str:
        """The formula as scalar Python, with x[0] for x and so on."""
        return self._formula.code(ARGUMENT_OF)

    def source(self, name: str | None = None) -> str:
        """Text of a plain Python function of `arguments` that returns the value as one float."""
        return _source(self.code(), self.arguments, name)

    def function(self) -> Callable[..., Any]:
        """A plain scalar Python function of `arguments`; its text is its attribute ``source``."""
        return make_function(self.code(), self.arguments)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Expression, (str(self),))

    def __repr__(self) -> str:
        return f"Expression({str(self)!r})"


def arguments_of(names: Iterable[str]) -> tuple[str, ...]:
    """Kernel arguments behind names of formulas, in the order of `ARGUMENTS`."""
    used = {_argument(n) for n in names}
    return tuple(a for a in ARGUMENTS if a in used)


def as_function(value: Any, dim: int, path: str = "value") -> Any:
    """See `mpmkit.values.as_function`."""
    from mpmkit.values import as_function as made

    return made(value, dim, path)


def _argument(name: str) -> str:
    return ARGUMENT_OF[name].partition("[")[0]


def _component(name: str) -> int:
    return int(ARGUMENT_OF[name][-2])


def make_function(code: str, arguments: tuple[str, ...]) -> Callable[..., Any]:
    """A scalar Python function that returns `code`, which must come from `Expression.code` or be put together from such parts."""
    text = _source(code, arguments, None)
    name = text[len("def ") : text.index("(")]
    # compiled code that is cached names the module of its functions, and loading it again imports that module: a real one
    space: dict[str, Any] = {"__builtins__": {}, "__name__": __name__, "min": min, "max": max, "abs": abs, "pi": math.pi}
    space |= {n: getattr(math, n) for n in ("sqrt", "exp", "log", "sin", "cos", "tan", "tanh", "pow")}
    exec(compile(text, f"<{name}>", "exec"), space)
    function: Callable[..., Any] = space[name]
    function.source = text  # type: ignore[attr-defined]
    return function


def _source(code: str, arguments: tuple[str, ...], name: str | None) -> str:
    digest = hashlib.sha256(f"{arguments}{code}".encode()).hexdigest()[:10]
    return f"def {name or f'formula_{digest}'}({', '.join(arguments)}):\n    return {code}\n"
