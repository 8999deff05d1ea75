"""Doing a study: errors side by side, then wall times one at a time; every result kept as it comes."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpmkit.errors import CompositionError, MpmkitError, ResultsError
from mpmkit.studies import child, cost, machine, measures, problem, scenes
from mpmkit.studies.limits import text
from mpmkit.studies.plan import Run
from mpmkit.studies.progress import Progress
from mpmkit.studies.results import FILE, Row, StudyResults
from mpmkit.studies.store import Store, key_of, versions_text

if TYPE_CHECKING:
    from mpmkit.studies.study import Study

POLL_SECONDS = 0.05
BUSY = 0.5
"""Processes that want to run, beside ours, from which on wall times are said to be doubtful."""
BESIDE = 0.5
"""Seconds that composing and the reference run take for each timed run, for the forecast."""
OF_RESULT = ("status", "reason", "errors", "values", "steps", "particles", "peak_bytes", "travel")


class Runner:
    """One study being done; see `Study.run` for the parameters."""

    def __init__(self, study: Study, folder: Path, executor: Any, quiet: bool, jobs: int | None) -> None:
        self.study, self.folder, self.quiet = study, folder, quiet
        self.executor, self.jobs = executor, jobs
        self.store = Store(folder)
        self.plan: list[Run] = []
        self.sources, self.machine = machine.sources(), machine.machine()
        self.machine_id = f"{self.machine['processor']}, {self.machine['usable cores']} cores, {self.machine['platform']}"
        self.keys: dict[str, str] = {}
        self.found: dict[str, dict[str, Any]] = {}
        self.notes: list[str] = []

    def run(self) -> StudyResults:
        """Everything that is not there yet."""
        self.plan = self.study.plan()
        planned = [run for run in self.plan if run.planned]
        if not planned:
            reasons = dict.fromkeys(f"  {run.label}: {run.reason}" for run in self.plan)
            raise CompositionError("all runs of the study are refused:\n" + "\n".join(list(reasons)[:10]))
        self.keys = {run.label: key_of(self.study.job(run)) for run in planned}
        versions = self.store.outdated(set(self.keys.values()), self.sources)
        if versions:
            self.notes.append(
                f"results of other versions or sources in {self.folder} do not count, and are done again ({'; '.join(versions)})"
            )
        complete = False
        try:
            self._errors(planned)
            self._times([run for run in planned if self.found[run.label]["status"] == "done"])
            complete = True
        finally:
            child.stop_all()
            results = StudyResults(self._rows(), self._meta(complete))
            results.save(self.folder / FILE)
        return results

    # --- errors -------------------------------------------------------------------------------------------------
    def _errors(self, planned: list[Run]) -> None:
        open_: list[Run] = []
        for run in planned:
            key = self.keys[run.label]
            kept = self.store.errors(key, self.sources)
            if kept is not None and (not self._compares() or kept["status"] != "done" or self.store.fields_path(key).is_file()):
                self.found[run.label] = self._within(kept)
            else:
                open_.append(run)
        weights = {run.label: max(run.particles or 1, 1) ** (1.0 + 1.0 / max(run.order - 1, 1)) for run in open_}
        with self._submitting() as submit, Progress("errors", sum(weights.values()), self.quiet) as progress:
            for remark in [*self.notes, *([f"{len(self.found)} runs are there already"] if self.found else [])]:
                progress.say(remark)
            open_.sort(key=lambda run: -weights[run.label])  # long ones first, so that none is left alone at the end
            waiting = {run.label: submit({**self.study.job(run), "task": "errors"}) for run in open_}
            try:
                while waiting:
                    for label in [label for label, future in waiting.items() if future.done()]:
                        self._keep(label, _result(waiting.pop(label)))
                        progress.advance(weights[label], f"{label}: {self.found[label]['status']}")
                    time.sleep(POLL_SECONDS if waiting else 0.0)
            except BaseException:
                for future in waiting.values():
                    future.cancel()
                raise

    def _within(self, kept: dict[str, Any]) -> dict[str, Any]:
        """A result from before, over budget if it needed more than is allowed now."""
        study, peak, spent = self.study, kept.get("peak_bytes") or 0, kept.get("first_seconds") or 0.0
        if kept["status"] == "done" and study.memory_budget is not None and peak > study.memory_budget:
            return {"status": "over budget", "reason": f"it needed {text(peak)} of memory, {text(study.memory_budget)} are allowed"}
        if kept["status"] == "done" and study.time_budget is not None and spent > study.time_budget:
            return {"status": "over budget", "reason": f"it took {spent:.3g} s of wall time, {study.time_budget:g} s are allowed"}
        return kept

    def _compares(self) -> bool:
        return any(isinstance(m, measures.Finest) for m in self.study.errors)

    def _keep(self, label: str, result: dict[str, Any]) -> None:
        fields = result.pop("fields", None)
        key = self.keys[label]
        if fields is not None:
            self.store.keep_fields(key, fields)
        self.found[label] = result
        self.store.append(
            {"kind": "errors", "key": key, "label": label, "sources": self.sources, "versions": versions_text(), "result": result}
        )

    @contextmanager
    def _submitting(self) -> Iterator[Any]:
        """How jobs are handed out: to the given executor, or to threads that have a child process each."""
        if self.executor is not None:
            pool = self.executor.get_executor() if hasattr(self.executor, "get_executor") else self.executor
            if not hasattr(pool, "submit"):
                raise CompositionError(f"executor must have submit(function, argument), as those of concurrent.futures; got {pool!r}")
            yield lambda job: pool.submit(child.run, job)
            return
        pool = ThreadPoolExecutor(self.jobs or min(os.cpu_count() or 1, 8))
        try:
            yield lambda job: pool.submit(child.run, job)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
            child.stop_all()  # also ends what their threads wait for

    # --- wall times ---------------------------------------------------------------------------------------------
    def _times(self, runs: list[Run]) -> None:
        missing = {run.label: self.study.repeat - len(self._known(run)) for run in runs}
        rounds = max(missing.values(), default=0)
        if rounds <= 0:
            return
        busy = machine.load()
        if busy is not None and busy > BUSY + (self.jobs or os.cpu_count() or 1):
            self.notes.append(f"this machine was busy when times were measured (load {busy:.1f}); compare with seconds / reference_seconds")
        expected = {run.label: BESIDE + (self.found[run.label].get("first_seconds") or 0.0) for run in runs}
        total = sum(expected[label] * max(n, 0) for label, n in missing.items()) or 1.0
        reference = cost.reference_job()
        worker = child.Child()
        try:
            with Progress("wall times", total, self.quiet) as progress:
                for k, run in cost.to_and_fro(runs, rounds):
                    if missing[run.label] <= k:
                        continue
                    beside = worker.ask(reference) if reference else {}
                    timed = worker.ask({**self.study.job(run), "task": "time"}, self.study.time_budget)
                    if timed["status"] != "done":
                        missing[run.label] = 0
                        self.found[run.label].setdefault("notes", []).append(f"not timed: {timed['reason']}".split("\n")[0])
                        continue
                    line: dict[str, Any] = {"kind": "time", "key": self.keys[run.label], "label": run.label, "sources": self.sources}
                    line |= {"versions": versions_text(), "machine": self.machine_id, "load": machine.load(), "when": time.time()}
                    self.store.append({**line, "seconds": timed["seconds"], "passes": timed["passes"], "reference": beside.get("seconds")})
                    progress.advance(expected[run.label], f"{run.label}: {timed['seconds']:.3g} s")
        finally:
            worker.stop()

    def _known(self, run: Run) -> list[dict[str, Any]]:
        return self.store.times(self.keys[run.label], self.sources, self.machine_id)

    # --- results ------------------------------------------------------------------------------------------------
    def _rows(self) -> list[Row]:
        rows = []
        for run in self.plan:
            row: Row = {
                "label": run.label,
                "composition": run.composition,
                "choices": run.choices,
                "labels": run.labels,
                "problem": run.problem,
            }
            row |= {"resolution": run.resolution, "particles": run.particles, "notes": list(run.notes)}
            if not run.planned:
                rows.append(row | {"status": run.status, "reason": run.reason})
                continue
            result = self.found.get(run.label)
            if result is None:
                continue  # interrupted before
            row |= {k: result[k] for k in OF_RESULT if result.get(k) is not None}
            row["notes"] = list(dict.fromkeys([*run.notes, *result.get("notes", [])]))
            if result["status"] == "done":
                row |= cost.summary(self._known(run), row.get("particles"), row.get("steps"))
            rows.append(row)
        if self._compares():
            self._compare(rows)
        return rows

    def _compare(self, rows: list[Row]) -> None:
        """Errors against the finest run of each composition, or a named one."""
        import numpy as np

        done = {row["label"]: row for row in rows if row["status"] == "done"}
        fields: dict[str, Any] = {}
        for k, measure in enumerate(self.study.errors):
            if not isinstance(measure, measures.Finest):
                continue
            for label, row in done.items():
                same = [r for r in done.values() if r["composition"] == row["composition"] and r["resolution"] is not None]
                fine = measure.reference or min(same, key=lambda r: r["resolution"], default=row)["label"]
                if fine == label:
                    continue
                if fine not in done:
                    row["notes"].append(f"{measure.label}: the run {fine!r} that it is compared with did not end well")
                    continue
                for one in (label, fine):
                    if one not in fields:
                        with np.load(self.store.fields_path(self.keys[one])) as found:
                            fields[one] = dict(found)
                mine, right = ({n[len(f"{k}/") :]: a for n, a in fields[one].items() if n.startswith(f"{k}/")} for one in (label, fine))
                try:
                    row["errors"] = {**row["errors"], measure.label: measure.compare(mine, right)}
                except MpmkitError as error:
                    row["notes"].append(str(error))

    def _meta(self, complete: bool) -> dict[str, Any]:
        study = self.study
        axis = next((a for a in study.axes if a.name == study.resolution), None)
        sizes = {run.h for run in self.plan if run.planned}
        references = [line["reference"] for line in self.store.lines if line.get("reference") and line.get("machine") == self.machine_id]
        return {
            "name": study.name,
            "errors": [{"label": m.label, "unit": getattr(m, "unit", "1")} for m in study.errors],
            "measures": [m.plain() for m in study.errors],
            "resolution": {"name": "cell size" if len(sizes) > 1 or axis is None else axis.name, "unit": "m" if len(sizes) > 1 else "1"},
            "axes": {a.name: list(a.labels) for a in study.axes},
            "startup": study.startup,
            "threads": study.threads,
            "budgets": {"seconds": study.time_budget, "bytes": study.memory_budget},
            "machine": self.machine,
            "versions": machine.versions(),
            "sources": self.sources,
            "scene": study.base.text,
            "compositions": self._compositions(),
            "reference": {"label": "400 particles, 1,000 steps", "seconds": references},
            "when": time.strftime("%Y-%m-%d %H:%M:%S %z"),
            "notes": self.notes,
            "complete": complete,
        }

    def _compositions(self) -> dict[str, Any]:
        """What problem each composition solves, and with which components, for those who look for advice."""
        found: dict[str, Any] = {}
        for run in self.plan:
            if run.planned and run.composition not in found:
                sim = scenes.build(self.study.job(run))
                found[run.composition] = {"problem": problem.describe(sim), "components": problem.components(sim)}
        return found


def _result(future: Any) -> dict[str, Any]:
    """What became of a job; a lost worker is a failed run."""
    try:
        return dict(future.result())
    except ResultsError:
        raise
    except Exception as error:  # noqa: BLE001  (executors raise their own errors when workers are lost)
        return {"status": "failed", "reason": f"the worker was lost: {type(error).__name__}: {error}"}
