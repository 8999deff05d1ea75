"""Small scenes of every registered component with parameters of every size, as data of a scene file.

A *mild* scene is one that any stable composition must run: numbers of at most twice or at least half their example, bodies apart and a cell
away from the faces, and in units of the wave speed c, density rho and spacing h of the first body: speeds up to 0.1 c, tractions up to
0.01 rho c^2, accelerations up to 0.01 c^2 / h, rates up to 0.1 c / h, a fixed time step of at most 0.05 h / c. All others are *extreme*.
"""

from __future__ import annotations

import math
from typing import Any

import attrs
import numpy as np
from hypothesis import strategies as st

from mpmkit._core.registry import registry
from mpmkit.geometry import Geometry
from mpmkit.interfaces import Component
from mpmkit.parameters import Value, Vector, example_arguments, specs
from mpmkit.testing.element import drive

SPACES = ("1D", "bar", "plane strain", "axisymmetric", "3D")
CELLS = {1: (8, 10), 2: (5, 7), 3: (4, 5)}
FORMULAS = (
    "{0}*sin({1}*t)",
    "{0}*x/{2}",
    "{0} if x > {2} else 0",
    "-{0}*(x - {2})/{2}",
    "{0}*exp(-{1}*t)",
    "max(-{0}, min({0}, {0}*x/{2}))",
)
MILD = st.floats(-1.0, 1.0).map(lambda e: 2.0**e)
WILD = st.one_of(MILD, st.floats(-9.0, 9.0).map(lambda e: 10.0**e), st.sampled_from((0.0, -1.0, 1e-300, 1e300, -1e12)))


@attrs.define
class Scale:
    """What numbers of a scene are measured in."""

    h: float
    dim: int
    names: list[str]
    faces: list[str]
    lower: list[float]
    upper: list[float]
    c: float = 1.0
    rho: float = 1.0

    def of(self, unit: str) -> float | None:
        """Size of a mild number with this unit in a component that is no material; None if its example must tell."""
        return {
            "m/s": 0.05 * self.c,
            "Pa": 0.005 * self.rho * self.c**2,
            "m/s^2": 0.005 * self.c**2 / self.h,
            "1/s": 0.05 * self.c / self.h,
            "m": self.h,
            "s": 0.025 * self.h / self.c,
        }.get(unit)


def components(kind: str, space: str | None) -> list[type]:
    """Registered components of a kind that work in a space; all if none is given."""
    space = "1D" if space == "bar" else space
    return [e.component for e in registry().of(kind).values() if space is None or space in e.component.spaces]


def bounded(value: float, spec: Any) -> float:
    """The nearest value that the bounds allow."""
    if spec.gt is not None and value <= spec.gt:
        value = spec.gt + (abs(spec.gt) or 1.0) * 1e-3
    if spec.lt is not None and value >= spec.lt:
        value = spec.lt - (abs(spec.lt) or 1.0) * 1e-3
    if spec.ge is not None:
        value = max(value, spec.ge)
    return value if spec.le is None else min(value, spec.le)


@st.composite
def number(draw: Any, spec: Any, default: Any, scale: Scale, mild: bool, own: bool) -> float:
    """One number; `own` if its size is that of its example, as with materials."""
    size = None if own else scale.of(spec.unit)
    if size is None:
        size = next((float(v) for v in (spec.example, default) if isinstance(v, (int, float))), 1.0)
    value = size * draw(MILD if mild else WILD)
    if mild or draw(st.integers(0, 9)):  # one in ten outside its bounds
        value = bounded(value, spec)
    return value


@st.composite
def vector(draw: Any, spec: Any, scale: Scale, mild: bool) -> list[Any]:
    size = scale.of(spec.unit) or 1.0
    parts = [size * draw(MILD if mild else WILD) * draw(st.sampled_from((-1.0, 0.0, 1.0))) for _ in range(scale.dim)]
    return parts if mild or draw(st.integers(0, 19)) else [*parts, 0.0]


@st.composite
def value(draw: Any, spec: Any, scale: Scale, mild: bool) -> Any:
    """Numbers, or formulas of about the same size."""
    parts = draw(vector(spec, scale, mild))
    if draw(st.booleans()):
        size = abs(parts[0]) or scale.of(spec.unit) or 1.0
        text = draw(st.sampled_from(FORMULAS))
        parts[0] = text.format(repr(size), repr(scale.c / scale.h / 10.0), repr(max(map(abs, (*scale.lower, *scale.upper)))))
    return parts


@st.composite
def shape_in(draw: Any, scale: Scale) -> dict[str, Any]:
    """A region somewhere in the domain."""
    low = [a + (b - a) * draw(st.floats(0.0, 0.6)) for a, b in zip(scale.lower, scale.upper, strict=True)]
    up = [a + (b - a) * draw(st.floats(0.2, 0.5)) for a, b in zip(low, scale.upper, strict=True)]
    return {"kind": "Box", "lower": low, "upper": up}


