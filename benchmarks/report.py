"""Results as JSON files; from them tables and pictures, and so every number of the docs page."""

from __future__ import annotations

import datetime as dt
import json
import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "benchmarks/results"
PAGE = ROOT / "docs/performance-tables.md"
IMAGES = ROOT / "docs/images"
PACKAGES = ("mpmkit", "numpy", "numba", "llvmlite", "taichi", "warp-lang", "jax")


def save(folder: Path, part: str, result: Any, quick: bool) -> None:
    """Write one part with the machine it was measured on."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{part}.json").write_text(json.dumps({"about": about(quick), "result": result}, indent=1) + "\n", encoding="utf-8")


def about(quick: bool) -> dict[str, Any]:
    """Machine, versions and date."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    when = dt.datetime.now(tz=dt.UTC).date().isoformat()
    return {
        "date": when,
        "quick": quick,
        "processor": processor(),
        "cores": len(os.sched_getaffinity(0)),
        "python": platform.python_version(),
        "versions": found,
    }


def processor() -> str:
    """The processor's name and its widest vectors."""
    text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    name = next((line.split(":", 1)[1].strip() for line in text.splitlines() if line.startswith("model name")), platform.processor())
    flags = next((line for line in text.splitlines() if line.startswith("flags")), "").split()
    return f"{name}, {'AVX-512' if 'avx512f' in flags else 'AVX2' if 'avx2' in flags else 'no AVX2'}"


def load(folder: Path) -> dict[str, Any]:
    """All parts that have been measured."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}


def main(folder: Path = RESULTS) -> None:
    """Write tables and pictures: those of the docs from the kept results, beside the JSON files from any other folder."""
    parts = load(folder)
    if not parts:
        return
    from benchmarks import pictures
    from benchmarks.tables import tables

    kept = folder.resolve() == RESULTS.resolve()
    page, images = (PAGE, IMAGES) if kept else (folder / "tables.md", folder)
    page.write_text(tables(parts), encoding="utf-8")
    drawn = pictures.main({name: part["result"] for name, part in parts.items()}, images)
    print("written:", *(str(path) for path in (page, *drawn)), sep="\n  ")
