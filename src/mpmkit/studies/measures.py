"""Measures of error by name, and from tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs

from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.studies.field_measures import Exact, Finest
from mpmkit.studies.measure import Measure
from mpmkit.studies.quantity_measure import Quantity

__all__ = ["KINDS", "Exact", "Finest", "Measure", "Quantity", "read"]

KINDS: dict[str, Any] = {"Exact": Exact, "Finest": Finest, "Quantity": Quantity}


def read(table: Any) -> Measure:
    """A measure from a table with its kind, or as it is.

    Raises
    ------
    ParameterError
        If the kind or a key is unknown, or the measure cannot be.
    """
    if isinstance(table, Measure):
        return table
    if not isinstance(table, Mapping) or "kind" not in table:
        raise ParameterError(
            f'an error measure is a table such as {{ kind = "Exact", solution = {{...}}, field = "stress.xx" }}, got {table!r}'
        )
    kind, rest = table["kind"], {k: v for k, v in table.items() if k != "kind"}
    if kind not in KINDS:
        raise ParameterError(f"no error measure is named {kind!r}{did_you_mean(str(kind), KINDS)} (known: {', '.join(KINDS)})")
    arguments = {a.alias: a for a in attrs.fields(KINDS[kind])}
    for key in rest:
        if key not in arguments:
            raise ParameterError(f"{kind} has no parameter {key!r}{did_you_mean(key, arguments)} (it has {', '.join(arguments)})")
    missing = [name for name, a in arguments.items() if a.default is attrs.NOTHING and name not in rest]
    if missing:
        raise ParameterError(f"{kind} needs {' and '.join(missing)}")
    made: Measure = KINDS[kind](**rest)
    return made