@st.composite
def component(draw: Any, cls: type, scale: Scale, mild: bool) -> dict[str, Any]:
    """The table of one component."""
    table: dict[str, Any] = {"kind": cls.__name__}
    own = cls.kind == "material"
    known = specs(cls)
    for name, (attribute, spec) in known.items():
        required = attribute.default is attrs.NOTHING
        if not required and draw(st.integers(0, 2)) != 0:
            continue
        hint, default = attribute.type, attribute.default
        inner = [h for h in getattr(hint, "__args__", ()) if h is not type(None)]
        if hint == Value:
            table[name] = draw(value(spec, scale, mild))
        elif hint == Vector or Vector in inner:
            table[name] = draw(vector(spec, scale, mild))
        elif spec.choices is not None:
            chosen = draw(st.sampled_from(spec.choices))
            fitting = [f for f in ("all", *scale.faces) if f in spec.choices]
            if fitting and draw(st.integers(0, 19)):
                chosen = draw(st.sampled_from(fitting))
            table[name] = [chosen] if hint == tuple[str, ...] else chosen
        elif name == "body":
            table[name] = draw(st.sampled_from(scale.names)) if mild or draw(st.integers(0, 9)) else "nobody"
        elif hint is Geometry or Geometry in inner:
            table[name] = draw(shape_in(scale))
        elif hint is float or float in inner:
            table[name] = draw(number(spec, default, scale, mild, own))
        elif hint is int or int in inner:
            table[name] = int(bounded(draw(st.integers(0, 12)), spec))
        elif hint is bool:
            table[name] = draw(st.booleans())
        elif isinstance(hint, type) and issubclass(hint, Component):
            chosen = draw(st.sampled_from([e.component for e in registry().of(hint.kind).values()]))
            table[name] = draw(component(chosen, scale, mild))
        elif required:
            table[name] = example_arguments(cls)[name]
    return _consistent(table, known, draw, mild)


def _consistent(table: dict[str, Any], known: Any, draw: Any, mild: bool) -> dict[str, Any]:
    """Of alternatives that exclude each other most scenes get one, since a scene with both is refused at once."""
    if "friction" in table and table.get("condition") not in (None, "friction"):
        del table["friction"]
    if table.get("condition") == "friction":
        table.setdefault("friction", 0.3)
    if {"face", "region"} <= set(known) or {"faces", "region"} <= set(known):
        face = "faces" if "faces" in known else "face"
        if face in table and "region" in table and (mild or draw(st.integers(0, 9))):
            del table["region"]
        if face not in table and "region" not in table and (mild or draw(st.integers(0, 9))):
            table[face] = ["xmin"] if face == "faces" else "xmin"
        if "region" not in table:
            table.pop("moving", None)
        elif table.get("components") in ("normal", "tangential"):
            del table["components"]
        if "region" in table and "thickness" in known:
            table.setdefault("thickness", 1.0)
    return table


