"""The text of a TOML scene file, laid out for people: one key a line with its unit, small tables inline."""

from __future__ import annotations

from typing import Any

import tomli_w

from mpmkit.scene.parts import MATERIALS

WIDTH = 100
"""Longer inline tables become tables of their own, longer arrays one item a line."""


def toml(data: dict[str, Any]) -> str:
    """Text of a scene."""
    blocks = [
        "\n".join(_lines({k: v for k, v in data.items() if not isinstance(v, dict) and not _is_tables(v)}, getattr(data, "units", {})))
    ]
    for key, value in data.items():
        if key == MATERIALS:
            blocks += [_block(f"[{key}.{_key(name)}]", table, f"{key}.{_key(name)}") for name, table in value.items()]
        elif isinstance(value, dict):
            blocks.append(_block(f"[{key}]", value, key))
        elif _is_tables(value):
            blocks += [_block(f"[[{key}]]", table, key) for table in value]
    return "\n\n".join(block for block in blocks if block) + "\n"


def _block(head: str, table: dict[str, Any], path: str) -> str:
    """A table under its head; what is too long to stay inline follows under a head of its own."""
    apart = {k: v for k, v in table.items() if isinstance(v, dict) and len(_value(v)) > WIDTH}
    lines = [head, *_lines({k: v for k, v in table.items() if k not in apart}, getattr(table, "units", {}))]
    return "\n".join(lines + ["\n" + _block(f"[{path}.{_key(k)}]", v, f"{path}.{_key(k)}") for k, v in apart.items()])


def _lines(table: dict[str, Any], units: dict[str, str]) -> list[str]:
    return [f"{_key(k)} = {_value(v)}" + (f"  # {units[k]}" if units.get(k, "1") != "1" else "") for k, v in table.items()]


def _value(value: Any, indent: str = "") -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v, indent)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        inner = indent + "    "
        short = "[" + ", ".join(_value(item, inner) for item in value) + "]"
        if len(short) <= WIDTH and "\n" not in short:
            return short
        return "[\n" + "".join(f"{inner}{_value(item, inner)},\n" for item in value) + indent + "]"
    return tomli_w.dumps({"k": value})[4:-1]


def _key(key: str) -> str:
    """A key, in quotes if it needs them."""
    return tomli_w.dumps({key: 0})[:-5]


def _is_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)
