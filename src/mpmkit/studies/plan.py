"""From axes to runs: every combination composed on paper, refused ones with the reason."""

from __future__ import annotations

import copy
import itertools
import warnings
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from mpmkit.errors import MpmkitError, ParameterError, did_you_mean
from mpmkit.studies import axes as axes_of
from mpmkit.studies import measures, paths, samples, scenes, solutions

if TYPE_CHECKING:
    from mpmkit.studies.study import Study

SMALL = 200_000
"""Particles up to which measures are tried out before any run."""


@attrs.define
class Run:
    """One run of a study, before it is done.

    Attributes
    ----------
    label, composition : str
        Choices of all axes in short; the same without the resolution.
    choices, labels : dict
        Axis or path -> value; -> short text.
    problem : str
        Those choices that make another problem, in short.
    data : dict, optional
        The scene's plain data; None if a function makes it.
    status, reason : str
        "planned", "refused" or "failed" with the reason.
    resolution : float
        Smaller is finer; the cell size [m] unless another axis refines.
    particles : int
        Estimated.
    bytes : int
        Memory for particles and nodes, estimated.
    h, cfl, dt, until : float
        Cell size, Courant number, fixed time step if there is one, end of the run.
    """

    label: str
    composition: str
    choices: dict[str, Any]
    labels: dict[str, str]
    problem: str = ""
    data: dict[str, Any] | None = None
    arguments: dict[str, Any] = attrs.Factory(dict)
    status: str = "planned"
    reason: str = ""
    notes: list[str] = attrs.Factory(list)
    resolution: float | None = None
    particles: int | None = None
    bytes: int | None = None
    h: float = 0.0
    cfl: float = 1.0
    dt: float | None = None
    until: float | None = None
    order: int = 2

    @property
    def planned(self) -> bool:
        """Whether it is going to be run."""
        return self.status == "planned"


def runs(study: Study) -> list[Run]:
    """All runs of a study: the product of its axes, then the named ones.

    Raises
    ------
    ParameterError
        If a value of an axis fits in no combination because the scene has no such field, a label appears twice, or a measure cannot
        be applied.
    """
    found = _product(study) + [_named(study, table) for table in study.runs]
    labels = [run.label for run in found]
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise ParameterError(f"two runs are called {twice[0]!r}; give each its own name")
    for run in found:
        if run.planned:
            _compose(study, run)
    _resolutions(study, found)
    _try_measures(study, found)
    return found


def _product(study: Study) -> list[Run]:
    found: list[Run] = []
    wrong: dict[tuple[str, int], list[str]] = {}
    for numbers in axes_of.product(study.axes) if study.axes or not study.runs else ():
        values = [axis.values[k] for axis, k in zip(study.axes, numbers, strict=True)]
        labels = {axis.name: axis.labels[k] for axis, k in zip(study.axes, numbers, strict=True)}
        told = {axis.name: axes_of.tell(axis, k) for axis, k in zip(study.axes, numbers, strict=True)}
        choices = {axis.name: v[0] if len(v) == 1 else list(v) for axis, v in zip(study.axes, values, strict=True)}
        given = {path: v for axis, value in zip(study.axes, values, strict=True) for path, v in zip(axis.paths, value, strict=True)}
        run = Run(
            label=", ".join(told.values()) or "base scene",
            composition=", ".join(t for name, t in told.items() if name != study.resolution) or study.name,
            choices=choices,
            labels=labels,
            problem=", ".join(told[name] for name in study.problems),
        )
        culprit = _fill(study, run, given)
        for axis, k in zip(study.axes, numbers, strict=True):
            failed = run.reason if culprit in axis.paths else ""
            wrong.setdefault((axis.name, k), []).append(failed)
        found.append(run)
    for reasons in wrong.values():
        if all(reasons):  # not this combination but the axis itself is wrong
            raise ParameterError(reasons[0])
    return found


def _named(study: Study, table: dict[str, Any]) -> Run:
    given = table.get("set", {})
    labels = {path: axes_of.short(value, kind_only=True) for path, value in given.items()}
    refining = next((axis.paths for axis in study.axes if axis.name == study.resolution), (study.resolution,))
    others = [label for path, label in labels.items() if path not in refining]
    run = Run(table["name"], ", ".join(others) or table["name"], dict(given), labels)
    if _fill(study, run, given):
        raise ParameterError(f"run {run.label!r}: {run.reason}")
    return run


def _fill(study: Study, run: Run, given: dict[str, Any]) -> str:
    """Put the choices into the scene; the path that it has no place for, or nothing."""
    base = study.base
    if base.data is None:
        run.arguments = given
        missing = [name for name in base.required if name not in given]
        if missing:
            raise ParameterError(f"{base.function} needs {', '.join(missing)}; make an axis of each, if only with one value")
        return ""
    data = copy.deepcopy(base.data)
    for path in sorted(given, key=lambda p: len(paths.split(p))):  # whole components before their parameters
        try:
            paths.put(data, path, copy.deepcopy(given[path]))
        except MpmkitError as error:
            run.status, run.reason = "refused", str(error).split("\n")[0]
            return path
    run.data = data
    return ""


