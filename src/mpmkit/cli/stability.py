"""mpmkit stability: hard cases under all compositions, or with the components of a plugin."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mpmkit.cli.base import Command, print_json

if TYPE_CHECKING:
    from mpmkit.stability.suite import Suite


def _complete(_: click.Context, __: click.Parameter, incomplete: str) -> list[str]:
    from mpmkit.stability.cases import cases

    return sorted(name for name in cases() if name.startswith(incomplete))


@click.command(cls=Command)
@click.option("--case", "names", multiple=True, metavar="NAME", shell_complete=_complete, help="Only this case; may be repeated.")
@click.option("--quick", is_flag=True, help="Shorter runs of the default composition and a few others.")
@click.option("--with", "plugin", metavar="PLUGIN", help="Compositions in which this plugin, distribution or component takes part.")
@click.option("--all", "every", is_flag=True, help="The full product of what is registered, which takes hours.")
@click.option(
    "--limits", is_flag=True, help="Search the limits of the main compositions instead: time step, particles per cell, stretch ..."
)
@click.option("--list", "listing", is_flag=True, help="Only list the cases.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option(
    "--output", type=click.Path(file_okay=False), default="stability", show_default=True, metavar="DIR", help="Folder of the results."
)
@click.option("--jobs", type=click.IntRange(min=1), metavar="N", help="Child processes; by default one for each core.")
@click.option(
    "--timeout", type=click.FloatRange(min=0.0, min_open=True), default=600.0, show_default=True, metavar="S", help="Seconds for a cell."
)
def stability(
    names: tuple[str, ...],
    quick: bool,
    plugin: str | None,
    every: bool,
    limits: bool,
    listing: bool,
    as_json: bool,
    output: str,
    jobs: int | None,
    timeout: float,
) -> None:
    """Run hard cases for numerical stability; write a table and a picture.

    Every case runs under every composition it applies to, in child processes: a crash or a time limit is a verdict. Results are kept as
    they come, so that an interrupted run goes on where it was. The exit status is 0 if everything that does not hold is explained by
    theory, and every explanation is true.
    """
    from mpmkit.stability.runner import chosen, run

    if quick and every:
        raise click.UsageError("--quick and --all contradict each other")
    if listing:
        show_cases(names, as_json)
        return
    if limits:
        if names or plugin is not None or every:
            raise click.UsageError("--limits searches the limits of the main compositions; it takes --quick, --json and --output only")
        search(Path(output), quick, as_json)
        return
    chosen(names or None)  # a name that no case has is told before anything is made
    suite = run(
        names or None, quick=quick, plugin=plugin, every=every, jobs=jobs, timeout=timeout, folder=_folder(output, plugin), quiet=False
    )
    data = suite.data()
    files = write(data, Path(output))
    if as_json:
        print_json(data)
    else:
        show(suite, data)
        for path in files:
            click.echo(str(path))
    if not suite.passed:
        click.get_current_context().exit(1)


def search(folder: Path, quick: bool, as_json: bool) -> None:
    """Search the limits; write and print them."""
    from mpmkit.stability.limits import find_limits, table
    from mpmkit.stability.limits import write as keep

    data = find_limits(quick=quick, say=lambda text: click.echo(text, err=True))
    folder.mkdir(parents=True, exist_ok=True)
    path = keep(data, folder / "limits.json")
    if as_json:
        print_json(data)
    else:
        click.echo(table(data))
        click.echo(str(path))


def _folder(output: str, plugin: str | None) -> Path:
    """The folder of the results; nothing is made there before the plugin's name is known to be one."""
    if plugin is not None:
        from mpmkit.stability.compositions import of_plugin

        of_plugin(plugin, few=True)
    return Path(output)


def write(data: dict[str, Any], folder: Path) -> list[Path]:
    """Write data, table and picture into a folder; returns the files."""
    from mpmkit.stability import matrix, table

    folder.mkdir(parents=True, exist_ok=True)
    files = [folder / f"stability.{ending}" for ending in ("json", "md", "png")]
    files[0].write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    files[1].write_text(table.page(data), encoding="utf-8")
    matrix.draw(data, files[2])
    return files


def show_cases(names: tuple[str, ...], as_json: bool) -> None:
    """Print names and titles of the cases."""
    from mpmkit.cli.tables import print_table
    from mpmkit.stability.runner import chosen
    from mpmkit.stability.suite import CASE_FACTS

    cases = chosen(names or None)
    if as_json:
        print_json([{name: getattr(case, name) for name in CASE_FACTS} for case in cases])
        return
    rows = [(c.name, f"{c.dim}D", c.title, f"waits for {c.waits_for}" if c.waits_for else "") for c in cases]
    print_table(("case", "space", "what", ""), rows)


def show(suite: Suite, data: dict[str, Any]) -> None:
    """Print a letter for each cell, what does not hold with its reason, and the counts."""
    from mpmkit.cli.tables import print_table
    from mpmkit.stability.table import count, worst

    letters = {"holds": "h", "bounded": "b", "fails": "F", "refused": "r", "waiting": "w"}
    cells = {(c["case"], c["composition"]): letters[c["status"]] for c in data["cells"]}
    numbers = range(len(data["compositions"]))
    click.echo("\n".join(f"{k + 1:3}  {data['compositions'][k]['name']}" for k in numbers))
    marks = [" ".join(f"{k + 1:2}"[d] for k in numbers) for d in (0, 1)] if len(numbers) < 100 else []
    rows = [("", line) for line in marks]
    rows += [(case["name"], " ".join(cells.get((case["name"], k), "·") for k in numbers)) for case in data["cases"]]
    print_table(("case", "composition"), rows)
    trouble = [c for c in data["cells"] if c["status"] in ("bounded", "fails") and c["explanation"] is not None]
    if trouble:
        told = [(c["case"], data["compositions"][c["composition"]]["name"], c["status"], worst(c), _why(c["explanation"])) for c in trouble]
        click.echo("does not hold, as theory tells:")
        print_table(("case", "composition", "verdict", "figure", "why"), told)
    for title, lines in (("does not hold, and nothing explains it", suite.unexplained), ("not true", suite.contradicted)):
        for line in lines:
            click.echo(f"{title}: {line.splitlines()[0]}")
    click.echo("cells: " + ", ".join(f"{n} {status}" for status, n in count(data).items() if n))


def _why(explanation: dict[str, str]) -> str:
    return f"{explanation['reason']}. To fix: {explanation['remedy']}"
