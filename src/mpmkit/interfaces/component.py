"""What every kind of component has in common."""

from __future__ import annotations

from typing import Any, ClassVar

import attrs

from mpmkit.fields import Field
from mpmkit.kernels import Kernel
from mpmkit.parameters import Value, specs

SPACES = ("1D", "plane strain", "axisymmetric", "3D")
"""The spaces a simulation can live in (`Grid.space`)."""


_VALUE: Any = Value


class Component:
    """Base of all components: a frozen attrs class made by `mpmkit.define`, with declared facts and small kernels.

    Kernels are class attributes made by `mpmkit.kernel`; their argument names are looked up among the component's
    parameters and properties, its state, the standard fields (`mpmkit.fields`) and ``t``, ``dt``, ``h``.

    Attributes
    ----------
    kind : str
        The interface this component implements; set by the interface class.
    state : tuple of Field
        Per-particle fields this component adds, stored only for bodies that use it.
    spaces : tuple of str
        Where it works: a subset of ``SPACES``.
    precisions : tuple of str
        Of ("float64", "float32").
    references : tuple of str
        Papers, with equation numbers.
    expected_failures : dict
        Conformance checks that this component is known to fail -> the reason; a check that starts to pass is an error.
    """

    kind: ClassVar[str] = ""
    names_reach_kernels: ClassVar[bool] = True
    state: ClassVar[tuple[Field, ...]] = ()
    spaces: ClassVar[tuple[str, ...]] = SPACES
    precisions: ClassVar[tuple[str, ...]] = ("float64", "float32")
    references: ClassVar[tuple[str, ...]] = ()
    expected_failures: ClassVar[dict[str, str]] = {}

    def __attrs_post_init__(self) -> None:
        self.check()

    def check(self) -> None:
        """Check parameters against each other; raise `ParameterError` with the remedy."""

    @classmethod
    def summary(cls) -> str:
        """First line of the docstring."""
        return (cls.__doc__ or "").strip().split("\n")[0]

    @classmethod
    def kernels(cls) -> dict[str, Kernel]:
        """The kernels this class supplies: hook name -> kernel."""
        names = [n for c in reversed(cls.__mro__) for n, v in vars(c).items() if isinstance(v, Kernel)]
        return {n: getattr(cls, n) for n in dict.fromkeys(names) if isinstance(getattr(cls, n), Kernel)}

    @classmethod
    def capabilities(cls) -> dict[str, Any]:
        """Declared facts as plain data, for `list-plugins` and `describe`."""
        return {"spaces": list(cls.spaces), "precisions": list(cls.precisions), "state": [f.name for f in cls.state]}

    @property
    def values(self) -> tuple[str, ...]:
        """Names of the parameters of type `Value` (constant, formula or function)."""
        return tuple(n for n, (f, _) in specs(type(self)).items() if f.type == _VALUE)

    def parameters(self) -> dict[str, Any]:
        """Parameter values by name."""
        return {n: getattr(self, n) for n in specs(type(self))}

    def __str__(self) -> str:
        shown = []
        for name, (attribute, _) in specs(type(self)).items():
            value = getattr(self, name)
            if attribute.default is attrs.NOTHING or value != attribute.default:
                shown.append(f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}")
        return f"{type(self).__name__}({', '.join(shown)})"
