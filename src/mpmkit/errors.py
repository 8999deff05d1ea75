"""The named exceptions. Every message says what, where, who asked and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class MpmkitError(Exception):
    """Base of everything mpmkit raises on purpose."""


class PluginError(MpmkitError):
    """A plugin cannot be loaded, or two plugins register one name."""


class ParameterError(MpmkitError, ValueError):
    """A parameter has a wrong type, unit or value."""


class CompositionError(MpmkitError):
    """The components of a simulation do not work together."""


class FieldContractError(CompositionError):
    """A component asks for a field that nothing in the composition supplies."""


class SceneError(MpmkitError):
    """A scene file has mistakes; the message lists all of them with their paths.

    Attributes
    ----------
    mistakes : tuple of str
        One text for each mistake, starting with its path.
    """

    def __init__(self, message: str, mistakes: Iterable[str] = ()) -> None:
        super().__init__(message)
        self.mistakes = tuple(mistakes)


class ResultsError(MpmkitError):
    """A result or checkpoint file cannot be written, or is not what it should be."""


class StabilityError(MpmkitError):
    """The run became, or would become, unstable; names particle, body, step, time and rule.

    Attributes
    ----------
    shorter : bool
        Whether the same steps might succeed with a smaller time step.
    """

    def __init__(self, message: str, *, shorter: bool = False) -> None:
        super().__init__(message)
        self.shorter = shorter


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return "; did you mean X?" for the nearest known name, or an empty string."""
    names = list(known)
    by_lower = {n.lower(): n for n in names}
    near = get_close_matches(name.lower(), by_lower, n=1, cutoff=0.6)
    return f"; did you mean {by_lower[near[0]]!r}?" if near else ""


def shown(value: object, length: int = 80) -> str:
    """A value as text that fits into a message: cut where it is longer."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # a whole number of more digits than Python writes, or endless nesting
        text = f"<{type(value).__name__}>"
    return text if len(text) <= length else text[: length - 3] + "..."
