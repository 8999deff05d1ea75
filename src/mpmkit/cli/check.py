"""mpmkit check: the conformance checks of plugins, each plugin in a process of its own."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Any

import click

from mpmkit.cli.base import Command, print_json
from mpmkit.errors import PluginError

TIMEOUT = 120.0


@click.command(cls=Command)
@click.argument("plugins", metavar="[PLUGIN]...", nargs=-1)
@click.option("--all", "everything", is_flag=True, help="All installed plugins; the same as naming none.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON: one object for each check.")
@click.option("--verbose", is_flag=True, help="Show every check, not only those that failed or are known to fail.")
@click.option(
    "--timeout",
    type=click.FloatRange(min=0.0, min_open=True),
    default=TIMEOUT,
    show_default=True,
    metavar="SECONDS",
    help="Longest time for one check; one that hangs is killed and counts as failed.",
)
@click.option(
    "--jobs", type=click.IntRange(min=1), default=None, metavar="N", help="Plugins checked at a time; one for each core if not given."
)
def check(plugins: tuple[str, ...], everything: bool, as_json: bool, verbose: bool, timeout: float, jobs: int | None) -> None:
    """Run the conformance checks on each component of the PLUGINs (entry points, distributions or components; all if none is named).

    Each plugin is checked in a child process, so that one that crashes, hangs or prints does no harm. The exit status is 0 if every check
    passes, failures that a component declares included; the reference page "Conformance checks" says what each check does.
    """
    if plugins and everything:
        raise click.UsageError("name plugins or give --all, not both")
    results = run(plugins or _installed(), timeout, jobs)
    if as_json:
        print_json(results)
    else:
        show(results, verbose=verbose)
    if not results or any(not result["passed"] for result in results):
        click.get_current_context().exit(1)


def _installed() -> tuple[str, ...]:
    from mpmkit.testing.isolated import plugins

    found = tuple(plugins())
    if not found:
        raise PluginError("no plugin is installed, or all are disabled (MPMKIT_DISABLE_PLUGINS)")
    return found


def run(names: tuple[str, ...], timeout: float, jobs: int | None) -> list[dict[str, Any]]:
    """Rows of all plugins in the order of their names, with the plugin's name in each."""
    import os

    from mpmkit.testing.isolated import check_plugin

    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    stop = threading.Event()
    with ThreadPoolExecutor(min(jobs or cores, len(names))) as pool:
        waiting = {pool.submit(check_plugin, name, timeout, stop): name for name in names}
        try:
            for future in as_completed(waiting):
                future.result()  # an unknown name ends the command at once
        except BaseException:
            stop.set()
            pool.shutdown(cancel_futures=True)
            raise
        return [{"plugin": name} | row for future, name in waiting.items() for row in future.result()]


def show(results: list[dict[str, Any]], *, verbose: bool = False) -> None:
    """Print a table of components, then what failed and why, known failures, warnings, and a summary."""
    from mpmkit.cli.tables import print_table

    if not results:
        click.echo("no checks were found for this plugin")
        return
    groups: dict[tuple[str, str, str], list[dict[str, Any]]] = {}
    for row in results:
        groups.setdefault((row["plugin"], row["component"], row["kind"]), []).append(row)
    table = []
    for (plugin, component, kind), rows in groups.items():
        failed, known = sum(not r["passed"] for r in rows), sum(r["passed"] and r["known"] for r in rows)
        seconds = sum(r["seconds"] for r in rows)
        table.append((component, kind, plugin, str(len(rows) - failed - known), str(failed or ""), str(known or ""), f"{seconds:.1f} s"))
    print_table(("component", "kind", "plugin", "passed", "failed", "known failures", "time"), table)
    click.echo()
    for (_, component, _), rows in groups.items():
        for row in rows:
            _show_row(component, row, verbose)
    failed = sum(not r["passed"] for r in results)
    known = sum(r["passed"] and r["known"] for r in results)
    told = [f"{len(results) - failed - known} passed", f"{failed} failed", *([f"{known} known to fail"] if known else [])]
    slow = max(results, key=lambda r: r["seconds"])
    click.echo(
        f"{', '.join(told)}; {sum(r['seconds'] for r in results):.1f} s of checks, "
        f"the longest {slow['component']} {slow['check']} ({slow['seconds']:.1f} s)"
    )


def _show_row(component: str, row: dict[str, Any], verbose: bool) -> None:
    """One check, if there is something to say about it."""
    mark = "FAILED" if not row["passed"] else "known " if row["known"] else "ok    "
    spent = f"  ({row['seconds']:.2f} s)" if verbose else ""
    if verbose or not row["passed"] or row["known"]:
        reason = f"  {row['reason']}" if row["reason"] else ""
        click.echo(f"{mark}  {component}  {row['check']}{spent}{reason}")
    for text in row["warnings"]:
        click.echo(f"warned  {component}  {row['check']}  {text}")
