"""mpmkit advise: what a scene will cost, and what would reach an error for less."""

from __future__ import annotations

from typing import Any

import click

from mpmkit.cli.base import Command, Quantity, print_json
from mpmkit.cli.tables import print_table


@click.command(cls=Command)
@click.argument("scene", type=click.Path())
@click.option("--error", required=True, metavar="ERROR", help="The relative error that you want, such as 1% or 0.01.")
@click.option("--field", metavar="NAME", help="Of which field: stress, u, v ...; by default that of the study that fits best.")
@click.option("--until", type=Quantity("s", "end time", positive=True), metavar="TIME", help="End of the run, if not that of the scene.")
@click.option("--threads", type=click.IntRange(1), default=1, show_default=True, metavar="N", help="Threads that step.")
@click.option("--studies", type=click.Path(), multiple=True, metavar="PATH", help="Further studies: a folder of results, or a file.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("--quiet", is_flag=True, help="Show no progress.")
def advise(
    scene: str, error: str, field: str | None, until: float | None, threads: int, studies: tuple[str, ...], as_json: bool, quiet: bool
) -> int:
    """Predict the time of SCENE (.toml or .json) on this machine, and name what reaches ERROR for less.

    The scene steps for two seconds. Errors come from the published studies, whose problems may be more or less like yours; the answer
    says how sure it is, and why.
    """
    from mpmkit.studies.advising import advise as ask

    found = ask(scene, error, field=field, until=until, threads=threads, studies=studies, quiet=quiet)
    if as_json:
        print_json(found.data())
    else:
        show(found)
    return 0


def show(found: Any) -> None:
    """Sentences, then the numbers."""
    from mpmkit.cli.study import wrapped

    for line in found.sentences():
        click.echo(wrapped(line))
    rows = []
    for name, option in [("now", found.here), *(("", o) for o in found.options)]:
        error = "" if option.error is None else f"{option.error:.2g}"
        cost = "" if option.seconds is None else f"{option.seconds:.3g}"
        counts = ["" if n is None else f"{n:,}" for n in (option.particles, option.steps)]
        rows.append([name, option.label, f"{option.spacing:.4g}", *counts, cost, error, option.origin or option.note])
    if found.options:
        click.echo()
        print_table(["", "composition", "cell size [m]", "particles", "steps", "seconds", "error", "from"], rows)
