"""Reading and writing scene files and scripts."""

from __future__ import annotations

import json
import os
import re
import tomllib
import typing
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpmkit.errors import SceneError, did_you_mean
from mpmkit.scene.mistakes import Mistakes

if TYPE_CHECKING:
    from mpmkit.simulation import Simulation

SUFFIXES = (".toml", ".json")


def load(path: str | os.PathLike[str]) -> Simulation:
    """Read a scene file.

    Parameters
    ----------
    path : path
        A ``.toml`` or ``.json`` file.

    Returns
    -------
    Simulation
        Composed as a script would; nothing has run.

    Raises
    ------
    SceneError
        If the file cannot be read or has mistakes: all are listed with path, value, allowed range and nearest name.
    """
    path = Path(path)
    suffix = _suffix(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        names = [p.name for p in path.parent.glob("*") if p.suffix in SUFFIXES] if path.parent.is_dir() else []
        raise SceneError(f"there is no scene file {str(path)!r}{did_you_mean(path.name, names)}") from None
    except IsADirectoryError:
        raise SceneError(f"{path} is a folder; give a scene file (.toml or .json)") from None
    except UnicodeDecodeError as error:
        raise SceneError(f"{path} is not a text file in UTF-8 (byte {error.start})") from None
    except OSError as error:
        raise SceneError(f"cannot read the scene file {path}: {error.strerror}") from None
    return loads(text, format=suffix[1:], source=str(path))


def loads(text: str, *, format: str = "toml", source: str = "the scene") -> Simulation:
    """Read a scene from text; see `load`.

    Parameters
    ----------
    text : str
        The text.
    format : str
        "toml" or "json".
    source : str
        What messages call it.
    """
    if format not in ("toml", "json"):
        raise SceneError(f"format must be 'toml' or 'json', got {format!r}")
    data = (_parse_toml if format == "toml" else _parse_json)(text, source)
    from mpmkit.scene.reading import Reader

    mistakes = Mistakes(source)
    try:
        simulation = Reader(mistakes).simulation(data)
    except RecursionError:
        raise SceneError(f"{source} is nested too deep") from None
    mistakes.raise_if_any()
    return typing.cast("Simulation", simulation)


def dumps(simulation: Simulation, *, format: str = "toml") -> str:
    """The text of a scene file: defaults left out, numbers in SI.

    Raises
    ------
    SceneError
        If the simulation holds what no file can: Python functions, or classes that no plugin registers.
    """
    if format not in ("toml", "json"):
        raise SceneError(f"format must be 'toml' or 'json', got {format!r}")
    from mpmkit.scene.toml_text import toml
    from mpmkit.scene.writing import Writer

    mistakes = Mistakes("the simulation cannot be written to a scene file")
    data = Writer(mistakes).simulation(simulation)
    mistakes.raise_if_any()
    return toml(data) if format == "toml" else json.dumps(data, indent=2, ensure_ascii=False) + "\n"


def save(simulation: Simulation, path: str | os.PathLike[str]) -> None:
    """Write a scene file, ``.toml`` or ``.json``; see `dumps`."""
    path = Path(path)
    text = dumps(simulation, format=_suffix(path)[1:])
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SceneError(f"cannot write the scene file {path}: {error.strerror}") from None


def to_script(simulation: Simulation) -> str:
    """A Python script that composes the same simulation; raises `SceneError` as `dumps` does."""
    from mpmkit.scene.script import Script

    mistakes = Mistakes("the simulation cannot be written to a script")
    text = Script(mistakes).text(simulation)
    mistakes.raise_if_any()
    return text


def _suffix(path: Path) -> str:
    if path.suffix not in SUFFIXES:
        raise SceneError(
            f"a scene file ends in .toml or .json, got {str(path)!r}{did_you_mean(path.suffix, SUFFIXES) if path.suffix else ''}"
        )
    return path.suffix


def _parse_toml(text: str, source: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{source} is not valid TOML: {error}{_line_of(text, str(error))}") from None
    except RecursionError:
        raise SceneError(f"{source} is nested too deep") from None
    except ValueError as error:  # of Python's own reading of a number or a date
        raise SceneError(f"{source} is not valid TOML: {error}") from None


def _parse_json(text: str, source: str) -> dict[str, Any]:
    try:
        data = json.loads(text, object_pairs_hook=_without_duplicates)
    except json.JSONDecodeError as error:
        where = f"{error.msg} (at line {error.lineno}, column {error.colno})"
        raise SceneError(f"{source} is not valid JSON: {where}{_line_of(text, where)}") from None
    except RecursionError:
        raise SceneError(f"{source} is nested too deep") from None
    except ValueError as error:
        raise SceneError(f"{source} is not valid JSON: {error}") from None
    if not isinstance(data, dict):
        raise SceneError(f"{source} must hold a JSON object, got {type(data).__name__}")
    return data


def _without_duplicates(pairs: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Python's json keeps the last of two equal keys and says nothing."""
    data: dict[str, Any] = {}
    for key, value in pairs:
        if key in data:
            raise ValueError(f"the key {key!r} appears twice in one object")
        data[key] = value
    return data


def _line_of(text: str, message: str) -> str:
    """The line that a parser complains about, with a mark under the column."""
    found = re.search(r"line (\d+), column (\d+)", message)
    lines = text.splitlines()
    if not found or int(found[1]) > len(lines):
        return ""
    line, column = lines[int(found[1]) - 1], int(found[2])
    start = max(0, column - 60)
    return f"\n  {line[start : start + 100]}\n  {' ' * (column - 1 - start)}^"