def _compose(study: Study, run: Run) -> None:
    """Check the composition and estimate its size, without sampling or compiling anything."""
    from mpmkit._core.composing import contract
    from mpmkit._core.composing.composition import collect
    from mpmkit._core.composing.plan import make_plan
    from mpmkit._core.running import memory

    given: float | None = None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            sim = scenes.build(study.job(run))
        composition = collect(sim)
        run.notes += contract.check(composition)
        made = make_plan(composition)
        stepper = sim.integrator or sim.discretization
        if composition.stored_operator:
            run.particles, run.bytes = None, None
        else:
            needed, run.particles = memory.needed_bytes(made)
            run.bytes = sum(needed.values())
        run.h, run.cfl, run.dt = sim.grid.h, float(getattr(stepper, "cfl", 1.0)), getattr(stepper, "dt", None)
        run.order = sim.grid.dim + 1
        given = sim.until
    except MpmkitError as error:
        run.status, run.reason = "refused", "; ".join(getattr(error, "mistakes", ())) or str(error)
    except Exception as error:  # noqa: BLE001  (a function of the user may raise anything; it is one point of many)
        run.status, run.reason = "failed", f"{type(error).__name__}: {error}"
    if run.planned:
        run.until = _until(study, given)
    if run.planned and study.memory_budget is not None and (run.bytes or 0) > study.memory_budget:
        run.status = "over budget"
        run.reason = f"it needs about {memory.text(run.bytes or 0)} of memory, {memory.text(study.memory_budget)} are allowed"


def _until(study: Study, given: float | None) -> float:
    asked = [t for m in study.errors if isinstance(m.times, tuple) for t in m.times]
    until = study.until if study.until is not None else given if given is not None else max(asked, default=None)
    if until is None:
        raise ParameterError("the scene does not say how long it runs; give until in the scene or in the study")
    if asked and max(asked) > until * (1.0 + 1e-12):
        raise ParameterError(f"errors are asked for at {max(asked):g} s, but the run ends at {until:g} s")
    return until


def _resolutions(study: Study, found: list[Run]) -> None:
    """Cell size, or the value of the axis that refines if that leaves the cells as they are."""
    sizes = {run.h for run in found if run.planned}
    axis = next((a for a in study.axes if a.name == study.resolution), None)
    for run in found:
        run.resolution = run.h or None
        if not run.planned or axis is None or len(sizes) > 1 or axis.numbers is None or axis.name not in run.choices:
            continue
        value = run.choices[axis.name]
        number = float(value[0] if isinstance(value, list) else value)
        per_cell = axis.paths[0].endswith("particles_per_cell")
        run.resolution = run.h / number ** (1.0 / max(run.order - 1, 1)) if per_cell else number


def _try_measures(study: Study, found: list[Run]) -> None:
    """Ask the exact solutions for values at the particles of the smallest run, before anything runs."""
    exact = [m for m in study.errors if isinstance(m, measures.Exact)]
    planned = sorted((run for run in found if run.planned and run.particles), key=lambda run: run.particles or 0)
    if not exact or not planned or (planned[0].particles or 0) > SMALL:
        return
    job = study.job(planned[0])
    sim = scenes.build(job)
    for measure in exact:
        names = [sim.body_name(b) for b in sim.bodies]
        for name in measure.bodies:
            if name not in names:
                raise ParameterError(
                    f"error {measure.label!r}: no body is named {name!r}{did_you_mean(name, names)}; bodies: {', '.join(names)}"
                )
        solution, _ = solutions.build(measure.solution, sim, job["choices"], job["folder"], measure.bodies)
        evaluator = solutions.Evaluator(solution, measure.origin, measure.axis, sim.grid.space)
        base, component = samples.parse(measure.field)
        for body in sim.bodies:
            if measure.bodies and sim.body_name(body) not in measure.bodies:
                continue
            X = np.asarray(body.sample(sim.grid).x, float)
            try:
                evaluator(base, component, X[measure.inside(X)], 0.0)
            except Exception as error:
                raise ParameterError(
                    f"error {measure.label!r}: {type(solution).__name__} has no exact values for body {sim.body_name(body)!r} of this "
                    f"scene: {error}"
                ) from error


def grouped(found: list[Run]) -> dict[str, list[Run]]:
    """Planned runs by composition, coarse to fine."""
    key = lambda run: run.composition  # noqa: E731
    planned = sorted((r for r in found if r.planned), key=key)
    return {name: sorted(group, key=lambda r: -(r.resolution or 0.0)) for name, group in itertools.groupby(planned, key)}