@st.composite
def bodies(draw: Any, scale: Scale, mild: bool, space: str) -> list[dict[str, Any]]:
    """One to three bodies side by side; in extreme scenes anywhere."""
    laws = components("material", space)
    if space == "bar" and draw(st.integers(0, 29)):
        laws = [law for law in laws if law.bar_stress is not None]
    cells = round((scale.upper[0] - scale.lower[0]) / scale.h)
    count = draw(st.integers(1, 3 if cells >= 6 else 2))
    room = (cells - 2) / count
    made = []
    for k in range(count):
        name = draw(st.sampled_from(("a", "b", "c"))) + str(k)
        scale.names.append(name)
        table = draw(component(draw(st.sampled_from(laws)), scale, mild))
        if k == 0:
            scale.c, scale.rho = _speed(table, space), float(table["rho"])
        shift = draw(st.sampled_from((0.0, 0.0, 0.25, 0.37)))
        low = [scale.lower[0] + scale.h * (1.0 + k * room + shift * room), *(x + scale.h * (1.0 + shift) for x in scale.lower[1:])]
        up = [scale.lower[0] + scale.h * (1.0 + (k + 1) * room), *(x - scale.h for x in scale.upper[1:])]
        if not mild and draw(st.integers(0, 3)) == 0:
            size = scale.upper[0] - scale.lower[0]
            low = [x - size * draw(st.floats(-0.9, 0.3)) for x in low]
            up = [x + size * draw(st.floats(0.01, 0.6)) for x in low]
        body = {"name": name, "geometry": {"kind": "Box", "lower": low, "upper": up}, "material": table}
        if scale.dim == 2 and draw(st.integers(0, 4)) == 0:
            centre = [0.5 * (a + b) for a, b in zip(low, up, strict=True)]
            body["geometry"] = {"kind": "Disk", "center": centre, "radius": 0.5 * min(b - a for a, b in zip(low, up, strict=True))}
        speed = type("Speed", (), {"unit": "m/s"})
        if draw(st.integers(0, 3)):
            body["v"] = draw(vector(speed, scale, mild))
        if draw(st.integers(0, 3)) == 0:
            body["particles_per_cell"] = (
                draw(st.sampled_from((1, 2, 3) if scale.dim < 3 else (1, 2))) ** scale.dim
                if mild
                else draw(st.sampled_from((1, 2, 3, 4, 9, 16, 27)))
            )
        if draw(st.integers(0, 5)) == 0:
            body["lattice"] = "body"
        if draw(st.integers(0, 9)) == 0:
            stretch = 1.0 + (0.01 if mild else 0.5) * draw(st.floats(-1.0, 1.0))
            body["F"] = [[stretch, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        takes_stress = "stress" in getattr(registry().get(table["kind"], "material").component.stress, "arguments", ())
        if draw(st.integers(0, 9)) == 0 and (takes_stress or not draw(st.integers(0, 9))):
            body["stress"] = [draw(st.floats(-1.0, 1.0)) * 0.01 * scale.rho * scale.c**2, 0.0, 0.0, 0.0, 0.0, 0.0]
        made.append(body)
    if not mild and draw(st.integers(0, 3)) == 0:
        made[-1]["material"] = made[0]["material"]
    return made


def _speed(table: dict[str, Any], space: str) -> float:
    """Wave speed of a material at rest; 1 if its numbers are out of bounds."""
    cls = registry().get(table["kind"], "material").component
    try:
        material = cls(**{k: v for k, v in table.items() if k != "kind"})
        with np.errstate(all="ignore"):
            c = float(drive(material, np.eye(3)[None], bar=space == "bar").wave_speed[0])
    except (ArithmeticError, ValueError, TypeError):
        return 1.0
    return c if math.isfinite(c) and c > 0.0 else 1.0


@st.composite
def scenes(draw: Any, mild: bool | None = None) -> tuple[bool, dict[str, Any]]:
    """(mild, scene): a scene as data, without the time at which it ends."""
    mild = draw(st.booleans()) if mild is None else mild
    space = draw(st.sampled_from(SPACES))
    dim = {"1D": 1, "bar": 1, "3D": 3}.get(space, 2)
    cells = [draw(st.integers(*CELLS[dim])) for _ in range(dim)]
    h = draw(st.sampled_from((0.125, 1.0, 0.1, 1e-3)) if mild else st.sampled_from((0.125, 0.1, 1e-6, 1e6, 1e-30)))
    low = [0.0 if space == "axisymmetric" and k == 0 else h * draw(st.sampled_from((0.0, -2.0, 0.37, 100.0))) for k in range(dim)]
    if space == "axisymmetric" and draw(st.booleans()):
        low[0] = 2.0 * h
    up = [a + n * h for a, n in zip(low, cells, strict=True)]
    grid: dict[str, Any] = {"lower": low, "upper": up, "spacing": h}
    if space == "axisymmetric":
        grid["coordinates"] = space
    if space == "bar":
        grid["lateral"] = "stress"
    scale = Scale(h, dim, [], [f"{a}{e}" for a in "xyz"[:dim] for e in ("min", "max")], low, up)
    scene: dict[str, Any] = {"grid": grid, "bodies": draw(bodies(scale, mild, space))}
    if draw(st.booleans()):
        scene["precision"] = draw(st.sampled_from(("float32", "float64")))

    def any_of(kind: str) -> Any:
        known = components(kind, space if draw(st.integers(0, 29)) else None)
        return draw(component(draw(st.sampled_from(known)), scale, mild))

    if draw(st.integers(0, 7)) == 0 and components("discretization", space):
        scene["discretization"] = any_of("discretization")
    else:
        scene["shape"], scene["integrator"] = any_of("shape"), any_of("integrator")
    scene["boundaries"] = [any_of("boundary") for _ in range(draw(st.integers(0, 2)))]
    if space == "axisymmetric" and low[0] == 0.0 and (mild or draw(st.integers(0, 9))):
        scene["boundaries"].append({"kind": "Symmetry", "faces": ["xmin"]})
    scene["effects"] = [any_of("effect") for _ in range(draw(st.integers(0, 2)))]
    scene["contacts"] = [any_of("contact") for _ in range(draw(st.sampled_from((0, 0, 1, 1, 2) if not mild else (0, 1))))]
    if draw(st.integers(0, 7)) == 0:
        record: dict[str, Any] = {"path": "run.vtkhdf", "history": draw(st.integers(1, 20))}
        fields = st.sampled_from(("x", "v", "stress", "F", "J", "V", "m", "C", "nothing"))
        record["fields"] = sorted(draw(st.sets(fields, min_size=1))) if not mild else ["x", "v", "stress"]
        if draw(st.booleans()):
            record["every"] = 0.2 * h / scale.c * draw(st.floats(0.1, 10.0))
        scene["records"] = [record | {"compress": draw(st.booleans()), "checkpoint": draw(st.booleans())}]
    return mild, {k: v for k, v in scene.items() if v != []}
