"""Strings with units to SI numbers, by pint, which is imported only when such a string appears."""

from __future__ import annotations

from functools import cache
from typing import Any

from mpmkit.errors import ParameterError, did_you_mean


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


@cache
def _unit_names() -> list[str]:
    names = ["Pa", "kPa", "MPa", "GPa", "m", "mm", "cm", "km", "um", "s", "ms", "us", "min", "kg", "g", "N", "kN", "J", "W", "K", "degC"]
    return names + ["m/s", "mm/s", "km/s", "kg/m^3", "g/cm^3", "m/s^2", "deg", "rad", "Hz", "psi", "bar", "Pa*s", "N/m", "inch", "ft"]


def to_si(text: str, unit: str, path: str) -> float:
    """Convert text such as "7.62 mm" to a number in `unit`.

    Raises
    ------
    ParameterError
        If the text is not a quantity, or has another dimension; names `path`, the text and a unit that would do.
    """
    ureg = _registry()
    try:
        quantity = ureg.Quantity(text)
    except Exception as error:
        name = getattr(error, "unit_names", text.split()[-1] if text.split() else text)
        name = name if isinstance(name, str) else ", ".join(map(str, name))
        hint = did_you_mean(name, _unit_names())
        raise ParameterError(f"{path}: cannot read {text!r} as a quantity in {unit}: unknown unit or number{hint}") from None
    try:
        return float(quantity.to(ureg.Unit("" if unit == "1" else unit)).magnitude)
    except Exception:
        raise ParameterError(f"{path}: {text!r} is not a quantity in {unit} (its dimension is {quantity.dimensionality})") from None
