"""Measures what docs/stability.md shows: runs the stability suite and writes its results, table and picture.

``python docs/stability.py`` goes on where an interrupted run was; ``--redraw`` writes table and picture anew from the kept results.
"""

from __future__ import annotations

import json
from pathlib import Path

import click

from mpmkit.stability import matrix, run, table

DOCS = Path(__file__).parent
DATA, TABLES, PICTURE, RUNNING = "data/stability.json", "stability-tables.md", "images/stability.png", "_build/stability"
HEAD = "<!-- written by python docs/stability.py from docs/data/stability.json; measure again instead of editing -->\n\n"


def write(docs: Path = DOCS) -> None:
    """Table and picture from the kept results."""
    data = json.loads((docs / DATA).read_text(encoding="utf-8"))
    (docs / TABLES).write_text(HEAD + table.summary(data), encoding="utf-8")
    matrix.draw(data, docs / PICTURE)


@click.command(help=__doc__)
@click.option("--redraw", is_flag=True, help="Measure nothing.")
@click.option("--quick", is_flag=True, help="Shorter runs of all published compositions.")
@click.option("--jobs", type=int, default=None)
def main(redraw: bool, quick: bool, jobs: int | None) -> None:
    """Run the suite and write everything."""
    if not redraw:
        from mpmkit.stability.compositions import published

        suite = run(None, published(), quick=quick, jobs=jobs, folder=DOCS / RUNNING, quiet=False)
        (DOCS / DATA).parent.mkdir(exist_ok=True)
        (DOCS / DATA).write_text(json.dumps(suite.data(), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    write()


if __name__ == "__main__":
    main()
