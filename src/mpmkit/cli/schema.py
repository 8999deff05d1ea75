"""mpmkit schema: for editors that complete and check scene files."""

from __future__ import annotations

from pathlib import Path

import click

from mpmkit.cli.base import Command


@click.command(cls=Command)
@click.option("--output", type=click.Path(dir_okay=False), metavar="PATH", help="Write to a file instead of stdout.")
def schema(output: str | None) -> None:
    """Print the JSON Schema of scene files, with the components of all installed plugins.

    An editor uses it when the first line of a scene file is "#:schema scene.schema.json".
    """
    import json

    from mpmkit.schema import schema as make

    text = json.dumps(make(), indent=2, ensure_ascii=False)
    if output is None:
        click.echo(text)
    else:
        Path(output).write_text(text + "\n", encoding="utf-8")
