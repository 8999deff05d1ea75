"""mpmkit study: what accuracy costs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mpmkit.cli.base import Command, print_json
from mpmkit.cli.tables import print_table

REPORTS = ".html, .md, .csv, .json, .png or .svg"


@click.command(cls=Command)
@click.argument("file", type=click.Path())
@click.option("--dry-run", is_flag=True, help="Run nothing: list the runs with the cost that a short calibration predicts.")
@click.option("--jobs", type=click.IntRange(1), metavar="N", help="Runs side by side for errors; one for each core if not given.")
@click.option("--folder", type=click.Path(), metavar="DIR", help="Where results are kept as they come; what is there is not done again.")
@click.option("--report", type=click.Path(), metavar="PATH", multiple=True, help=f"Write a report, by its ending {REPORTS}.")
@click.option("--error", metavar="ERROR", multiple=True, help="An error that you need, such as 1%: which composition reaches it first.")
@click.option("--repeat", type=click.IntRange(0), metavar="N", help="How often each run is timed; 0 for errors alone.")
@click.option("--json", "as_json", is_flag=True, help="Print rows and facts as JSON.")
@click.option("--quiet", is_flag=True, help="Show no progress.")
def study(
    file: str,
    dry_run: bool,
    jobs: int | None,
    folder: str | None,
    report: tuple[str, ...],
    error: tuple[str, ...],
    repeat: int | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Do the study in FILE (.toml): errors and wall times of all combinations of its axes.

    Interrupted, the same command goes on where it stopped.
    """
    from mpmkit.studies.results import check_ending, check_writable
    from mpmkit.studies.sentences import accuracy
    from mpmkit.studies.study import Study, slug

    for path in report:
        check_ending(path)
        check_writable(path)
    for text in error:
        accuracy(text)
    made = Study.from_file(file, **({} if repeat is None else {"repeat": repeat}))
    if dry_run:
        return _forecast(made, jobs, as_json, quiet)
    place = Path(folder) if folder else Path(f"{slug(made.name)}-study")
    try:
        results = made.run(place, jobs=jobs, quiet=quiet)
    except KeyboardInterrupt:
        click.echo(f"mpmkit: interrupted; what was done is kept in {place}, and the same command goes on from there", err=True)
        return 130
    for path in report:
        results.report(path, error)
    if as_json:
        print_json({"meta": results.meta, "rows": results.table(), "sentences": results.sentences(error)})
    else:
        show(results, error)
        click.echo(f"\nresults: {place}" + "".join(f", {path}" for path in report))
    return 0 if results.done() else 1


def show(results: Any, asked: tuple[str, ...] = ()) -> None:
    """The table on the terminal, then what is to be said about it."""
    from mpmkit.studies.sentences import sections

    axes = list(dict.fromkeys(axis for row in results for axis in row["labels"]))
    rows = []
    for row in results:
        errors = [_number(row["errors"].get(m)) for m in results.measures]
        spread = "" if row["seconds"] is None else f"{row['seconds']:.3g} ({row['seconds_low']:.3g} to {row['seconds_high']:.3g})"
        facts = [_whole(row["steps"]), _whole(row["particles"]), _number(row["ns_per_particle_step"])]
        told = "" if row["status"] == "done" else f"{row['status']}: {row['reason']}".split("\n")[0]
        names = [str(row["labels"].get(a, "")) for a in axes] or [row["label"]]
        rows.append([*names, *errors, spread, *facts, told])
    print_table([*(axes or ["run"]), *results.measures, "seconds", "steps", "particles", "ns/particle-step", ""], rows)
    notes = [*results.meta.get("notes", []), *dict.fromkeys(f"{row['composition']}: {n}" for row in results for n in row["notes"])]
    for title, lines in sections(results, asked).items():
        click.echo(f"\n{title}")
        for line in lines:
            click.echo(wrapped(line))
    if notes:
        click.echo()
    for note in notes:
        click.echo(f"note: {note}")


def wrapped(line: str) -> str:
    """A sentence as an item of a list, in the width of the terminal; in a pipe or a file on one line."""
    import shutil
    import sys
    import textwrap

    width = min(shutil.get_terminal_size().columns, 120) if sys.stdout.isatty() else 10_000
    return textwrap.fill(line, width, initial_indent="- ", subsequent_indent="  ")


def _forecast(made: Any, jobs: int | None, as_json: bool, quiet: bool) -> int:
    """What it would cost."""
    import os

    from mpmkit.studies.cost import predict

    rows = predict(made, made.plan(), quiet=quiet)
    if as_json:
        print_json(rows)
        return 0
    table = []
    for row in rows:
        memory = "" if row["bytes"] is None else _bytes(row["bytes"])
        told = "" if row["status"] == "planned" else f"{row['status']}: {row['reason']}".split("\n")[0]
        counts = [_whole(row["particles"]), _whole(row["steps"])]
        table.append([row["label"], *counts, _number(row["seconds"]), memory, told or "; ".join(row["notes"])])
    print_table(["run", "particles", "steps", "seconds", "memory", ""], table)
    seconds = [row["seconds"] for row in rows if row["seconds"] is not None]
    side = jobs or os.cpu_count() or 1
    errors, times = max([sum(seconds) / side, *seconds]) if seconds else 0.0, made.repeat * sum(seconds)
    click.echo(f"\nabout {errors:.3g} s for errors, {side} runs side by side; {times:.3g} s to time each run {made.repeat} times, alone;")
    click.echo("composing, compiling and the reference run come on top; memory is that of particles and nodes")
    return 0


def _bytes(n: int) -> str:
    from mpmkit._core.running.memory import text

    return text(n)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def _whole(value: int | None) -> str:
    return "" if value is None else f"{value:,}"
