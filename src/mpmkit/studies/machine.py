"""The machine, the versions, and the sources that results depend on."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import platform
import sys
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import mpmkit
from mpmkit._core.registry import registry

PRESENTATION = ("mpmkit/cli/", "mpmkit/_core/drawing/", "mpmkit/views", "mpmkit/testing/", "mpmkit/stability/", "mpmkit/explanation")
"""Sources that no number depends on."""
STUDIES = (
    "axes", "fit", "sentences", "numbers", "pictures", "html", "advice", "advising", "published", "problem", "results", "running", "study",
    "plan", "cost", "progress",
)  # fmt: skip


def machine() -> dict[str, Any]:
    """Processor, cores, system, and how busy it is."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "usable cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "platform": platform.platform(),
        "memory_bytes": _memory(),
    }


def load() -> float | None:
    """Mean number of processes that wanted to run in the last minute."""
    try:
        return os.getloadavg()[0]
    except (OSError, AttributeError):
        return None


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def _memory() -> int | None:
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def versions() -> dict[str, str]:
    """mpmkit, Python, the packages that compute, and plugins."""
    found = {"mpmkit": mpmkit.__version__, "python": platform.python_version()}
    for name in ("numpy", "numba", "llvmlite", "scipy"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found | {e.distribution: e.version for e in registry().entries if e.distribution != "mpmkit"}


@cache
def sources() -> str:
    """Digest of versions and of all sources that numbers depend on, plugins included."""
    h = hashlib.sha256(repr(sorted(versions().items())).encode())
    h.update(os.environ.get("NUMBA_DISABLE_JIT", "").encode())
    packages = {"mpmkit", *(e.component.__module__.split(".")[0] for e in registry().entries)}
    for package in sorted(packages):
        for path in _files(package):
            name = f"{package}/{path[1]}"
            if name.startswith(PRESENTATION) or (name.startswith("mpmkit/studies/") and path[0].stem in STUDIES):
                continue
            h.update(name.encode())
            h.update(path[0].read_bytes())
    return h.hexdigest()[:16]


def _files(package: str) -> list[tuple[Path, str]]:
    spec = sys.modules[package].__spec__ if package in sys.modules else importlib.util.find_spec(package)
    if spec is None or not spec.origin:
        return []
    origin = Path(spec.origin)
    if origin.name != "__init__.py":
        return [(origin, origin.name)]
    return [(p, p.relative_to(origin.parent).as_posix()) for p in sorted(origin.parent.rglob("*.py"))]
