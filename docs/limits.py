"""Searches the limits of the main compositions: writes what the time step and `explain` read, and its table for docs/stability.md.

``python docs/limits.py`` takes an hour; ``--redraw`` writes the table anew from what is published.
"""

from __future__ import annotations

from pathlib import Path

import click

from mpmkit.stability import limits

TABLES = Path(__file__).with_name("stability-limits.md")
HEAD = "<!-- written by python docs/limits.py from what it publishes in the package; search again instead of editing -->\n\n"


@click.command(help=__doc__)
@click.option("--redraw", is_flag=True, help="Search nothing.")
@click.option("--jobs", type=click.IntRange(min=1), default=2, show_default=True, help="Child processes.")
def main(redraw: bool, jobs: int) -> None:
    """Search, and write everything."""
    if not redraw:
        limits.write(limits.find_limits(say=click.echo, jobs=jobs))
    TABLES.write_text(HEAD + limits.table(limits.read()), encoding="utf-8")


if __name__ == "__main__":
    main()
