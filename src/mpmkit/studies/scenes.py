"""The scene of one run, from what another process can have: plain data, or the name of a function and its choices."""

from __future__ import annotations

import inspect
import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs

from mpmkit.errors import ParameterError, SceneError, did_you_mean
from mpmkit.studies import callables


@attrs.frozen
class Base:
    """The scene that a study varies.

    Attributes
    ----------
    data : dict, optional
        Of a scene file or simulation.
    function : str, optional
        Name of a function that makes the simulation from the choices.
    folder : str
        From where names of files count.
    parameters : tuple of str
        Arguments of the function; empty if it takes any.
    """

    data: dict[str, Any] | None
    function: str | None
    folder: str
    parameters: tuple[str, ...] = ()
    required: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The scene as people read it."""
        if self.data is None:
            place, _, name = (self.function or "").rpartition(":")
            return f"made by {Path(place).name if place.endswith('.py') else place}:{name}"
        from mpmkit.scene.toml_text import toml

        return toml(self.data)


def base(scene: Any, folder: str) -> Base:
    """What is given as the scene of a study: a path, a table, a `Simulation`, a function or its name.

    Raises
    ------
    SceneError, ParameterError
        If it is no scene, or nothing that another process can have.
    """
    from mpmkit.simulation import Simulation

    if isinstance(scene, Simulation):
        text, reason = scene.scene_text()
        if text is None:
            raise ParameterError(
                f"the simulation cannot be written as a scene ({reason}), and the runs of a study have processes of their own; give a "
                "function make(**choices) that returns the simulation, at the top level of a file"
            )
        return Base(tomllib.loads(text), None, folder)
    if isinstance(scene, dict):
        _checked(scene, "the scene of the study")
        return Base(scene, None, folder)
    if callables.is_name(scene) or callable(scene):
        name = scene if isinstance(scene, str) else callables.name_of(scene, "Study.scene")
        function = callables.load(name, folder)
        if not callable(function):
            raise ParameterError(f"{name} is no function; give one that returns a Simulation")
        if name.rpartition(":")[0].endswith(".py"):
            place, _, attribute = name.rpartition(":")
            name = f"{(Path(folder) / place).resolve()}:{attribute}"
        found = inspect.signature(function).parameters.values()
        every = any(p.kind is p.VAR_KEYWORD for p in found)
        names = tuple(p.name for p in found if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY))
        required = tuple(p.name for p in found if p.default is p.empty and p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY))
        return Base(None, name, folder, () if every else names, required)
    if isinstance(scene, (str, Path)):
        return Base(_file(Path(folder) / scene), None, folder)
    raise ParameterError(f"Study.scene must be a scene file, a table, a Simulation, or a function make(**choices), got {scene!r}")


def _file(path: Path) -> dict[str, Any]:
    from mpmkit.scene import load

    load(path)  # all mistakes of a scene are told before any run
    text = path.read_text(encoding="utf-8-sig")
    data: dict[str, Any] = json.loads(text) if path.suffix == ".json" else tomllib.loads(text)
    return data


def _checked(data: dict[str, Any], source: str) -> Any:
    from mpmkit.scene import loads

    return loads(json.dumps(data), format="json", source=source)


def check_argument(base: Base, path: str) -> None:
    """Refuse an axis that the function of a study does not take."""
    if base.function is not None and base.parameters and path not in base.parameters:
        raise ParameterError(
            f"axis {path!r}: {base.function.rpartition(':')[2]} has no argument {path!r}{did_you_mean(path, base.parameters)} "
            f"(it takes {', '.join(base.parameters)})"
        )


def build(job: dict[str, Any]) -> Any:
    """The simulation of one run, without records.

    Raises
    ------
    MpmkitError
        If the scene refuses its values.
    SceneError
        If a function returns something else.
    """
    if job.get("data") is not None:
        sim = _checked({k: v for k, v in job["data"].items() if k != "records"}, "the scene")
    else:
        function: Callable[..., Any] = callables.load(job["function"], job["folder"])
        sim = function(**{name: component(value) for name, value in job["choices"].items()})
        from mpmkit.simulation import Simulation

        if not isinstance(sim, Simulation):
            raise SceneError(f"{job['function']} must return a Simulation, got {type(sim).__name__}")
        sim.records[:] = []
    if job.get("until") is not None:
        sim.until = job["until"]
    return sim


def component(value: Any) -> Any:
    """What a function of a study is called with: components for tables with a kind, other values as they are."""
    if isinstance(value, list):
        return [component(item) for item in value]
    if not isinstance(value, dict) or "kind" not in value:
        return value
    from mpmkit.geometry import GEOMETRIES, Geometry
    from mpmkit.interfaces import Component
    from mpmkit.scene.mistakes import Mistakes
    from mpmkit.scene.reading import Reader

    mistakes = Mistakes("a value of an axis")
    made = Reader(mistakes).converter.structure(value, Geometry if value["kind"] in GEOMETRIES else Component)
    mistakes.raise_if_any()
    return made
