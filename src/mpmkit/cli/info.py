"""mpmkit info: what a bug report needs."""

from __future__ import annotations

import os
import platform
import sys
from importlib.metadata import PackageNotFoundError, distribution, version
from typing import Any

import click

import mpmkit
from mpmkit.cli.base import Command, print_json


@click.command(cls=Command)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def info(as_json: bool) -> None:
    """Show versions, machine, cache folder and plugins, for bug reports."""
    data = collect()
    if as_json:
        print_json(data)
        return
    for name, value in data.items():
        if isinstance(value, dict):
            click.echo(f"{name}:")
            for key, item in value.items():
                click.echo(f"  {key:<14} {item}")
        else:
            click.echo(f"{name:<16} {value}")


def collect() -> dict[str, Any]:
    """The facts, by name."""
    from mpmkit._core.composing.cache import folder
    from mpmkit._core.registry import registry

    found = registry()
    plugins = {f"{e.plugin}": f"{e.distribution} {e.version}" for e in found.entries}
    plugins |= {b.plugin: f"{b.distribution} {b.version}, not loaded: {b.reason}" for b in found.broken}
    return {
        "mpmkit": mpmkit.__version__,
        "Python": f"{platform.python_version()} ({platform.python_implementation()}, {sys.executable})",
        "platform": platform.platform(),
        "processor": f"{platform.machine()}, {os.cpu_count()} cores, {_usable_cores()} usable",
        "cache folder": str(folder()),
        "packages": {name: _version(name) for name in _needed()},
        "plugins": plugins,
        "environment": {k: v for k, v in sorted(os.environ.items()) if k.startswith(("MPMKIT_", "NUMBA_", "OMP_"))},
    }


def _usable_cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _needed() -> list[str]:
    """Distributions that mpmkit declares, extras included, as they are installed here or not."""
    import re

    try:
        requires = distribution("mpmkit").requires or []
    except PackageNotFoundError:
        return []
    return sorted({re.split(r"[^\w.-]", text, maxsplit=1)[0] for text in requires if "extra ==" not in text or 'extra == "vis"' in text})


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
