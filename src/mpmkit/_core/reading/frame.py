"""One moment of a run, and the sequence of all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from html import escape
from typing import Any, overload

import numpy as np

from mpmkit.errors import ResultsError, did_you_mean


class Frame(Mapping[str, np.ndarray]):
    """The particles at one moment; arrays are read when they are asked for.

    Attributes
    ----------
    time : float
        Simulated time [s].
    step : int
        Number of the step.
    index : int
        Place among the frames of the run, from 0.
    fields : tuple of str
        Names of the arrays; ``frame["x"]`` has one column per space dimension.
    """

    def __init__(
        self,
        time: float,
        step: int,
        index: int,
        fields: Sequence[str],
        read: Callable[[str], np.ndarray],
        bodies: Sequence[str],
        where: str,
    ) -> None:
        self.time, self.step, self.index, self.fields = float(time), int(step), int(index), tuple(fields)
        self._read, self._bodies, self._where = read, tuple(bodies), where
        self._cache: dict[str, np.ndarray] = {}

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.fields:
            known = ", ".join(self.fields)
            raise ResultsError(
                f"{self._where} holds no field {name!r}{did_you_mean(str(name), self.fields)} "
                f"(it holds {known}; name what to keep in Record(fields=...))"
            )
        if name not in self._cache:
            self._cache[name] = self._read(name)
        return self._cache[name]

    def __contains__(self, name: object) -> bool:
        return name in self.fields

    def __iter__(self) -> Iterator[str]:
        return iter(self.fields)

    def __len__(self) -> int:
        return len(self.fields)

    @property
    def n_particles(self) -> int:
        """Number of particles."""
        return len(self["x"])

    def body(self, name: str) -> Frame:
        """The same moment, limited to one body.

        Raises
        ------
        ResultsError
            If no body is called that.
        """
        if name not in self._bodies:
            raise ResultsError(
                f"{self._where} has no body {name!r}{did_you_mean(str(name), self._bodies)} (bodies: {', '.join(self._bodies) or 'none'})"
            )
        if len(self._bodies) == 1 and "body" not in self.fields:
            return self
        inside = self["body"] == self._bodies.index(name)
        return Frame(
            self.time, self.step, self.index, self.fields, lambda field: self[field][inside], (name,), f"{self._where}, body {name!r},"
        )

    def __repr__(self) -> str:
        return f"<Frame {self.index}: t = {self.time:g} s, step {self.step}, {self.n_particles} particles, {', '.join(self.fields)}>"

    def _repr_html_(self) -> str:
        rows = ""
        for name in self.fields:
            array = self[name]
            span = f"{array.min():.4g} to {array.max():.4g}" if array.size else ""
            rows += f"<tr><td><code>{escape(name)}</code></td><td>{array.shape}</td><td>{span}</td></tr>"
        return f"<b>t = {self.time:g} s</b>, step {self.step}<table><tr><th>field</th><th>shape</th><th>range</th></tr>{rows}</table>"


class Frames(Sequence[Frame]):
    """All frames of a run: ``frames[0]``, ``frames[-1]``, ``for frame in frames``."""

    def __init__(self, count: int, make: Callable[[int], Frame]) -> None:
        self._count, self._make = count, make

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | list[Frame]:
        if isinstance(index, slice):
            return [self._make(k) for k in range(*index.indices(self._count))]
        if not -self._count <= index < self._count:
            raise IndexError(f"frame {index} of a run with {self._count} frames")
        return self._make(int(index) % self._count)

    def __repr__(self) -> str:
        return f"<{self._count} frames>"


class History(dict[str, np.ndarray]):
    """The history of a run by column: ``history["kinetic"]`` or ``history.kinetic``."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except ResultsError as error:
            raise AttributeError(str(error)) from None

    def __missing__(self, name: str) -> np.ndarray:
        raise ResultsError(f"the history has no column {name!r}{did_you_mean(name, self)} (it has {', '.join(self)})")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]
