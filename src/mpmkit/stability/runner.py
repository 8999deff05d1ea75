"""Runs cases under compositions, in child processes, going on where an interrupted run was."""

from __future__ import annotations

import datetime as dt
import os
import platform
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from os import PathLike
from pathlib import Path
from typing import Any

from mpmkit.errors import ParameterError, did_you_mean
from mpmkit.stability.case import Case, Composition, Verdict
from mpmkit.stability.suite import Judged, Suite

TIMEOUT = 600.0
"""Wall time of one cell [s] unless another is given."""


def run(
    cases: Iterable[str | Case] | None = None,
    compositions: Iterable[Composition] | None = None,
    *,
    quick: bool = False,
    plugin: str | None = None,
    every: bool = False,
    jobs: int | None = None,
    timeout: float = TIMEOUT,
    folder: str | PathLike[str] | None = None,
    quiet: bool = True,
) -> Suite:
    """Run hard cases.

    Parameters
    ----------
    cases : iterable of str or Case, optional
        By name, or cases of your own (which must be found by their module and name, as pickle finds functions); all that are bundled if
        not given.
    compositions : iterable of Composition, optional
        If not given those that are published, with `quick` a few, with `every` the full product, with `plugin` those its components
        take part in.
    quick : bool
        Shorter or coarser runs with the same criteria.
    plugin : str, optional
        A plugin, distribution or component, as for ``mpmkit check``.
    every : bool
        The full product.
    jobs : int, optional
        Child processes; one for each core if not given. 0 runs in this process, where a crash cannot be survived.
    timeout : float
        Wall time of one cell [s].
    folder : path, optional
        Where results are kept as they come; those of an earlier run that are still valid are taken from there.
    quiet : bool
        No progress.

    Returns
    -------
    Suite
        Verdicts, and what explains them.

    Raises
    ------
    ParameterError
        If no case has a name, or a number is out of range.
    PluginError
        If `plugin` is no plugin, distribution or component, or none of its components belongs to an axis.
    """
    from mpmkit.stability import compositions as made
    from mpmkit.stability.keeping import Kept, key
    from mpmkit.stability.pool import judged
    from mpmkit.stability.progress import Progress

    jobs = len(os.sched_getaffinity(0)) if jobs is None else jobs
    if jobs < 0:
        raise ParameterError(f"jobs must be at least 0, got {jobs}")
    if not timeout > 0.0:
        raise ParameterError(f"timeout must be greater than 0 s, got {timeout:g}")
    rows = chosen(cases)
    if compositions is not None:
        columns = made.unique(compositions)
    elif plugin is not None:
        columns = made.of_plugin(plugin, every=every, few=quick)
    else:
        columns = made.quick() if quick else made.everything() if every else made.published()
    kept = Kept(Path(folder) if folder is not None else None)
    places = _places(rows, columns)
    keys = [key(case, composition, quick) for case, _, composition in places]
    verdicts: dict[int, Verdict] = {k: kept.verdicts[name] for k, name in enumerate(keys) if name in kept.verdicts}
    taken = len(verdicts)
    seconds = dict.fromkeys(range(len(places)), 0.0)
    # by composition: neighbouring cells then differ in what they compile, and slow cases are spread over the workers
    todo = sorted((k for k in range(len(places)) if k not in verdicts), key=lambda k: places[k][1])
    with Progress(len(places), taken, quiet=quiet) as progress:
        for number, verdict, took in judged([(places[k][0], places[k][2], quick) for k in todo], jobs, timeout):
            k = todo[number]
            case, _, composition = places[k]
            verdicts[k], seconds[k] = verdict, took
            kept.add(keys[k], case, composition, verdict, took)
            progress.tell(case, composition, verdict, took)
    cells = [Judged(case, column, seen, verdicts[k], seconds[k]) for k, (case, column, seen) in enumerate(places)]
    return Suite(tuple(rows), tuple(columns), tuple(cells), quick, about())


def chosen(cases: Iterable[str | Case] | None) -> list[Case]:
    """Cases by name.

    Raises
    ------
    ParameterError
        If no case has a name; tells the nearest.
    """
    from mpmkit.stability.cases import cases as bundled

    known = bundled()
    if cases is None:
        return list(known.values())
    if isinstance(cases, str):
        cases = (cases,)
    out = []
    for one in cases:
        if isinstance(one, str) and one not in known:
            raise ParameterError(f"no hard case is named {one!r}{did_you_mean(one, known)}\n  cases: {', '.join(sorted(known))}")
        out.append(known[one] if isinstance(one, str) else one)
    return list({case.name: case for case in out}.values())


def _places(rows: Sequence[Case], columns: Sequence[Composition]) -> list[tuple[Case, int, Composition]]:
    """The cells: each case with each composition that it says something about, as the case sees it, once."""
    from mpmkit.stability.compositions import applied

    out = []
    for case in rows:
        seen: list[Composition] = []
        for number, column in enumerate(columns):
            one = applied(case, column)
            if one is not None and one not in seen:
                seen.append(one)
                out.append((case, number, one))
    return out


def about() -> dict[str, Any]:
    """Date, machine and versions."""
    when = dt.datetime.now(tz=dt.UTC).date().isoformat()
    versions = {name: version(name) for name in ("mpmkit", "numpy", "numba", "llvmlite")}
    return {"date": when, "machine": platform.machine(), "python": platform.python_version(), "versions": versions}
