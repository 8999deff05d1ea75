"""Tables on the terminal, by rich; in a pipe or a file every row stays on one line."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterable, Sequence

import click

PIPE_WIDTH = 10_000
"""Wider than any row: whoever reads a pipe line by line gets one component per line."""


def print_table(headings: Sequence[str], rows: Iterable[Sequence[str]], *, indent: int = 0) -> None:
    """Print rows of plain text under headings."""
    from rich import box
    from rich.console import Console
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, header_style="bold")
    for heading in headings:
        table.add_column(heading, overflow="fold")
    for row in rows:
        # Text, not str: brackets such as [0, 1] in a cell are not markup.
        table.add_row(*(Text(str(cell)) for cell in row))
    padded = Padding(table, (0, 0, 0, indent))
    if sys.stdout.isatty():
        Console(file=sys.stdout).print(padded)
        return
    # Into memory first: rich fills every line up to the width.
    text = io.StringIO()
    Console(file=text, width=PIPE_WIDTH).print(padded)
    click.echo("\n".join(line.rstrip() for line in text.getvalue().splitlines()))
