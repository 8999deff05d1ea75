"""Searches the limits of the main compositions: writes what the time step and `explain` read, and its table, docs/stability-limits.md.

``python docs/limits.py`` takes an hour; ``--redraw`` writes the table anew from what is published.
"""

from __future__ import annotations

from pathlib import Path

import click

from mpmkit.stability import limits

TABLES = Path(__file__).with_name("stability-limits.md")
HEAD = "<!-- written by python docs/limits.py from what it publishes in the package; search again instead of editing -->\n\n"
TITLE = """# Limits found by search

How far the main compositions can be driven. The time step refuses a fixed dt above these Courant numbers, and `explain` warns of a `cfl`
above them and of too few particles. In flight through the cells a small gain of energy in each crossing adds up; the last column but one
says from which Courant number on that is more than 5 % in 1000 steps.

"""


@click.command(help=__doc__)
@click.option("--redraw", is_flag=True, help="Search nothing.")
@click.option("--jobs", type=click.IntRange(min=1), default=2, show_default=True, help="Child processes.")
def main(redraw: bool, jobs: int) -> None:
    """Search, and write everything."""
    if not redraw:
        limits.write(limits.find_limits(say=click.echo, jobs=jobs))
    TABLES.write_text(HEAD + TITLE + limits.table(limits.read()), encoding="utf-8")


if __name__ == "__main__":
    main()
