"""From recorded fields to the one number per particle that a picture shows, with its name and unit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from mpmkit._core.reading.components import component_names
from mpmkit.errors import ResultsError, did_you_mean
from mpmkit.fields import PARTICLE_FIELDS

if TYPE_CHECKING:
    from mpmkit._core.reading.frame import Frame
    from mpmkit.results import Results

DERIVED = {
    "pressure": ("stress", "pressure", "Pa"),
    "mises": ("stress", "von Mises stress", "Pa"),
    "displacement": ("X", "displacement", "m"),
}
"""Quantities that are computed from a field: name -> (field, label, unit)."""
_LABELS = {"v": "speed", "q": "artificial viscous pressure", "c": "wave speed", "body": "body"}


@attrs.frozen(eq=False)
class Quantity:
    """What is drawn.

    Attributes
    ----------
    name : str
        As asked for, such as "stress.xx".
    label, unit : str
        For axes and colour bars; the unit is SI.
    signed : bool
        Whether zero is the middle of the colours.
    """

    name: str
    label: str
    unit: str
    signed: bool
    _field: str
    _component: int | None
    _dim: int

    def values(self, frame: Frame) -> np.ndarray:
        """The number for each particle, float64[n]."""
        array = np.asarray(frame[self._field], dtype=float)
        rows: np.ndarray = array.reshape(len(array), int(np.prod(array.shape[1:], dtype=int)))
        if self.name == "pressure":
            return np.asarray(-rows[:, :3].sum(axis=1) / 3)
        if self.name == "displacement":
            return np.asarray(np.linalg.norm(frame["x"] - array, axis=1))
        if self._component is not None:
            return rows[:, self._component]
        if rows.shape[1] == 1:
            return rows[:, 0]
        if self.label == "von Mises stress":
            return von_mises(rows)
        return np.asarray(np.linalg.norm(rows, axis=1))


def quantity(results: Results, frame: Frame, name: str, component: str | None = None) -> Quantity:
    """Find out what is meant by "v", "stress", "stress.xx", "pressure", "F.xy" ...

    A vector alone means its length, the stress alone von Mises' equivalent stress; in 1D both mean their
    component along x.

    Raises
    ------
    ResultsError
        If the run has no such field or component; names those it has.
    """
    field, _, dotted = name.partition(".")
    component = component or dotted or None
    dim = frame["x"].shape[1]
    units = results.meta.get("units", {})
    if field in DERIVED:
        source, label, unit = DERIVED[field]
        if component is not None:
            raise ResultsError(f"{field!r} has no components, got {component!r}; draw {field!r} or a component of {source!r}")
        if source not in frame:
            raise ResultsError(f"{field!r} is computed from {source!r}, which this run did not keep; add it to Record(fields=...)")
        return Quantity(field, label, unit, field == "pressure", source, None, dim)
    if field not in frame:
        known = [*frame, *(d for d, (source, _, _) in DERIVED.items() if source in frame)]
        raise ResultsError(f"this run has no field {field!r}{did_you_mean(field, known)} (it has {', '.join(known)})")
    unit = units.get(field, PARTICLE_FIELDS[field].unit if field in PARTICLE_FIELDS else "1")
    names = component_names(int(np.prod(frame[field].shape[1:], dtype=int))) if frame[field].ndim > 1 else ()
    if component is None and dim == 1 and names and (field in ("x", "v") or names[0] == "xx"):
        component = names[0]
    if component is not None:
        if component not in names:
            have = f"it has {', '.join(names)}" if names else "it is one number"
            raise ResultsError(f"field {field!r} has no component {component!r}{did_you_mean(component, names)} ({have})")
        label = _component_label(field, component)
        return Quantity(f"{field}.{component}", label, unit, True, field, names.index(component), dim)
    if field == "stress" and len(names) in (6, 9):
        return Quantity(field, "von Mises stress", unit, False, field, None, dim)
    label = _LABELS.get(field, f"|{field}|" if names else _words(field))
    signed = not names and bool((results.frames[-1][field] < 0).any() or (frame[field] < 0).any())
    return Quantity(field, label, unit, signed, field, None, dim)


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Equivalent stress sqrt(3/2 s:s) [Pa] of rows xx yy zz xy yz xz, or of nine components."""
    if stress.shape[1] == 9:
        stress = stress[:, (0, 4, 8, 1, 5, 2)]
    xx, yy, zz, xy, yz, xz = stress.T
    return np.asarray(np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) + 3.0 * (xy**2 + yz**2 + xz**2)))


def _component_label(field: str, component: str) -> str:
    if field == "stress":
        return rf"stress $\sigma_{{{component}}}$"
    if field == "v":
        return f"velocity $v_{component}$"
    return f"${field}_{{{component}}}$" if len(field) == 1 else f"{_words(field)} {component}"


def _words(field: str) -> str:
    known: Any = PARTICLE_FIELDS.get(field)
    return known.doc.split(",")[0] if known is not None and known.doc else field.replace("_", " ")
