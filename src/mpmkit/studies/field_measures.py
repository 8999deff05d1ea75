"""Measures of a field's error: `Exact` against an exact solution, `Finest` against the finest run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.studies import samples, solutions
from mpmkit.studies.measure import Measure, picked
from mpmkit.studies.norms import NORMS, OVER, norm
from mpmkit.studies.paths import table_of
from mpmkit.studies.samples import Sample


def _numbers(value: Any) -> tuple[float, ...]:
    return tuple(map(float, value)) if isinstance(value, (list, tuple)) else (float(value),)


def _field(value: Any) -> str:
    base, component = samples.parse(str(value))
    return f"{base}.{component}" if component else base


def _one_of(choices: tuple[str, ...], name: str) -> Any:
    def check(_: Any, __: Any, value: Any) -> None:
        if value not in choices:
            near = did_you_mean(str(value), choices)
            raise ParameterError(f"{name} must be one of {', '.join(choices)}, got {value!r}{near}")

    return check


@attrs.frozen(kw_only=True)
class OfField(Measure):
    """A norm of a field's error."""

    field: str = attrs.field(converter=_field)
    norm: str = attrs.field(default="L2", validator=_one_of(NORMS, "norm"))
    over: str = attrs.field(default="all", validator=_one_of(OVER, "over"))
    relative: bool = False
    scale: float | None = None
    region: Any = attrs.field(default=None, converter=table_of)
    origin: tuple[float, ...] = attrs.field(default=(0.0,), converter=_numbers)

    against: ClassVar[str] = ""

    def __attrs_post_init__(self) -> None:
        if self.scale is not None and (self.relative or not self.scale > 0.0):
            raise ParameterError(f"error {self.label!r}: scale must be > 0, and not be given together with relative")

    @property
    def unit(self) -> str:
        """Unit of the error."""
        return "1" if self.relative or self.scale is not None else samples.UNITS[self.field.split(".")[0]]

    def _label(self) -> str:
        unit = samples.UNITS[self.field.split(".")[0]]
        unit = unit if self.scale is None else f"{self.scale:g} {unit}".removesuffix(" 1")
        over = ", largest in time" if self.over == "largest" else ""
        if self.relative:
            return f"{self.field}, relative {self.norm}{over}{self.against}"
        return f"{self.field}, {self.norm}{over}{self.against} [{unit}]"

    def fields(self) -> set[str]:
        return super().fields() | {samples.stored(self.field.split(".")[0])}

    def inside(self, X: Any) -> Any:
        """Particles that count, by their places at the start."""
        if self.region is None:
            return np.ones(len(X), dtype=bool)
        from mpmkit.geometry import Geometry
        from mpmkit.scene.mistakes import Mistakes
        from mpmkit.scene.reading import Reader

        mistakes = Mistakes(f"error {self.label!r}, region")
        shape = Reader(mistakes).converter.structure(self.region, Geometry)
        mistakes.raise_if_any()
        return np.asarray(shape.contains(X))

    def reduced(self, wrong: list[Any], exact: list[Any], weights: list[Any]) -> float:
        """The norm of the errors, over that of the exact values if relative."""
        base = self.field.split(".")[0]
        value = norm(self.norm, self.over, [samples.size_of(e, base) for e in wrong], weights)
        if not self.relative:
            return value / (self.scale or 1.0)
        whole = norm(self.norm, self.over, [samples.size_of(e, base) for e in exact], weights)
        if not whole > 0.0:
            raise ParameterError(f"error {self.label!r}: the exact values are zero there; use absolute errors, or scale=...")
        return value / whole


@attrs.frozen(kw_only=True)
class Exact(OfField):
    """Error of a field against an exact solution.

    Parameters
    ----------
    solution : Solution, dict, or str
        Of `mpmkit.exact`; as a table ``{kind = "ForcedBar", L = 1.0, ...}``; or "file.py:name" of your own object with methods
        displacement(x, t), velocity(x, t), stress(x, t) (or a function that makes it from the choices of a run). E, nu and rho
        that a table leaves out are those of the body's material.
    field : str
        "u" (displacement), "x", "v", "stress", "F", or a component: "stress.xx", "v.x", radial "u.r", "stress.rr", "stress.tt".
    norm : str
        "L1" (mean), "L2" (root mean square), "max"; means are weighted by the volumes of the particles.
    times : int or list of float, optional
        Instants [s], or how many equal parts of the run; its end if not given.
    over : str
        "all" instants together, or the "largest" of the norms at each.
    bodies : list of str, optional
        All if not given.
    region : Geometry, optional
        Only particles that start inside.
    relative : bool
        Divided by the norm of the exact values.
    scale : float, optional
        Divided by this instead.
    origin : float or list of float
        Where the solution's origin is in the scene [m].
    axis : int
        Direction of the coordinate of a one-dimensional solution.
    name : str
        In place of the label made of all this.
    """

    solution: Any = attrs.field(converter=solutions.plain)
    axis: int = 0

    def __attrs_post_init__(self) -> None:
        super().__attrs_post_init__()
        known = solutions.fields_of(self.solution)
        if self.field not in known and self.field.split(".")[0] not in known:
            kind = self.solution["kind"]
            told = f"it has {', '.join(known)}" if known else "it gives no fields at points; compare a Quantity with its attributes"
            raise ParameterError(
                f"error {self.label!r}: the exact solution {kind} has no {self.field}{did_you_mean(self.field, known)} ({told})"
            )

    def value(self, found: list[Sample], until: float, evaluator: solutions.Evaluator, staggered: bool) -> float:
        """The error; `staggered` says that velocities are those of half a step before."""
        base, component = samples.parse(self.field)
        wrong: list[Any] = []
        exact: list[Any] = []
        weights: list[Any] = []
        for sample in picked(found, self.instants(until)):
            t = sample.t - 0.5 * sample.dt if staggered and base == "v" else sample.t
            parts: list[tuple[Any, Any, Any]] = []
            for body in self.chosen(found):
                X = samples.field_of(sample, body, "X")
                inside = self.inside(X)
                if not inside.any():
                    continue
                X = X[inside]
                right, which = evaluator(base, component, X, t)
                mine = samples.field_of(sample, body, base)[inside]
                mine = samples.component_of(mine, base, which, X, self.origin, sample.space) if which else mine
                parts.append((_cut(mine, right) - right, right, samples.weights_of(sample, body)[inside]))
            if not parts:
                raise ParameterError(f"error {self.label!r}: no particle starts inside the region")
            for together, these in zip((wrong, exact, weights), zip(*parts, strict=True), strict=True):
                together.append(np.concatenate(these))
        return self.reduced(wrong, exact, weights)


