"""Exact solutions as tables of a study file, and their methods as fields of particles."""

from __future__ import annotations

import inspect
from typing import Any

import attrs
import numpy as np

from mpmkit import exact
from mpmkit.errors import MpmkitError, ParameterError, did_you_mean
from mpmkit.exact.manufactured import Manufactured
from mpmkit.exact.solution import Solution
from mpmkit.parameters import specs
from mpmkit.scene.parts import required
from mpmkit.studies import callables
from mpmkit.studies.samples import SHAPES, component_of

METHODS = {"u": "displacement", "v": "velocity", "stress": "stress", "F": "F", "x": "displacement"}
RADIAL_METHODS = {("stress", "rr"): "stress_r", ("stress", "tt"): "stress_theta", ("u", "r"): "displacement"}
OF_MATERIAL = ("E", "nu", "rho")
"""Parameters of a solution that, if not given, are those of the body's material."""
SYMMETRIC = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def known() -> dict[str, type]:
    """Name -> class of all exact solutions, and of the tractions that some of them take."""
    return {name: cls for name in exact.__all__ if isinstance(cls := getattr(exact, name), type) and issubclass(cls, Solution)}


def plain(solution: Any) -> Any:
    """A solution as a table or, if it is one of a file, its name; what `build` takes.

    Raises
    ------
    ParameterError
        If it is neither an object nor a table of a class in `mpmkit.exact`, nor named "file.py:name".
    """
    if isinstance(solution, Solution):
        if known().get(type(solution).__name__) is not type(solution):
            raise ParameterError(f"solution: {type(solution).__name__} is not in mpmkit.exact; name your own as 'file.py:name'")
        values = {name: getattr(solution, name) for name in specs(type(solution))}
        return {"kind": type(solution).__name__} | {k: plain(v) if isinstance(v, Solution) else v for k, v in values.items()}
    if callables.is_name(solution):
        return solution
    if callable(solution) and not isinstance(solution, type):
        return callables.name_of(solution, "solution")
    if isinstance(solution, str):
        solution = {"kind": solution}
    if not isinstance(solution, dict) or "kind" not in solution:
        raise ParameterError(f'solution must be a table such as {{ kind = "ForcedBar", L = 1.0 }}, got {solution!r}')
    cls = _class(solution["kind"])
    fields = specs(cls)
    for key, value in solution.items():
        if key != "kind" and key not in fields:
            near = did_you_mean(key, fields)
            raise ParameterError(f"solution: {cls.__name__} has no parameter {key!r}{near} (it has {', '.join(fields)})")
        if isinstance(value, dict):
            plain(value)
    return dict(solution)


def _class(name: Any) -> type:
    if name not in known():
        raise ParameterError(f"no exact solution is named {name!r}{did_you_mean(str(name), known())} (known: {', '.join(known())})")
    return known()[name]


def fields_of(solution: Any) -> tuple[str, ...]:
    """Fields that a plain solution gives at a point; of one from a file all are hoped for."""
    if not isinstance(solution, dict):
        return tuple(METHODS)
    cls = _class(solution["kind"])
    pointwise = {base for base, method in METHODS.items() if "x" in _arguments(cls, method)}
    radial = {f"{base}.{c}" for (base, c), method in RADIAL_METHODS.items() if "r" in _arguments(cls, method)}
    return tuple(sorted(pointwise | radial))


def _arguments(cls: type, method: str) -> str:
    """What a method is a function of: "x" for a point, "r" for a radius, "t" for a time."""
    function = getattr(cls, method, None)
    if function is None:
        return ""
    names = [n for n in inspect.signature(function).parameters if n != "self"]
    told = "".join("x" if n in ("x", "X", "Y") else n if n in ("r", "t") else "?" for n in names)
    return "" if "?" in told else told


