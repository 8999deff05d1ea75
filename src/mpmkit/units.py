"""Strings with units to SI numbers, by pint, which is imported only when such a string appears."""

from __future__ import annotations

import re
from difflib import get_close_matches
from functools import cache
from typing import Any

from mpmkit.errors import ParameterError, did_you_mean, shown

_NUMBER = r"[-+]?(\d[\d_]*\.?\d*|\.\d+)([eE][-+]?\d+)?"
_POWER = r"((\^|\*\*)\(?-?\d\)?)?"
_TERM = rf"\(*[A-Za-z\u00b5\u03bc\u00b0%\u03a9][A-Za-z0-9_]*{_POWER}(\)+{_POWER})?"
QUANTITY = rf"\s*{_NUMBER}\s*(1?/\s*)?{_TERM}((\s*[*/]\s*|\s+){_TERM})*\s*"
"""A number and its unit. Nothing else reaches pint, which would work out "9**9**9" until the end of days."""


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


@cache
def _unit_names() -> list[str]:
    names = ["Pa", "kPa", "MPa", "GPa", "m", "mm", "cm", "km", "um", "s", "ms", "us", "min", "kg", "g", "N", "kN", "J", "W", "K", "degC"]
    return [*names, "m/s", "mm/s", "km/s", "kg/m^3", "g/cm^3", "m/s^2", "deg", "rad", "Hz", "psi", "bar", "Pa*s", "N/m", "inch", "ft"]


def is_quantity(text: str) -> bool:
    """Whether text is a number with a unit, known or not, and so no formula."""
    return re.fullmatch(QUANTITY, text) is not None


def to_si(text: str, unit: str, path: str) -> float:
    """Convert text such as "7.62 mm" to a number in `unit`.

    Raises
    ------
    ParameterError
        If the text is not a quantity, or has another dimension; names `path`, the text and a unit that would do.
    """
    if not is_quantity(text):
        form = f"a number with a unit, such as '2.5 {unit}'" if unit != "1" else "a number, without quotes"
        raise ParameterError(f"{path} must be {form}, got {shown(text)}")
    ureg = _registry()
    try:
        quantity = ureg.Quantity(text)
    except Exception as error:  # noqa: BLE001  (pint raises many kinds)
        name = getattr(error, "unit_names", text.split()[-1] if text.split() else text)
        name = name if isinstance(name, str) else ", ".join(map(str, name))
        wanted = ureg.Unit("" if unit == "1" else unit).dimensionality
        fitting = [n for n in _unit_names() if ureg.Unit(n).dimensionality == wanted]
        near = get_close_matches(name, fitting, n=1)  # with capitals, unlike names: mPa is not MPa
        hint = f"; did you mean {near[0]!r}?" if near else did_you_mean(name, fitting) or did_you_mean(name, _unit_names())
        raise ParameterError(f"{path}: cannot read {shown(text)} as a quantity in {unit}: unknown unit {shown(name)}{hint}") from None
    try:
        return float(quantity.to(ureg.Unit("" if unit == "1" else unit)).magnitude)
    except Exception:  # noqa: BLE001  (pint raises many kinds)
        raise ParameterError(f"{path}: {shown(text)} is not a quantity in {unit} (its dimension is {quantity.dimensionality})") from None
