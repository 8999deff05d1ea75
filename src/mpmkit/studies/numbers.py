"""Numbers in the words of sentences, tables and pictures."""

from __future__ import annotations

from mpmkit._core.drawing.style import scaled_unit


def number(value: float | None, digits: int = 2) -> str:
    """A number with few digits: "0.0025", "1e-05", "340"."""
    if value is None:
        return ""
    if value and not 1e-4 <= abs(value) < 1e5:
        mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
        return f"{mantissa.rstrip('0').rstrip('.') if '.' in mantissa else mantissa}e{int(power)}"
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:.0f}" if abs(rounded) >= 10 ** (digits - 1) and rounded == int(rounded) else f"{rounded:.{digits}g}"


def quantity(value: float, unit: str, digits: int = 2) -> str:
    """A number with its unit and a prefix: "6 ms", "0.25 Pa"; errors without a unit as they are."""
    if unit in ("", "1"):
        return number(value, digits)
    factor, prefixed = scaled_unit(abs(value), unit)
    return f"{number(value * factor, digits)} {prefixed}"


def plain(value: float, unit: str, digits: int = 2) -> str:
    """A number with its unit and no prefix, so that several can be compared."""
    return number(value, digits) if unit in ("", "1") else f"{number(value, digits)} {unit}"


def seconds(value: float) -> str:
    """A time as people say it: "6 ms", "41 s", "3.5 min", "2.1 h"."""
    if value < 120.0:
        return quantity(value, "s")
    return f"{number(value / 60.0)} min" if value < 7200.0 else f"{number(value / 3600.0)} h"


def exponent(value: float) -> str:
    """An order with two decimals; ends of an interval far away only say that nothing is known."""
    if abs(value) >= 100.0:
        return "-∞" if value < 0.0 else "∞"
    return f"{value:.2f}" if abs(value) < 10.0 else f"{value:.0f}"


def times(factor: float) -> str:
    """A factor: "3.1 times", "240 times"."""
    return f"{number(factor)} times"


def joined(items: list[str]) -> str:
    """As in "a", "a and b", "a, b and c"; items with commas are set apart by semicolons."""
    between = "; " if any(", " in item for item in items) else ", "
    return items[0] if len(items) == 1 else f"{between.join(items[:-1])} and {items[-1]}"
