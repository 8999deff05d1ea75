"""mpmkit explain: the step that a scene composes, before it runs."""

from __future__ import annotations

import click

from mpmkit.cli.base import Command


@click.command(cls=Command)
@click.argument("scene", type=click.Path())
def explain(scene: str) -> None:
    """Show phases, contributions, fields and time-step rules of SCENE, without running it."""
    from mpmkit.scene import load

    click.echo(str(load(scene).explain()))
