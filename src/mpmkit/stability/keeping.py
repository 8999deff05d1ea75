"""Results kept cell by cell, so that an interrupted suite goes on where it was, and none that is out of date is taken."""

from __future__ import annotations

import hashlib
import json
import platform
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from mpmkit.stability.case import Case, Composition, Verdict
from mpmkit.stability.suite import verdict_data, verdict_of

FILE = "stability.jsonl"
ASIDE = ("cli", "stability", "studies")
"""Folders of mpmkit that have no part in a run; of the suite itself the files that judge count."""


class Kept:
    """The file of results in a folder; without a folder nothing is kept."""

    def __init__(self, folder: Path | None) -> None:
        self.path = folder / FILE if folder is not None else None
        self.verdicts: dict[str, Verdict] = {}
        if self.path is None:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        if self.path.exists():
            for line in self.path.read_text(encoding="utf-8").splitlines():
                self._take(line)

    def _take(self, line: str) -> None:
        """A line of an earlier run; one that an interruption has cut is measured again."""
        try:
            data = json.loads(line)
            self.verdicts[data["key"]] = verdict_of(data)
        except (ValueError, KeyError, TypeError):
            return

    def add(self, key: str, case: Case, composition: Composition, verdict: Verdict, seconds: float) -> None:
        """Append one result."""
        self.verdicts[key] = verdict
        if self.path is None:
            return
        row = {"key": key, "case": case.name, "composition": composition.label, "seconds": round(seconds, 2)} | verdict_data(verdict)
        with self.path.open("a+b") as file:
            if file.tell() and not _ends_whole(file):
                file.write(b"\n")
            file.write(json.dumps(row, ensure_ascii=False).encode() + b"\n")


def _ends_whole(file: Any) -> bool:
    file.seek(-1, 2)
    return bool(file.read(1) == b"\n")


def key(case: Case, composition: Composition, quick: bool) -> str:
    """Digest of everything a verdict depends on: sources of mpmkit, of the case and of the components, versions, and the choices."""
    h = hashlib.sha256(repr((case.name, composition, quick, _versions())).encode())
    h.update(_core())
    h.update(_module(case.measure.__module__))
    parts = [composition.shape, composition.integrator, getattr(composition.integrator, "transfer", None), composition.contact]
    for part in [*parts, composition.material, *composition.extra]:
        if part is not None:
            h.update(_module(type(part).__module__.split(".")[0]))
    return h.hexdigest()[:24]


def _versions() -> tuple[str, ...]:
    return (platform.python_version(), *(version(name) for name in ("numpy", "numba", "llvmlite")))


@cache
def _core() -> bytes:
    """Digest of mpmkit without what has no part in a run, of the bundled plugins that cases use, and of what judges."""
    import mpmkit

    home = Path(mpmkit.__file__).parent
    suite = [home / "stability" / name for name in ("case.py", "judge.py")] + sorted((home / "stability" / "cases").glob("_*.py"))
    read = (p for ending in ("py", "json") for p in sorted(home.rglob(f"*.{ending}")))
    files = [p for p in read if p.relative_to(home).parts[0] not in ASIDE]
    from mpmkit._core.registry import registry

    bundled = {e.component.__module__.split(".")[0] for e in registry().entries if e.distribution == "mpmkit"}
    return _digest([*files, *suite]) + b"".join(_module(name) for name in sorted(bundled))


@cache
def _module(name: str) -> bytes:
    """Digest of the files of a module, for a package of all its files."""
    module = sys.modules.get(name)
    place = getattr(module, "__file__", None)
    if place is None:
        return name.encode()
    path = Path(place)
    return _digest(sorted(path.parent.rglob("*.py")) if path.name == "__init__.py" else [path])


def _digest(files: list[Path]) -> bytes:
    h = hashlib.sha256()
    for path in files:
        h.update(path.name.encode())
        h.update(path.read_bytes())
    return h.digest()
