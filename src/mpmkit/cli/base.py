"""What all commands share: the option --traceback, output as JSON, quantities on the command line."""

from __future__ import annotations

import contextlib
import json
from typing import Any, ClassVar

import click

from mpmkit.errors import ParameterError


class Command(click.Command):
    """A command that also accepts ``--traceback`` after its name."""

    traceback_wanted: ClassVar[bool] = False

    @classmethod
    def keep_traceback(cls, _: click.Context, __: click.Parameter, wanted: bool) -> None:
        """Remember the option, which is only read when something has failed."""
        Command.traceback_wanted = Command.traceback_wanted or wanted

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.params.append(
            click.Option(
                ["--traceback"], is_flag=True, expose_value=False, callback=self.keep_traceback, help="Show the traceback of an error."
            )
        )


def print_json(data: Any) -> None:
    """Write data to stdout as JSON, for other programs."""
    click.echo(json.dumps(data, indent=2, ensure_ascii=False, default=str))


class Quantity(click.ParamType):  # type: ignore[type-arg]  # generic only since click 8.3
    """A number in SI or text with a unit, such as ``"3 ms"``.

    Parameters
    ----------
    unit : str
        SI unit of the result.
    doc : str
        What it is, for messages.
    positive : bool
        Whether only values above zero are allowed.
    """

    name = "quantity"

    def __init__(self, unit: str, doc: str, *, positive: bool) -> None:
        self.unit, self.doc, self.positive = unit, doc, positive

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        from mpmkit.parameters import Spec, convert

        with contextlib.suppress(ValueError):
            value = float(value)
        spec = Spec(self.doc, self.unit, gt=0.0 if self.positive else None)
        try:
            return float(convert(value, float, spec, param.opts[0] if param is not None else self.name))
        except ParameterError as error:
            self.fail(str(error), param, ctx)
