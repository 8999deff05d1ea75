"""mpmkit run: a scene file to results."""

from __future__ import annotations

from typing import Any

import click

from mpmkit.cli.base import Command, Quantity
from mpmkit.cli.guarding import choose, guard_options
from mpmkit.errors import SceneError


@click.command(cls=Command)
@click.argument("scene", type=click.Path())
@click.option("--until", type=Quantity("s", "end time", positive=True), metavar="TIME", help='End time in seconds, or text such as "3 ms".')
@click.option("--output", type=click.Path(), metavar="PATH", help="Result file, instead of the one that the scene names.")
@click.option("--overwrite", is_flag=True, help="Replace existing results.")
@click.option(
    "--threads", type=int, metavar="N", help="Threads that step; by default MPMKIT_THREADS, or chosen by the number of particles."
)
@guard_options
@click.option("--quiet", is_flag=True, help="Show no progress.")
def run(
    scene: str,
    until: float | None,
    output: str | None,
    overwrite: bool,
    threads: int | None,
    leaving: str | None,
    retries: int | None,
    quiet: bool,
) -> None:
    """Run SCENE (.toml or .json), show progress and write the results that it records."""
    from mpmkit.scene import load

    simulation = load(scene)
    redirect(simulation, output, overwrite)
    choose(simulation, leaving, retries)
    simulation.run(**({} if until is None else {"until": until}), quiet=quiet, threads=threads)
    if not quiet:
        for record in simulation.records:
            click.echo(f"results: {record.path}")


def redirect(simulation: Any, output: str | None, overwrite: bool) -> None:
    """Let the records of a simulation write to `output`, and replace existing files if that was asked for.

    Raises
    ------
    SceneError
        If the scene has several records, so that one path does not say where each of them goes.
    """
    import attrs

    from mpmkit.record import Record

    records = list(simulation.records)
    if output is not None:
        if len(records) > 1:
            paths = ", ".join(record.path for record in records)
            raise SceneError(
                f"--output gives one path, but the scene has {len(records)} records ({paths}); change their paths in the scene"
            )
        records = [attrs.evolve(records[0], path=output) if records else Record(output)]
    if overwrite:
        records = [attrs.evolve(record, overwrite=True) for record in records]
    simulation.records[:] = records
