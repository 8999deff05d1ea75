"""The table at the end of a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def summary_table(facts: Mapping[str, str], phases: Mapping[str, float], mark: str = "#") -> Any:
    """Facts, and phases with seconds and share, as something rich can print.

    Parameters
    ----------
    facts : mapping of str to str
        Shown in their order.
    phases : mapping of str to float
        Seconds of each phase; shares are of their sum.
    mark : str
        The character that bars are drawn with.
    """
    from rich import box
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    head = Table(box=box.SIMPLE_HEAD, show_header=False, pad_edge=False)
    head.add_column(style="bold")
    head.add_column()
    for name, value in facts.items():
        head.add_row(name, Text(value))
    parts: list[Any] = [head]
    total = sum(phases.values())
    if total > 0:
        table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
        table.add_column("phase", style="bold")
        table.add_column("seconds", justify="right")
        table.add_column("share", justify="right")
        table.add_column("")
        for name, seconds in phases.items():
            share = seconds / total
            table.add_row(Text(name), f"{seconds:.3f}", f"{share:.1%}", Text(mark * round(20 * share), style="cyan"))
        parts.append(table)
    return Group(*parts)
