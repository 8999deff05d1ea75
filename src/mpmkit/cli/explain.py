"""mpmkit explain: the step that a scene composes, before it runs."""

from __future__ import annotations

import click

from mpmkit.cli.base import Command, Quantity
from mpmkit.cli.tables import print_table


@click.command(cls=Command)
@click.argument("scene", type=click.Path())
@click.option("--measure", is_flag=True, help="Also time each phase, and the step without each effect, contact and boundary layer.")
@click.option(
    "--at", type=Quantity("s", "time", positive=True), metavar="TIME", help="Measure at this time, to which the scene is run first."
)
@click.option("--steps", type=int, metavar="N", help="Steps in which phases are timed; by default what a second allows.")
@click.option("--threads", type=int, metavar="N", help="Threads that step, as for mpmkit run.")
def explain(scene: str, measure: bool, at: float | None, steps: int | None, threads: int | None) -> None:
    """Show phases, loops, contributions, fields and time-step rules of SCENE, without running it."""
    from mpmkit.explanation import costs
    from mpmkit.scene import load

    given = [f"--{name}" for name, value in (("at", at), ("steps", steps), ("threads", threads)) if value is not None]
    if given and not measure:
        raise click.UsageError(f"{given[0]} says how to measure; add --measure")
    simulation = load(scene)
    if at is not None:
        records, simulation.records[:] = list(simulation.records), []
        simulation.run(until=at, quiet=True, threads=threads)
        simulation.records[:] = records  # writing them is measured too
    explanation = simulation.explain()
    click.echo(str(explanation))
    if measure:
        measured = explanation.measure(steps, threads=threads, say=lambda text: click.echo(f"{text} ...", err=True)).data["measured"]
        for title, headings, rows, notes in costs(measured):
            click.echo(f"\n{title}")
            print_table(headings, rows, indent=4)
            for note in notes:
                click.echo(note)
