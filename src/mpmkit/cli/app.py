"""The group of commands, and how any failure ends: a few lines on stderr and an exit status."""

from __future__ import annotations

import errno
import importlib
import os
import sys
import warnings
from collections.abc import Sequence
from typing import Any

import click

import mpmkit
from mpmkit.cli.base import Command
from mpmkit.errors import MpmkitError, did_you_mean

COMMANDS: dict[str, tuple[str, str]] = {
    "run": ("mpmkit.cli.run:run", "Run a scene file."),
    "resume": ("mpmkit.cli.resume:resume", "Continue a run from its checkpoint."),
    "explain": ("mpmkit.cli.explain:explain", "Show the step that a scene file composes."),
    "study": ("mpmkit.cli.study:study", "Show what accuracy costs: errors and wall times over axes of a scene."),
    "advise": ("mpmkit.cli.advise:advise", "Predict the time of a scene, and what reaches an error for less."),
    "view": ("mpmkit.cli.view:view", "Draw a frame of a result file as PNG."),
    "list-plugins": ("mpmkit.cli.list_plugins:list_plugins", "List all components, and plugins that cannot be loaded."),
    "describe": ("mpmkit.cli.describe:describe", "Show equation, parameters, units and references of a component."),
    "check": ("mpmkit.cli.check:check", "Run the conformance checks of a plugin."),
    "stability": ("mpmkit.cli.stability:stability", "Run hard cases for numerical stability."),
    "schema": ("mpmkit.cli.schema:schema", "Print the JSON Schema of scene files."),
    "info": ("mpmkit.cli.info:info", "Show versions and machine, for bug reports."),
}
"""Name -> (where the command is, the line that ``--help`` shows without importing it)."""


class Group(click.Group):
    """Commands that are imported when they are called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in COMMANDS:
            return None
        module, attribute = COMMANDS[name][0].split(":")
        return getattr(importlib.import_module(module), attribute)  # type: ignore[no-any-return]

    def resolve_command(self, ctx: click.Context, args: list[str]) -> tuple[str | None, click.Command | None, list[str]]:
        name = args[0]
        if name not in COMMANDS and not name.startswith("-") and not ctx.resilient_parsing:
            raise click.UsageError(f"no command named {name!r}{did_you_mean(name, COMMANDS)}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, line) for name, (_, line) in COMMANDS.items()])


def _show_version(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        click.echo(f"mpmkit {mpmkit.__version__}")
        ctx.exit()


@click.command(cls=Group, context_settings={"help_option_names": ["-h", "--help"]})
@click.option("--version", is_flag=True, expose_value=False, is_eager=True, callback=_show_version, help="Show the version and exit.")
@click.option("--traceback", is_flag=True, expose_value=False, callback=Command.keep_traceback, help="Show the traceback of an error.")
def group() -> None:
    """Simulate solids, soils, soft matter and impact with the material point method, by composition."""


def main(args: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit status.

    The status is 0 only on success, 1 for any error, 2 for wrong usage and 130 after Ctrl-C.
    """
    arguments = list(sys.argv[1:] if args is None else args)
    Command.traceback_wanted = False
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            status = group.main(arguments, prog_name="mpmkit", standalone_mode=False)
        sys.stdout.flush()
    except click.ClickException as error:
        error.show()
        sys.exit(error.exit_code)
    except click.Abort:
        click.echo("mpmkit: interrupted", err=True)
        sys.exit(130)
    except BaseException as error:  # noqa: BLE001
        sys.exit(_failure(error, Command.traceback_wanted))
    sys.exit(status if isinstance(status, int) else 0)


def _show_warning(message: Warning | str, *_: Any, **__: Any) -> None:
    """A warning for people, without the line of source it comes from."""
    click.echo(f"mpmkit: warning: {message}", err=True)


def _failure(error: BaseException, traceback: bool) -> int:
    """Say what went wrong; return the exit status."""
    if isinstance(error, SystemExit):
        raise error
    if isinstance(error, KeyboardInterrupt):
        click.echo("mpmkit: interrupted", err=True)
        return 130
    if isinstance(error, OSError) and error.errno == errno.EPIPE:
        # The reader (head, less) has gone. Python flushes stdout once more at exit, which must not fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    if traceback:
        import traceback as printer

        printer.print_exception(error)
    click.echo(_text(error), err=True)
    return 1


def _text(error: BaseException) -> str:
    if isinstance(error, MpmkitError):
        return f"mpmkit: {type(error).__name__}: {error}"
    if isinstance(error, OSError) and error.strerror:
        where: Any = error.filename
        return f"mpmkit: {error.strerror}" + (f": {where!r}" if where is not None else "")
    return (
        f"mpmkit: unexpected {type(error).__name__}: {error}\n"
        "  This may be a fault of mpmkit or of a plugin. --traceback shows where; please report it with the output of mpmkit info."
    )
