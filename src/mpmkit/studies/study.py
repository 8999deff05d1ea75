"""`Study`: a scene, what to vary, and how to measure the error; run it to know what accuracy costs."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpmkit.errors import ParameterError, SceneError, did_you_mean
from mpmkit.parameters import Spec, convert
from mpmkit.studies import axes as axes_of
from mpmkit.studies import measures, paths, plan, scenes
from mpmkit.studies.stepping import STAGGERED

if TYPE_CHECKING:
    from mpmkit.studies.results import StudyResults

STARTUPS = (STAGGERED, "as given")
REFINING = ("N", "n", "cells", "h", "spacing", "resolution")
"""Arguments of functions that are taken for the resolution."""
KEYS = (
    "scene", "axes", "runs", "errors", "repeat", "name", "time_budget", "memory_budget", "startup", "threads", "resolution", "problems",
    "until",
)  # fmt: skip
"""Keys of a study file."""


class Study:
    """Errors and wall times of many versions of one scene.

    Parameters
    ----------
    scene : path, Simulation, dict, callable or str
        A scene file; a simulation; the data of a scene; a function ``make(**choices)`` that returns a `Simulation`, at the top level of
        a file; or the name of one, "file.py:make".
    axes : dict, optional
        What varies: paths into the scene ("grid.spacing", "shape", "integrator.transfer", "bodies.*.particles_per_cell",
        "bodies[0].material.E", "precision" ...) or arguments of the function, each with a list of values: numbers, names of
        components, tables, components. All combinations are run. A table of lists of equal length lets several vary together; the key
        "labels" names its values.
    runs : list of dict, optional
        Named runs beside the product, or without axes in place of it: ``{"name": ..., "set": {path: value}}``.
    errors : measure, dict, or list of them
        `Exact`, `Finest`, `Quantity`.
    repeat : int
        How often each run is timed; 0 for errors alone.
    name : str, optional
        For reports; that of the scene file if not given.
    time_budget : float or str, optional
        Longest wall time of a run [s]; one that takes longer is stopped and shown as such.
    memory_budget : int or str, optional
        Most memory of a run [B], or text such as "2 GB".
    startup : str
        "staggered": particles start with the exact velocities of half a step earlier, where explicit steps have them, and
        velocities are compared with those of half a step earlier; only where the scene starts with the exact velocities.
        "as given": velocities of t = 0 at the start, compared at t; an error of first order in the time step.
    threads : int
        Threads of each run.
    resolution : str, optional
        The axis that refines, which does not count as part of the composition; guessed if not given.
    problems : str or list of str, optional
        Axes that make another problem of the scene, such as an amplitude: runs are only compared with those of the same problem.
    until : float or str, optional
        End of all runs [s], if not that of the scene.
    folder : path
        From where paths in this study count.

    Raises
    ------
    ParameterError, SceneError
        At once, if anything given cannot be; names it, and the nearest name.

    Examples
    --------
    >>> study = Study(
    ...     "bar.toml", {"grid.spacing": [0.1, 0.05], "shape": ["Linear", "GIMP"]},
    ...     errors=[{"kind": "Exact", "solution": {"kind": "ForcedBar", "L": 1.0, ...}, "field": "stress.xx"}],
    ... )  # doctest: +SKIP
    >>> print(study.run("bar-study").to_markdown())  # doctest: +SKIP
    """

    def __init__(
        self,
        scene: Any,
        axes: Mapping[str, Any] | None = None,
        runs: Iterable[Mapping[str, Any]] | None = None,
        errors: Any = (),
        *,
        repeat: int = 3,
        name: str | None = None,
        time_budget: float | str | None = None,
        memory_budget: float | str | None = None,
        startup: str = STAGGERED,
        threads: int = 1,
        resolution: str | None = None,
        problems: str | Iterable[str] = (),
        until: float | str | None = None,
        folder: str | os.PathLike[str] = ".",
    ) -> None:
        self.folder = str(Path(folder).resolve())
        self.base = scenes.base(scene, self.folder)
        self.name = name or _name(scene, self.base)
        if axes is not None and not isinstance(axes, Mapping):
            raise ParameterError(f"Study.axes must be a table of lists, got {axes!r}")
        self.axes = axes_of.read(axes or {})
        self.runs = [_run(table) for table in runs or ()]
        given = [errors] if isinstance(errors, (measures.Measure, Mapping)) else list(errors)
        self.errors = [measures.read(table) for table in given]
        self.repeat: int = convert(repeat, int, Spec("how often each run is timed", ge=0), "Study.repeat")
        self.time_budget: float | None = convert(time_budget, float | None, Spec("wall time of a run", "s", gt=0.0), "Study.time_budget")
        self.memory_budget = _bytes(memory_budget)
        if startup not in STARTUPS:
            raise ParameterError(f"Study.startup must be one of {', '.join(STARTUPS)}, got {startup!r}{did_you_mean(startup, STARTUPS)}")
        self.startup = startup
        self.threads: int = convert(threads, int, Spec("threads of each run", ge=1), "Study.threads")
        self.until: float | None = convert(until, float | None, Spec("end of the runs", "s", gt=0.0), "Study.until")
        self._check()
        self.resolution = self._refining(resolution)
        self.problems = (problems,) if isinstance(problems, str) else tuple(problems)
        names = [axis.name for axis in self.axes]
        for name in self.problems:
            if name not in names or name == self.resolution:
                told = "refines" if name == self.resolution else "is no axis"
                raise ParameterError(f"Study.problems: {name!r} {told}{did_you_mean(name, names)} (axes: {', '.join(names) or 'none'})")

    def _check(self) -> None:
        labels = [m.label for m in self.errors]
        twice = sorted({label for label in labels if labels.count(label) > 1})
        if twice:
            raise ParameterError(f"two errors are called {twice[0]!r}; give one of them a name")
        if not self.errors and not self.repeat:
            raise ParameterError("a study without errors and with repeat = 0 has nothing to measure")
        named = [run["name"] for run in self.runs]
        for m in self.errors:
            if isinstance(m, measures.Finest) and m.reference and m.reference not in named:
                raise ParameterError(
                    f"error {m.label!r}: no run is named {m.reference!r}{did_you_mean(m.reference, named)}; name it in runs"
                )
        for path in [p for axis in self.axes for p in axis.paths] + [p for run in self.runs for p in run.get("set", {})]:
            if self.base.function is not None:
                scenes.check_argument(self.base, path)
            else:
                top = paths.split(path)[0]
                if top not in paths.TOPS:
                    paths.put({}, path, None)  # its message

    def _refining(self, given: str | None) -> str | None:
        names = [axis.name for axis in self.axes]
        if given is not None:
            if given not in names:
                raise ParameterError(f"Study.resolution: there is no axis {given!r}{did_you_mean(given, names)} (axes: {', '.join(names)})")
            return given
        tests: list[Any] = [
            lambda a: "grid.spacing" in a.paths,
            lambda a: self.base.function is not None and a.name in REFINING,
            lambda a: any(p.endswith("particles_per_cell") for p in a.paths),
            lambda a: a.numbers is not None and len(a.values) > 1,
        ]
        return next((a.name for test in tests for a in self.axes if test(a)), "grid.spacing" if self.runs else None)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], **changed: Any) -> Study:
        """Read a study file (TOML); paths in it count from its folder.

        Parameters
        ----------
        path : path
            The file.
        **changed
            In place of what it says, such as ``repeat=1``.

        Raises
        ------
        SceneError
            If it cannot be read, or has an unknown key.
        """
        path = Path(path)
        try:
            data = tomllib.loads(path.read_text(encoding="utf-8-sig"))
        except FileNotFoundError:
            near = [p.name for p in path.parent.glob("*.toml")] if path.parent.is_dir() else []
            raise SceneError(f"there is no study file {str(path)!r}{did_you_mean(path.name, near)}") from None
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise SceneError(f"cannot read the study file {path}: {error}") from None
        for key in data:
            if key not in KEYS:
                raise SceneError(f"{path}: unknown key {key!r}{did_you_mean(key, KEYS)} (a study has {', '.join(KEYS)})")
        if "scene" not in data:
            raise SceneError(f"{path}: required key 'scene' is missing: a scene file, a table [scene], or \"file.py:make\"")
        data.setdefault("name", path.stem)
        return cls(**{**data, **changed}, folder=path.parent)

    def job(self, run: plan.Run) -> dict[str, Any]:
        """What another process needs to do one run: plain data."""
        return {
            "data": run.data,
            "function": self.base.function,
            "folder": self.folder,
            "choices": run.arguments or run.choices,
            "until": run.until,
            "measures": [m.plain() for m in self.errors],
            "startup": self.startup,
            "threads": self.threads,
            "time_budget": self.time_budget,
            "memory_budget": self.memory_budget,
        }

    def plan(self) -> list[plan.Run]:
        """All runs, composed but not sampled or compiled; refused ones with the reason."""
        return plan.runs(self)

    def predict(self, quiet: bool = True) -> list[dict[str, Any]]:
        """What each run is going to cost, from a short calibration of each composition; see `mpmkit.studies.cost.predict`."""
        from mpmkit.studies.cost import predict

        return predict(self, self.plan(), quiet=quiet)

    def run(
        self, folder: str | os.PathLike[str] | None = None, executor: Any = None, quiet: bool = False, jobs: int | None = None
    ) -> StudyResults:
        """Do all runs: errors side by side, then wall times one at a time.

        Parameters
        ----------
        folder : path, optional
            Where results are kept as they come; what is there already is not done again. NAME-study if not given.
        executor : optional
            Anything with ``submit(function, argument)`` that returns futures, such as `concurrent.futures.ProcessPoolExecutor` or a
            Dask ``Client``; errors are computed there. Wall times are always measured on this machine.
        quiet : bool
            No progress on the terminal.
        jobs : int, optional
            Runs side by side on this machine, without an executor; one for each core if not given.

        Returns
        -------
        StudyResults
            A row for every run, whatever became of it.

        Raises
        ------
        CompositionError
            If all runs are refused.
        ResultsError
            If the folder cannot be written.
        KeyboardInterrupt
            After Ctrl-C; what was done is kept, and the same call goes on from there.
        """
        from mpmkit.studies.running import Runner

        return Runner(self, Path(folder or f"{slug(self.name)}-study"), executor, quiet, jobs).run()

    def __repr__(self) -> str:
        axes = ", ".join(f"{axis.name} ({len(axis.values)})" for axis in self.axes) or "no axes"
        errors = ", ".join(m.label for m in self.errors) or "none"
        return f"<Study {self.name!r}: {axes}; {len(self.runs)} named runs; errors: {errors}>"


def slug(name: str) -> str:
    """A name as that of a file."""
    return re.sub(r"\W+", "-", name.lower()).strip("-") or "study"


def _name(scene: Any, base: scenes.Base) -> str:
    if base.function is not None:
        return base.function.rpartition(":")[2]
    return Path(scene).stem if isinstance(scene, (str, Path)) else "study"


def _run(table: Mapping[str, Any]) -> dict[str, Any]:
    if not isinstance(table, Mapping) or not isinstance(table.get("name"), str) or set(table) - {"name", "set"}:
        raise ParameterError(f"a run is a table {{ name = '...', set = {{...}} }}, got {table!r}")
    return {"name": table["name"], "set": {path: paths.table_of(value) for path, value in table.get("set", {}).items()}}


def _bytes(value: Any) -> int | None:
    if isinstance(value, str):
        found = re.fullmatch(r"\s*([\d.]+)\s*([kMGT]?i?B)\s*", value)
        if found:
            power = "kMGT".find(found[2][0]) + 1
            value = float(found[1]) * (1024 if "i" in found[2] else 1000) ** power
    number: float | None = convert(value, float | None, Spec("memory of a run", "B", gt=0.0), "Study.memory_budget")
    return None if number is None else int(number)
