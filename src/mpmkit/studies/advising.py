"""Advice for one scene: it and what published studies recommend step for a moment on this machine."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import attrs

from mpmkit.errors import CompositionError, ParameterError, SceneError, did_you_mean
from mpmkit.studies import child, cost, problem, published, scenes
from mpmkit.studies.advice import ALIKE, APPLIES, FAIRLY, UNSURE, Advice, Option
from mpmkit.studies.axes import short
from mpmkit.studies.published import BEYOND, Known
from mpmkit.studies.sentences import accuracy
from mpmkit.studies.study import Study

TRIED = 3
"""Most compositions that are tried on this machine beside the scene's own."""
SCOUT_SECONDS = 2.0
"""How long the scene itself steps."""
ALIGNED = 1e-6
"""Cells by which a body may miss a whole number of them."""


def advise(
    scene: Any,
    error: float | str,
    *,
    field: str | None = None,
    until: float | None = None,
    threads: int = 1,
    studies: Iterable[str | os.PathLike[str]] = (),
    quiet: bool = True,
) -> Advice:
    """Predict the time of a scene on this machine, and name a composition that reaches an error in less.

    The scene steps for a moment in a process of its own, and so do the compositions that a published study recommends for this error;
    the step's time and length then give the time of the whole run.

    Parameters
    ----------
    scene : path, Simulation or dict
        What a study takes, except functions.
    error : float or str
        Wanted relative error: 0.01 or "1%".
    field : str, optional
        Only errors of this field ("stress", "u", "v").
    until : float, optional
        End of the run [s], if not that of the scene.
    threads : int
        Threads that step.
    studies : iterable of path
        Further studies: files of `StudyResults.save`, folders of studies, or folders of such files.
    quiet : bool
        No progress.

    Raises
    ------
    ParameterError, SceneError, CompositionError
        If the scene or the error cannot be, or the scene cannot run.
    ResultsError
        If a further study cannot be read.
    """
    wanted = accuracy(error)
    every = published.known(published.load(studies))
    if field is not None:
        fields = sorted({k.measure.split(",")[0].split(".")[0] for k in every})
        if field.split(".")[0] not in fields:
            raise ParameterError(
                f"no published study has errors of {field!r}{did_you_mean(field, fields)} (there are {', '.join(fields) or 'none'})"
            )
        every = [k for k in every if k.measure.startswith(field)]
    study = Study(scene, repeat=1, until=until, threads=threads, name=_name(scene), resolution=None)
    if study.base.data is None:
        raise SceneError("advice needs a scene file or a simulation that can be written as one; a function cannot be recomposed")
    (run,) = study.plan()
    if not run.planned:
        raise CompositionError(f"the scene cannot run: {run.reason}")
    sim = scenes.build(study.job(run))
    own = problem.components(sim) or {}
    try:
        return _Adviser(study, run, sim, own, wanted).advice(every, quiet)
    finally:
        child.stop_all()


def _name(scene: Any) -> str:
    return Path(scene).name if isinstance(scene, (str, Path)) else "the scene"


