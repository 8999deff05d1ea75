"""mpmkit view: a picture of one frame or several."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from mpmkit.cli.base import Command, Quantity


@click.command(cls=Command)
@click.argument("results", type=click.Path())
@click.option(
    "--field", metavar="NAME", help='What gives the colour: "v", "stress", "stress.xx", "pressure" ..., or "energies" for the history.'
)
@click.option(
    "--time", "times", type=Quantity("s", "time of the frame", positive=False), multiple=True, metavar="TIME",
    help='Time of the frame, such as "2 ms"; the last frame if not given. Several times are drawn side by side.',
)  # fmt: skip
@click.option("--output", type=click.Path(), metavar="PNG", help="Picture file; by default RESULTS with the ending .png.")
def view(results: str, field: str | None, times: tuple[float, ...], output: str | None) -> None:
    """Draw RESULTS (.vtkhdf) to a picture file, replacing an older picture."""
    from mpmkit.results import Results
    from mpmkit.views import view as draw

    path = output if output is not None else str(Path(results).with_suffix(".png"))
    chosen: dict[str, Any] = {"field": field} if field is not None else {}
    if times:
        chosen["time"] = times[0] if len(times) == 1 else times
    draw(Results(results), path=path, **chosen)
    click.echo(f"picture: {path}")
