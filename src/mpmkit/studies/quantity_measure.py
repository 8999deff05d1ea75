"""`Quantity`: the error of one number of a run."""

from __future__ import annotations

from typing import Any

import attrs

from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.studies import callables, quantities, solutions
from mpmkit.studies.measure import Measure
from mpmkit.studies.samples import Sample


def _quantity(value: Any) -> str:
    return callables.name_of(value, "Quantity") if callable(value) else str(value)


@attrs.frozen(kw_only=True)
class Quantity(Measure):
    """Error of one number of a run.

    Parameters
    ----------
    quantity : str or callable
        Of the library (`mpmkit.studies.quantities.LIBRARY`: "restitution", "final length", "energy drift", "run-out", "period" ...),
        a column of the history (its last value), or a function of `Facts`, also as "file.py:name".
    exact : float or dict, optional
        The right value; or ``{solution = {kind = "BarImpact", ...}, attribute = "restitution"}``. Quantities that ought to be zero
        need none.
    relative : bool
        Divided by the size of the right value.
    axis : int
        Direction, for those that need one.
    unit : str
        Of a function's value.
    times, bodies, name
        As for `Exact`; a function finds the instants in `Facts.samples`.
    """

    quantity: str = attrs.field(converter=_quantity)
    exact: Any = None
    relative: bool = False
    axis: int = 0
    own_unit: str = attrs.field(default="1", alias="unit")

    @quantity.validator
    def _known(self, _: Any, value: Any) -> None:
        from mpmkit._core.running.ledger import COLUMNS

        known = (*quantities.LIBRARY, *COLUMNS)
        if not callables.is_name(value) and value not in known:
            raise ParameterError(
                f"no quantity is named {value!r}{did_you_mean(str(value), known)} (known: {', '.join(quantities.LIBRARY)})"
            )

    def __attrs_post_init__(self) -> None:
        if self.exact is None and (self.quantity not in quantities.LIBRARY or quantities.LIBRARY[self.quantity].exact is None):
            raise ParameterError(f"Quantity({self.quantity!r}) needs its exact value: exact=...")
        if isinstance(self.exact, dict):
            table = dict(self.exact)
            if set(table) != {"solution", "attribute"}:
                raise ParameterError("exact must be a number or { solution = {...}, attribute = '...' }")
            object.__setattr__(self, "exact", table | {"solution": solutions.plain(table["solution"])})

    @property
    def unit(self) -> str:
        """Unit of the error."""
        named = quantities.LIBRARY.get(self.quantity)
        return "1" if self.relative else named.unit if named else self.own_unit

    def _label(self) -> str:
        name = self.quantity.rpartition(":")[2].replace("_", " ") if callables.is_name(self.quantity) else self.quantity
        if self.relative:
            return f"{name}, relative error"
        return f"{name}, error" + (f" [{self.unit}]" if self.unit != "1" else "")

    def fields(self) -> set[str]:
        return super().fields() | {"v", "m", "stress"}

    def plain(self) -> dict[str, Any]:
        table = super().plain()
        if "own_unit" in table:
            table["unit"] = table.pop("own_unit")
        return table

    def number(self, history: dict[str, Any], found: list[Sample], folder: str) -> float:
        """The quantity itself."""
        facts = quantities.Facts(history, found, self.chosen(found), self.axis)
        if self.quantity in quantities.LIBRARY:
            return float(quantities.LIBRARY[self.quantity].compute(facts))
        if self.quantity in history:
            return float(history[self.quantity][-1])
        return float(callables.load(self.quantity, folder)(facts))

    def right(self, sim: Any, choices: dict[str, Any], folder: str) -> float:
        """The value that it ought to have."""
        if self.exact is None:
            return float(quantities.LIBRARY[self.quantity].exact or 0.0)
        if not isinstance(self.exact, dict):
            return float(self.exact)
        solution, _ = solutions.build(self.exact["solution"], sim, choices, folder, self.bodies)
        name = self.exact["attribute"]
        if not hasattr(solution, name):
            raise ParameterError(f"{type(solution).__name__} has no attribute {name!r}{did_you_mean(name, dir(solution))}")
        return float(getattr(solution, name))