class _Adviser:
    """One scene."""

    def __init__(self, study: Study, run: Any, sim: Any, own: dict[str, Any], wanted: float) -> None:
        self.study, self.run, self.sim, self.own, self.wanted = study, run, sim, own, wanted
        self.facts = problem.describe(sim)
        self.cells = self.facts["length"] / sim.grid.h
        self.longer = 1.0
        self.travel: float | None = None

    def advice(self, every: list[Known], quiet: bool) -> Advice:
        """The whole answer."""
        here, done = self.scout()
        answer = Advice(self.study.name, self.wanted, here, done, self.travel or 0.0)
        scored = [(*problem.alike(self.facts, k.problem, self.travel, k.travel), k) for k in every]
        if not scored:
            return answer
        score, same, differs, first = max(scored, key=lambda s: s[0])
        answer = attrs.evolve(answer, likeness=score, nearest=first.study, same=same, differs=differs)
        if score < APPLIES or not here.steps:
            return answer
        mine = [(s, k) for s, _, _, k in scored if s >= APPLIES and k.study == first.study and k.measure == first.measure]
        witness = self._own(mine)
        if witness is not None and (found := witness.error_at(self.cells)) is not None:
            here = attrs.evolve(here, error=found[0], origin=found[1])
        options, far = self.options(mine, quiet)
        smallest = min(min(k.errors) for _, k in mine)
        sure = FAIRLY if score >= ALIKE and not far else UNSURE
        return attrs.evolve(answer, here=here, study=first.study, measure=first.measure, options=options, smallest=smallest, sure=sure)

    def scout(self) -> tuple[Option, float]:
        """The scene itself for a moment: its time, how much its steps shorten, how far its particles move."""
        found = child.run({**self.study.job(self.run), "task": "calibrate", "seconds": SCOUT_SECONDS})
        label, h, until = _label(self.own), self.sim.grid.h, float(self.run.until or 0.0)
        if found["status"] != "done":
            note = f"it does not step: {found['status']}, {found['reason']}".split("\n")[0]
            return Option(label, {}, h, None, "", None, None, self.run.particles, self.run.bytes, note), 0.0
        share = min(found["t"] / until, 1.0)
        steps = max(1, round(found["steps"] / share)) if share < 1.0 else found["steps"]
        self.longer = steps / max(until / found["dt"], 1.0)
        self.travel = found["travel"] + found["speed"] * max(until - found["t"], 0.0)
        return Option(label, {}, h, None, "", steps * found["seconds_per_step"], steps, found["particles"], self.run.bytes), share

    def _own(self, mine: list[tuple[float, Known]]) -> Known | None:
        """The composition of the scene in the study."""
        equal = [(s, k) for s, k in mine if problem.same_components(self.own, k.components)]
        return max(equal, key=lambda pair: pair[0])[1] if equal else None

    def options(self, mine: list[tuple[float, Known]], quiet: bool) -> tuple[list[Option], bool]:
        """Compositions that reach the error, tried on this machine; whether the fastest of them goes beyond what was measured."""
        chosen: dict[str, tuple[float, Known]] = {}
        for score, one in mine:
            text = problem.key(one.components)
            old = chosen.get(text)
            # of several problems with the same components the most alike counts; of equal ones the worse
            if old is None or (score, max(one.errors)) > (old[0], max(old[1].errors)):
                chosen[text] = (score, one)
        reaching = []
        for _, one in chosen.values():
            if (need := one.cells_for(self.wanted)) is not None:
                work = need[0] ** (self.facts["dim"] + 1) * (one.nanoseconds or 1.0)
                reaching.append((work, need, one))
        reaching.sort(key=lambda item: item[0])
        runs: list[dict[str, Any]] = []
        options: list[Option] = []
        for _, (cells, origin), one in reaching[:TRIED]:
            spacing, h = self.spacing(cells)
            choices = self._choices(one)
            expected = one.error_at(self.facts["length"] / h)
            error, origin = (expected[0], BEYOND if BEYOND in (origin, expected[1]) else expected[1]) if expected else (self.wanted, origin)
            options.append(
                Option(_label({**self.own, **one.components}), {**choices, "grid.spacing": spacing}, h, error, origin, None, None, None)
            )
            runs.append({"name": f"option {len(runs)}", "set": options[-1].choices})
        if not runs:
            return [], False
        trial = Study(self.study.base.data, runs=runs, repeat=1, until=self.run.until, threads=self.study.threads, folder=self.study.folder)
        rows = cost.predict(trial, trial.plan(), quiet=quiet)
        options = [self._priced(option, row) for option, row in zip(options, rows, strict=True)]
        options.sort(key=lambda o: math.inf if o.seconds is None else o.seconds)
        return options, options[0].origin == BEYOND

    def _priced(self, option: Option, row: dict[str, Any]) -> Option:
        if row["seconds"] is None:
            note = f"{row['status']}: {row['reason']}" if row["status"] != "planned" else "; ".join(row["notes"]) or "its time is not known"
            return attrs.evolve(option, particles=row["particles"], bytes=row["bytes"], note=note.split("\n")[0])
        steps = max(1, round(row["steps"] * self.longer))
        return attrs.evolve(option, seconds=row["seconds"] * self.longer, steps=steps, particles=row["particles"], bytes=row["bytes"])

    def _choices(self, one: Known) -> dict[str, Any]:
        """What of the study's components is different here; particles per cell mean the same only in the same dimension."""
        same_dim = one.problem["dim"] == self.facts["dim"]
        kept = {k: v for k, v in one.components.items() if same_dim or not k.endswith("particles_per_cell")}
        return {k: v for k, v in kept.items() if problem.key(self.own.get(k)) != problem.key(v)}

    def spacing(self, cells: float) -> tuple[Any, float]:
        """Largest spacing with at least so many cells along the largest body which divides the domain, and the body if it was divided."""
        grid, counts = self.sim.grid, self.sim.grid.cells
        common = math.gcd(*counts)
        least = max(1, math.ceil(cells / self.cells * common * (1.0 - 1e-9)))
        aligned = abs(self.cells - round(self.cells)) < ALIGNED
        for j in range(least, 2 * least + common + 1):
            n = self.cells * j / common
            if min(counts) * j >= 2 * common and (not aligned or abs(n - round(n)) < ALIGNED * n):
                break
        else:
            j = least
        sizes = [(u - lo) / (c // common * j) for u, lo, c in zip(grid.upper, grid.lower, counts, strict=True)]
        equal = max(sizes) - min(sizes) < 1e-9 * max(sizes)
        return (sizes[0] if equal else sizes), min(sizes)


def _label(components: dict[str, Any]) -> str:
    """Components in a few words: "Linear, MUSL with FLIP, 4 particles in a cell"."""
    if "discretization" in components and "shape" not in components:
        return short(components["discretization"], kind_only=True)
    shape = short(components.get("shape", {}), kind_only=True) or "the scene"
    label = f"{shape}, {components.get('integrator', '')}".rstrip(", ")
    if "integrator.transfer" in components:
        label += f" with {short(components['integrator.transfer'], kind_only=True)}"
    count = components.get("bodies.*.particles_per_cell")
    return label + (f", {count} particle{'s' if count > 1 else ''} in a cell" if count else "")
