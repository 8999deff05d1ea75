"""mpmkit resume: continue an interrupted run."""

from __future__ import annotations

import click

from mpmkit.cli.base import Command, Quantity
from mpmkit.cli.guarding import choose, guard_options


@click.command(cls=Command)
@click.argument("checkpoint", type=click.Path())
@click.option(
    "--until", type=Quantity("s", "end time", positive=True), metavar="TIME", help='New end time in seconds, or text such as "3 ms".'
)
@click.option(
    "--threads", type=int, metavar="N", help="Threads that step; by default MPMKIT_THREADS, or chosen by the number of particles."
)
@guard_options
@click.option("--quiet", is_flag=True, help="Show no progress.")
def resume(checkpoint: str, until: float | None, threads: int | None, leaving: str | None, retries: int | None, quiet: bool) -> None:
    """Continue the run that wrote CHECKPOINT (NAME.ckpt.h5) to its end, bit for bit as if it had not stopped."""
    from mpmkit.simulation import Simulation

    simulation = Simulation.from_checkpoint(checkpoint)
    choose(simulation, leaving, retries)
    simulation.run(**({} if until is None else {"until": until}), quiet=quiet, threads=threads)
    if not quiet:
        for record in simulation.records:
            click.echo(f"results: {record.path}")