def _cut(mine: Any, right: Any) -> Any:
    """Fields of a plane or axisymmetric scene may have more components than a solution gives."""
    return mine if mine.shape == right.shape or mine.ndim == 1 else mine[:, : right.shape[1]]


@attrs.frozen(kw_only=True)
class Finest(OfField):
    """Difference from the finest run of the same composition, or from a named run.

    The finest run is that with the smallest resolution; its field is interpolated linearly to the places where particles of the
    others started, or taken as it is where both have the same particles. The finest run itself has no error.

    Parameters
    ----------
    field, norm, times, over, bodies, region, relative, scale, name
        As for `Exact`.
    reference : str
        Name of a run of the study that all are compared with, instead of the finest of each composition.
    """

    reference: str = ""
    against: ClassVar[str] = " from the finest"

    def arrays(self, found: list[Sample], until: float) -> dict[str, Any]:
        """What is kept of a run to compare: by body places, weights, and the field at each instant."""
        base, component = samples.parse(self.field)
        out: dict[str, Any] = {}
        for body in self.chosen(found):
            X = samples.field_of(found[0], body, "X")
            inside = self.inside(X)
            out[f"{body}/X"], out[f"{body}/w"] = X[inside], samples.weights_of(found[0], body)[inside]
            rows = []
            for sample in picked(found, self.instants(until)):
                values = samples.field_of(sample, body, base)
                rows.append((samples.component_of(values, base, component, X, self.origin, sample.space) if component else values)[inside])
            out[f"{body}/values"] = np.array(rows)
        return out

    def compare(self, mine: Mapping[str, Any], fine: Mapping[str, Any]) -> float:
        """The norm of the difference between what `arrays` kept of two runs.

        Raises
        ------
        ParameterError
            If they have not the same bodies or instants.
        """
        if set(mine) != set(fine) or any(len(mine[k]) != len(fine[k]) for k in mine if k.endswith("/values")):
            raise ParameterError(f"error {self.label!r}: the finest run has other bodies or instants")
        bodies = sorted({k.rpartition("/")[0] for k in mine})
        count = len(mine[f"{bodies[0]}/values"])
        wrong: list[Any] = [[] for _ in range(count)]
        exact: list[Any] = [[] for _ in range(count)]
        for body in bodies:
            X, places = mine[f"{body}/X"], fine[f"{body}/X"]
            for k in range(count):
                right = at_points(places, fine[f"{body}/values"][k], X)
                wrong[k].append(mine[f"{body}/values"][k] - right)
                exact[k].append(right)
        weights = [np.concatenate([mine[f"{body}/w"] for body in bodies])] * count
        return self.reduced([np.concatenate(e) for e in wrong], [np.concatenate(e) for e in exact], weights)


def at_points(places: Any, values: Any, X: Any) -> Any:
    """A field known at some places, at others: as it is for equal ones, linear between, the nearest one outside."""
    if places.shape == X.shape and np.allclose(places, X, rtol=0.0, atol=1e-12 * max(float(np.ptp(places)), 1e-300)):
        return values
    if X.shape[1] == 1:
        order = np.argsort(places[:, 0])
        columns = values.reshape(len(values), -1).T
        found = np.stack([np.interp(X[:, 0], places[order, 0], c[order]) for c in columns], axis=1)
        return found.reshape(len(X), *values.shape[1:])
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

    found = LinearNDInterpolator(places, values)(X)
    outside = np.isnan(found.reshape(len(X), -1)).any(axis=1)
    if outside.any():
        found[outside] = NearestNDInterpolator(places, values)(X[outside])
    return found
