"""Measures of error: against an exact solution, against the finest run, of a quantity of interest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.studies import callables, quantities, samples, solutions
from mpmkit.studies.norms import NORMS, OVER, norm
from mpmkit.studies.paths import table_of
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


@attrs.frozen(kw_only=True)
class _OfField(Measure):
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
class Exact(_OfField):
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
class Finest(_OfField):
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


def _quantity(value: Any) -> str:
    return callables.name_of(value, "Quantity") if callable(value) else str(value)


@attrs.frozen(kw_only=True)
class Quantity(Measure):
    """Error of one number of a run.

    Parameters
    ----------
    quantity : str or callable
        Of the library (`mpmkit.studies.quantities.LIBRARY`: "restitution", "final length", "energy drift", "run-out", "period" ...),
        a column of the history (its last value), or a function of `Facts`, also as "file.py:name".
    exact : float or dict, optional
        The right value; or ``{solution = {kind = "BarImpact", ...}, attribute = "restitution"}``. Quantities that ought to be zero
        need none.
    relative : bool
        Divided by the size of the right value.
    axis : int
        Direction, for those that need one.
    unit : str
        Of a function's value.
    times, bodies, name
        As for `Exact`; a function finds the instants in `Facts.samples`.
    """

    quantity: str = attrs.field(converter=_quantity)
    exact: Any = None
    relative: bool = False
    axis: int = 0
    own_unit: str = attrs.field(default="1", alias="unit")

    @quantity.validator
    def _known(self, _: Any, value: Any) -> None:
        from mpmkit._core.running.ledger import COLUMNS

        known = (*quantities.LIBRARY, *COLUMNS)
        if not callables.is_name(value) and value not in known:
            raise ParameterError(
                f"no quantity is named {value!r}{did_you_mean(str(value), known)} (known: {', '.join(quantities.LIBRARY)})"
            )

    def __attrs_post_init__(self) -> None:
        if self.exact is None and (self.quantity not in quantities.LIBRARY or quantities.LIBRARY[self.quantity].exact is None):
            raise ParameterError(f"Quantity({self.quantity!r}) needs its exact value: exact=...")
        if isinstance(self.exact, dict):
            table = dict(self.exact)
            if set(table) != {"solution", "attribute"}:
                raise ParameterError("exact must be a number or { solution = {...}, attribute = '...' }")
            object.__setattr__(self, "exact", table | {"solution": solutions.plain(table["solution"])})

    @property
    def unit(self) -> str:
        """Unit of the error."""
        named = quantities.LIBRARY.get(self.quantity)
        return "1" if self.relative else named.unit if named else self.own_unit

    def _label(self) -> str:
        name = self.quantity.rpartition(":")[2].replace("_", " ") if callables.is_name(self.quantity) else self.quantity
        if self.relative:
            return f"{name}, relative error"
        return f"{name}, error" + (f" [{self.unit}]" if self.unit != "1" else "")

    def fields(self) -> set[str]:
        return super().fields() | {"v", "m", "stress"}

    def plain(self) -> dict[str, Any]:
        table = super().plain()
        if "own_unit" in table:
            table["unit"] = table.pop("own_unit")
        return table

    def number(self, history: dict[str, Any], found: list[Sample], folder: str) -> float:
        """The quantity itself."""
        facts = quantities.Facts(history, found, self.chosen(found), self.axis)
        if self.quantity in quantities.LIBRARY:
            return float(quantities.LIBRARY[self.quantity].compute(facts))
        if self.quantity in history:
            return float(history[self.quantity][-1])
        return float(callables.load(self.quantity, folder)(facts))

    def right(self, sim: Any, choices: dict[str, Any], folder: str) -> float:
        """The value that it ought to have."""
        if self.exact is None:
            return float(quantities.LIBRARY[self.quantity].exact or 0.0)
        if not isinstance(self.exact, dict):
            return float(self.exact)
        solution, _ = solutions.build(self.exact["solution"], sim, choices, folder, self.bodies)
        name = self.exact["attribute"]
        if not hasattr(solution, name):
            raise ParameterError(f"{type(solution).__name__} has no attribute {name!r}{did_you_mean(name, dir(solution))}")
        return float(getattr(solution, name))


KINDS: dict[str, Any] = {"Exact": Exact, "Finest": Finest, "Quantity": Quantity}


def picked(found: list[Sample], instants: list[float]) -> list[Sample]:
    """The samples at given times."""
    return [min(found, key=lambda s: abs(s.t - t)) for t in instants]


def read(table: Any) -> Measure:
    """A measure from a table with its kind, or as it is.

    Raises
    ------
    ParameterError
        If the kind or a key is unknown, or the measure cannot be.
    """
    if isinstance(table, Measure):
        return table
    if not isinstance(table, Mapping) or "kind" not in table:
        raise ParameterError(
            f'an error measure is a table such as {{ kind = "Exact", solution = {{...}}, field = "stress.xx" }}, got {table!r}'
        )
    kind, rest = table["kind"], {k: v for k, v in table.items() if k != "kind"}
    if kind not in KINDS:
        raise ParameterError(f"no error measure is named {kind!r}{did_you_mean(str(kind), KINDS)} (known: {', '.join(KINDS)})")
    arguments = {a.alias: a for a in attrs.fields(KINDS[kind])}
    for key in rest:
        if key not in arguments:
            raise ParameterError(f"{kind} has no parameter {key!r}{did_you_mean(key, arguments)} (it has {', '.join(arguments)})")
    missing = [name for name, a in arguments.items() if a.default is attrs.NOTHING and name not in rest]
    if missing:
        raise ParameterError(f"{kind} needs {' and '.join(missing)}")
    made: Measure = KINDS[kind](**rest)
    return made
