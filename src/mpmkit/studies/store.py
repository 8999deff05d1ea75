"""Results of single runs on disk, a line each as they come: nothing that was done is lost or done twice."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from mpmkit.errors import ResultsError
from mpmkit.studies import callables, machine

LINES = "results.jsonl"
AGAIN = ("failed", "over budget")
"""What is tried again next time: the reason may have lain outside the run."""


class Store:
    """The folder of a study.

    Parameters
    ----------
    folder : Path
        Made if it is not there.

    Raises
    ------
    ResultsError
        If it cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.path = folder / LINES
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with open(self.path, "ab"):
                pass
        except OSError as error:
            raise ResultsError(f"cannot write to the folder of the study, {folder}: {error.strerror}; choose another one") from None
        self.lines = self._read()

    def _read(self) -> list[dict[str, Any]]:
        found = []
        text = self.path.read_text(encoding="utf-8", errors="replace")
        for line in text.splitlines():
            try:
                found.append(json.loads(line))
            except json.JSONDecodeError:
                continue  # the last line of a process that was killed while it wrote
        if text and not text.endswith("\n"):
            with open(self.path, "a", encoding="utf-8") as file:
                file.write("\n")
        return [line for line in found if isinstance(line, dict)]

    def append(self, line: dict[str, Any]) -> None:
        """Keep one result, on disk when this returns."""
        self.lines.append(line)
        try:
            with open(self.path, "a", encoding="utf-8") as file:
                file.write(json.dumps(line) + "\n")
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise ResultsError(f"cannot write {self.path}: {error.strerror}; what was done before is kept") from None

    def errors(self, key: str, sources: str) -> dict[str, Any] | None:
        """The result of a run, if it is there, and was not one that is tried again."""
        for line in reversed(self.lines):
            if line.get("kind") == "errors" and line.get("key") == key and line.get("sources") == sources:
                result: dict[str, Any] = line["result"]
                return None if result["status"] in AGAIN else result
        return None

    def times(self, key: str, sources: str, machine_id: str) -> list[dict[str, Any]]:
        """Wall times of a run on this machine."""
        wanted = ("time", key, sources, machine_id)
        return [line for line in self.lines if (line.get("kind"), line.get("key"), line.get("sources"), line.get("machine")) == wanted]

    def outdated(self, keys: set[str], sources: str) -> list[str]:
        """Versions that wrote results of these runs which no longer count."""
        others = [line for line in self.lines if line.get("key") in keys and line.get("sources") != sources]
        return sorted({str(line.get("versions")) for line in others})

    def fields_path(self, key: str) -> Path:
        """Where the fields of a run are that others are compared with."""
        return self.folder / "fields" / f"{key}.npz"

    def keep_fields(self, key: str, fields: dict[str, Any]) -> None:
        """Write them."""
        import numpy as np

        path = self.fields_path(key)
        path.parent.mkdir(exist_ok=True)
        temporary = path.with_suffix(".tmp.npz")
        np.savez_compressed(temporary, **fields)
        os.replace(temporary, path)


def key_of(job: dict[str, Any]) -> str:
    """Digest of everything in a job that decides on its numbers; budgets do not."""
    told = {k: v for k, v in job.items() if k not in ("time_budget", "memory_budget", "task", "folder", "choices" if job["data"] else "")}
    names = [job["function"], *(v for m in job["measures"] for v in m.values())]
    told["files"] = {name: callables.source_digest(name, job["folder"]) for name in names if callables.is_name(name)}
    return hashlib.sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()[:20]


def versions_text() -> str:
    """Versions in one line."""
    return ", ".join(f"{name} {number}" for name, number in machine.versions().items())
