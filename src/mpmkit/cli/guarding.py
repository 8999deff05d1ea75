"""Options of the commands that run: what happens to particles that leave the domain, and how often failed steps are repeated."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

F = TypeVar("F", bound=Callable[..., Any])


def guard_options(command: F) -> F:
    """Add ``--leaving`` and ``--retries``."""
    leaving = click.option(
        "--leaving",
        type=click.Choice(("stop", "remove", "clamp")),
        help="What happens to particles that leave the domain, instead of what the scene says.",
    )
    retries = click.option(
        "--retries",
        type=click.IntRange(0, 20),
        metavar="N",
        help="How many times in a row failed steps are repeated with half the Courant number.",
    )
    return leaving(retries(command))


def choose(simulation: Any, leaving: str | None, retries: int | None) -> None:
    """Set what was given."""
    if leaving is not None:
        simulation.leaving = leaving
    if retries is not None:
        simulation.retries = retries
