"""mpmkit check: the conformance checks of one plugin, in a process of their own."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import click

from mpmkit.cli.base import Command, print_json
from mpmkit.errors import PluginError, did_you_mean

CHILD = "import json, sys; from mpmkit.testing import report; data = report(sys.argv[1]); json.dump(data, open(sys.argv[2], 'w'))"
"""A plugin that crashes, hangs on to memory or prints must not reach the command itself: results come back in a file."""


@click.command(cls=Command)
@click.argument("plugin")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def check(plugin: str, as_json: bool) -> None:
    """Run the conformance checks on each component of PLUGIN (an entry point, a distribution or a component).

    The exit status is 0 if every check passes.
    """
    find(plugin)
    results = run_in_child(plugin)
    if as_json:
        print_json(results)
    else:
        show(results)
    if not results or any(not result["passed"] for result in results):
        click.get_current_context().exit(1)


def find(plugin: str) -> None:
    """Refuse names that nothing has, with the nearest one, and plugins that cannot be loaded, with the reason."""
    from mpmkit._core.registry import registry

    found = registry()
    for broken in found.broken:
        if plugin in (broken.plugin, broken.distribution):
            raise PluginError(
                f"the plugin {broken.plugin!r} ({broken.distribution} {broken.version}) cannot be loaded: {broken.reason}"
            ) from broken.error
    known = {name for entry in found.entries for name in (entry.plugin, entry.distribution, entry.name)}
    if plugin not in known:
        raise PluginError(
            f"no plugin, distribution or component is named {plugin!r}{did_you_mean(plugin, known)}\n  see: mpmkit list-plugins"
        )


def run_in_child(plugin: str) -> list[dict[str, Any]]:
    """Results of all checks: component, check, passed, reason."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "results.json"
        child = subprocess.run([sys.executable, "-c", CHILD, plugin, str(path)], capture_output=True, text=True, check=False)
        if child.returncode == 0 and path.exists():
            return list(json.loads(path.read_text()))
    how = f"was killed by signal {-child.returncode}" if child.returncode < 0 else f"ended with status {child.returncode}"
    last = "\n".join(f"  {line}" for line in child.stderr.strip().splitlines()[-12:])
    raise PluginError(f"the process that checked {plugin!r} {how} before it could report\n{last}".rstrip())


def show(results: list[dict[str, Any]]) -> None:
    """Print one line per check and a summary."""
    for result in results:
        mark = "ok    " if result["passed"] else "FAILED"
        reason = f"  {result['reason']}" if result.get("reason") else ""
        click.echo(f"{mark}  {result['component']}  {result['check']}{reason}")
    failed = sum(not result["passed"] for result in results)
    click.echo(f"{len(results) - failed} passed, {failed} failed" if results else "no checks were found for this plugin")