def build(solution: Any, sim: Any, choices: dict[str, Any], folder: str, bodies: tuple[str, ...]) -> tuple[Any, list[str]]:
    """The object for one run, and remarks on it.

    Parameters of its material that were not given are those of the first body; a function in a file is called with the choices
    of the run that it takes.
    """
    if isinstance(solution, str):
        found = callables.load(solution, folder)
        if isinstance(found, type) or not callable(found) or isinstance(found, Solution):
            return found, []
        wanted = inspect.signature(found).parameters
        every = any(p.kind is p.VAR_KEYWORD for p in wanted.values())
        return found(**{k: v for k, v in choices.items() if every or k in wanted}), []
    cls = _class(solution["kind"])
    body = next((b for b in sim.bodies if not bodies or sim.body_name(b) in bodies), None)
    material = getattr(body, "material", None)
    values = {k: _nested(v) for k, v in solution.items() if k != "kind"}
    notes = []
    for name in OF_MATERIAL:
        own = getattr(material, name, None)
        if name in specs(cls) and isinstance(own, float):
            if name not in values:
                values[name] = own
            elif name == "rho" and isinstance(values[name], (int, float)) and abs(values[name] - own) > 1e-9 * abs(own):
                notes.append(f"the exact solution has rho = {values[name]:g}, the material {own:g}")
    missing = [name for name in required(cls) if name not in values]
    if missing:
        raise ParameterError(f"solution: {cls.__name__} needs {' and '.join(missing)}")
    return cls(**values), notes


def _nested(value: Any) -> Any:
    if not isinstance(value, dict):
        return tuple(value) if isinstance(value, list) else value
    cls = _class(value["kind"])
    missing = [name for name in required(cls) if name not in value]
    if missing:
        raise ParameterError(f"solution: {cls.__name__} needs {' and '.join(missing)}")
    return cls(**{k: _nested(v) for k, v in value.items() if k != "kind"})


@attrs.frozen
class Evaluator:
    """Exact values at particles.

    Parameters
    ----------
    solution : object
        With methods displacement, velocity, stress, F as those of `mpmkit.exact`.
    origin : tuple of float
        Where the solution's origin, or the centre of its radii, is in the scene [m].
    axis : int
        Along which axis of the scene the coordinate of a one-dimensional solution runs.
    space : str
        As in `Grid.space`.
    """

    solution: Any
    origin: tuple[float, ...]
    axis: int
    space: str

    def __call__(self, base: str, component: str, X: Any, t: float) -> tuple[Any, str]:
        """Values (n,) or in full, and the component that they stand for."""
        radial = RADIAL_METHODS.get((base, component), "")
        if radial and "r" in _arguments(type(self.solution), radial):
            offset = X - np.resize(np.asarray(self.origin, float), X.shape[1])
            r = X[:, 0] if self.space == "axisymmetric" else np.linalg.norm(offset[:, :2], axis=1)
            return np.asarray(self._call(radial, r, t), float), component
        name = METHODS.get(base, base)
        if not hasattr(self.solution, name):
            raise ParameterError(f"{type(self.solution).__name__} has no {name}, so there is nothing to compare {base} with")
        if isinstance(self.solution, Manufactured) or getattr(self.solution, "pointwise", False):
            values = np.asarray(self._call(name, X - np.resize(np.asarray(self.origin, float), X.shape[1]), t), float)
            values = values + X if base == "x" else values
            values = _flat(values, base)
            return (component_of(values, base, component, X, self.origin, self.space), component) if component else (values, "")
        line = np.asarray(self._call(name, X[:, self.axis] - np.resize(np.asarray(self.origin, float), X.shape[1])[self.axis], t), float)
        along = "xyz"[self.axis]
        mine = along if SHAPES[base] == "vector" else 2 * along
        if component not in ("", mine):
            raise ParameterError(f"{type(self.solution).__name__} gives {base}.{mine}, not {base}.{component}")
        return (line + X[:, self.axis] if base == "x" else line), mine

    def _call(self, name: str, points: Any, t: float) -> Any:
        method = getattr(self.solution, name)
        arguments = (points, t)[: len(inspect.signature(method).parameters)]
        return method(*arguments)

    def velocity(self, X: Any, t: float) -> Any:
        """Velocities float64[n, dim], or None if the solution has none at points."""
        try:
            values, component = self("v", "", X, t)
        except (MpmkitError, TypeError):
            return None
        if not component:
            return values
        full = np.zeros_like(X)
        full[:, self.axis] = values
        return full


def _flat(values: Any, base: str) -> Any:
    """Tensors (n, 3, 3) as (n, 6) or (n, 9)."""
    if values.ndim < 3:
        return values
    if SHAPES[base] == "symmetric":
        return np.stack([values[:, a, b] for a, b in SYMMETRIC], axis=1)
    return values.reshape(len(values), 9)
