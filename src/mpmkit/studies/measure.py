"""`Measure`: what all measures of error have in common: when a run is looked at, and which bodies."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.studies import samples
from mpmkit.studies.samples import Sample

Times = int | tuple[float, ...] | None


def _times(value: Any) -> Times:
    if value is None or (isinstance(value, int) and not isinstance(value, bool) and value > 0):
        return value
    from mpmkit.parameters import Spec, convert

    items = value if isinstance(value, (list, tuple, np.ndarray)) else [value]
    spec = Spec("instant of the run", "s", ge=0.0)
    found = tuple(sorted(float(convert(v, float, spec, "times")) for v in items))
    if not found:
        raise ParameterError("times is empty; leave it out for the end of the run, or give instants [s] or their number")
    return found


def _names(value: Any) -> tuple[str, ...]:
    return (value,) if isinstance(value, str) else tuple(value)


@attrs.frozen(kw_only=True)
class Measure:
    """Base of the measures: plain values, so that every process can have them."""

    times: Times = attrs.field(default=None, converter=_times)
    bodies: tuple[str, ...] = attrs.field(default=(), converter=_names)
    name: str = ""

    @property
    def label(self) -> str:
        """Name, norm and unit."""
        return self.name or self._label()

    def _label(self) -> str:
        raise NotImplementedError

    def instants(self, until: float) -> list[float]:
        """When the run is looked at [s]."""
        if self.times is None:
            return [until]
        return [until * k / self.times for k in range(1, self.times + 1)] if isinstance(self.times, int) else list(self.times)

    def fields(self) -> set[str]:
        """Fields of the particles that are read."""
        return set(samples.POINT)

    def chosen(self, found: list[Sample]) -> tuple[str, ...]:
        """Bodies that are looked at.

        Raises
        ------
        ParameterError
            If one of them is not in the scene.
        """
        known = tuple(found[0].bodies)
        for body in self.bodies:
            if body not in known:
                raise ParameterError(
                    f"error {self.label!r}: no body is named {body!r}{did_you_mean(body, known)}; bodies: {', '.join(known)}"
                )
        return self.bodies or known

    def plain(self) -> dict[str, Any]:
        """The measure as a table; what `read` takes."""
        values = {a.name: getattr(self, a.name) for a in attrs.fields(type(self))}
        return {"kind": type(self).__name__} | {
            k: list(v) if isinstance(v, tuple) else v for k, v in values.items() if v not in (None, (), "")
        }


def picked(found: list[Sample], instants: list[float]) -> list[Sample]:
    """The samples at given times."""
    return [min(found, key=lambda s: abs(s.t - t)) for t in instants]
