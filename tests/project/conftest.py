"""Where the project's files are; these tests look at the checkout itself."""

from __future__ import annotations

import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def root() -> Path:
    """The top of the checkout."""
    return ROOT


@pytest.fixture(scope="session")
def pyproject():
    """The content of pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def files() -> list[Path]:
    """The project's own text files: what git knows, or in an unpacked copy all but hidden and built folders."""
    try:
        git = ["git", "-C", str(ROOT), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        listed = subprocess.run(git, capture_output=True, check=True, timeout=60).stdout.decode()
        paths = [ROOT / name for name in listed.split("\0") if name]
    except (OSError, subprocess.CalledProcessError):
        skipped = {"build", "dist", "_build", "__pycache__"}
        paths = [p for p in ROOT.rglob("*") if not any(part.startswith(".") or part in skipped for part in p.relative_to(ROOT).parts)]
    return [p for p in paths if p.is_file() and p.suffix in {".py", ".md", ".toml", ".cff", ".svg", ".txt", ".css", ""}]
