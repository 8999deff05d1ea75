"""All mistakes of a scene file, gathered with their paths while it is read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from mpmkit.errors import SceneError, shown


class Wrong:
    """What reading returns for something wrong; the mistake itself has been noted, and reading goes on beside it."""


WRONG = Wrong()
LONGEST = 80
"""Characters of a key that are shown in a path."""


class Mistakes:
    """A list of mistakes and the path of the place that is being read.

    Parameters
    ----------
    source : str
        What is read, for the head line, such as a file name.
    """

    def __init__(self, source: str) -> None:
        self.source = source
        self.found: list[str] = []
        self._path = ["scene"]

    @property
    def path(self) -> str:
        """Where we are, for example "scene.bodies[0].material"."""
        return "".join(self._path)

    @contextmanager
    def at(self, step: str | int) -> Iterator[None]:
        """Enter a key of a table or an item of an array."""
        self._path.append(f"[{step}]" if isinstance(step, int) else f".{step if len(step) <= LONGEST else shown(step)}")
        try:
            yield
        finally:
            self._path.pop()

    def add(self, text: str) -> Wrong:
        """Note a mistake at the current path; texts that already start with it are kept as they are."""
        text = text if text.startswith(self.path) else f"{self.path}: {text}"
        self.found.append(text.replace("\n", "\n  "))
        return WRONG

    def raise_if_any(self) -> None:
        """Raise one `SceneError` that lists everything found."""
        if self.found:
            head = f"{self.source}: {len(self.found)} mistake{'' if len(self.found) == 1 else 's'}"
            raise SceneError("\n".join([head, *(f"  {text}" for text in self.found)]), self.found)
