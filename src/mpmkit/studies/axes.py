"""Axes of a study: what is varied, the values, and their short names."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping
from typing import Any

import attrs

from mpmkit.errors import ParameterError
from mpmkit.studies.paths import table_of

LABELS = "labels"
"""Key of a linked axis with names for its values."""


@attrs.frozen
class Axis:
    """Fields that vary together.

    Parameters
    ----------
    name : str
        The path, or the name of the table that links several.
    paths : tuple of str
        Paths into the scene, or arguments of its function.
    values : tuple of tuple
        For each value of the axis what is put at each path.
    labels : tuple of str
        A short name for each value.
    """

    name: str
    paths: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]
    labels: tuple[str, ...]

    @property
    def numbers(self) -> tuple[float, ...] | None:
        """The values of its first path, if all are numbers."""
        first = [v[0] for v in self.values]
        return tuple(map(float, first)) if all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in first) else None


def read(axes: Mapping[str, Any]) -> list[Axis]:
    """Axes from a table: each a list of values at a path, or a table of lists of equal length that vary together.

    Raises
    ------
    ParameterError
        If a value is no list, a list is empty, lists that vary together differ in length, or a path is given twice.
    """
    found = [_linked(str(name), given) if isinstance(given, Mapping) else _single(str(name), given) for name, given in axes.items()]
    paths = [path for axis in found for path in axis.paths]
    twice = sorted({path for path in paths if paths.count(path) > 1})
    if twice:
        raise ParameterError(f"axes: {twice[0]!r} is varied by two axes; let it vary in one of them")
    return found


def _single(name: str, given: Any) -> Axis:
    values = _list(name, given)
    return Axis(name, (name,), tuple((v,) for v in values), _labels(name, values))


def _linked(name: str, given: Mapping[str, Any]) -> Axis:
    named = given.get(LABELS)
    lists = {path: _list(f"{name}.{path}", values) for path, values in given.items() if path != LABELS}
    lengths = {path: len(values) for path, values in lists.items()}
    if not lists or len(set(lengths.values())) > 1 or (named is not None and len(named) not in lengths.values()):
        told = ", ".join(f"{path}: {n}" for path, n in lengths.items())
        raise ParameterError(
            f"axis {name!r}: lists that vary together, and their labels, must have equal lengths, got {told or 'no lists'}"
        )
    values = tuple(zip(*lists.values(), strict=True))
    labels = tuple(map(str, named)) if named is not None else _labels(next(iter(lists)), [v[0] for v in values])
    if len(set(labels)) < len(labels):
        labels = tuple(", ".join(short(v) for v in value) for value in values)
    return Axis(name, tuple(lists), values, labels)


def _list(name: str, given: Any) -> list[Any]:
    if not isinstance(given, (list, tuple)):
        raise ParameterError(f"axis {name!r} must be a list of values, or a table of lists that vary together, got {given!r}")
    if not given:
        raise ParameterError(f"axis {name!r} is empty, so there is nothing to run; give it at least one value, or leave it out")
    return [table_of(value) for value in given]


def _labels(name: str, values: list[Any]) -> tuple[str, ...]:
    """Kinds alone where these tell the values apart, else with parameters; numbers with the last step of the path."""
    plain = [short(v, kind_only=True) for v in values]
    texts = plain if len(set(plain)) == len(plain) else [short(v) for v in values]
    twice = sorted({t for t in texts if texts.count(t) > 1})
    if twice:
        raise ParameterError(f"axis {name!r} has the value {twice[0]} twice")
    return tuple(texts)


def short(value: Any, kind_only: bool = False) -> str:
    """A value in a few letters."""
    if isinstance(value, dict):
        rest = {k: v for k, v in value.items() if k != "kind"}
        kind = str(value.get("kind", ""))
        return kind if (kind_only and kind) or not rest else f"{kind}({', '.join(f'{k}={short(v)}' for k, v in rest.items())})"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(short(v, kind_only) for v in value) + "]" if value else "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else str(value)


def tell(axis: Axis, k: int) -> str:
    """Value k with what it is a value of, for the label of a run: "GIMP", "cfl=0.2"."""
    value, label = axis.values[k][0], axis.labels[k]
    last = axis.name.rsplit(".", 1)[-1]
    return label if isinstance(value, (dict, str)) and label not in ("none", "yes", "no") else f"{last}={label}"


def product(axes: list[Axis]) -> Iterator[tuple[int, ...]]:
    """Number of the value on each axis, for every combination; the last axis varies fastest."""
    return itertools.product(*(range(len(axis.values)) for axis in axes))
