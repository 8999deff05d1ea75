"""What reading and composing one scene file may end in: a simulation, or a clear refusal, soon and in little memory."""

from __future__ import annotations

import re
import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import attrs

import mpmkit as mpm
from mpmkit.errors import MpmkitError, SceneError

SECONDS = 5.0
"""Time within which a file is read and composed or refused."""
MOST = 100_000
"""Particles up to which a scene that was read is also composed."""
LONGEST = 4000
"""Characters of a message that somebody can still read."""


@attrs.frozen
class Outcome:
    """How it ended: "runs", "refused", "large", or "fault" with the reason."""

    kind: str
    text: str = ""
    stage: str = "load"


class TooLong(BaseException):
    """Of no class that anything may catch."""


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Raise `TooLong` if this takes more of the processor's time, so that a busy machine makes no faults."""

    def late(number: int, frame: Any) -> None:
        raise TooLong

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def judge(path: Path, *, seconds: float = SECONDS) -> Outcome:
    """Read and compose one file."""
    stage = "load"
    try:
        with within(seconds), warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.filterwarnings("ignore", category=UserWarning, module="mpmkit")
            simulation = mpm.load(path)
            stage = "compose"
            if sum(b.estimated_count(simulation.grid) for b in simulation.bodies) > MOST:
                return Outcome("large", stage=stage)
            simulation.compose()
            stage = "write"
            text = mpm.scene.dumps(simulation)
            again = mpm.scene.loads(text)
            if mpm.scene.dumps(again) != text:
                return Outcome("fault", f"written and read again it is another scene:\n{text}", stage)
    except MpmkitError as error:
        wrong = unclear(error, stage)
        return Outcome("fault", f"{wrong}: {error}", stage) if wrong else Outcome("refused", f"{type(error).__name__}: {error}", stage)
    except TooLong:
        return Outcome("fault", f"takes longer than {seconds:g} s", stage)
    except KeyboardInterrupt:
        raise
    except RecursionError as error:
        return Outcome("fault", f"RecursionError: {error}", stage)
    except BaseException as error:  # noqa: BLE001  that is what is looked for
        import traceback

        where = traceback.extract_tb(error.__traceback__)[-1]
        ours = [f for f in traceback.extract_tb(error.__traceback__) if "mpmkit" in f.filename]
        last = ours[-1] if ours else where
        return Outcome("fault", f"{type(error).__name__}: {error} at {Path(last.filename).name}:{last.lineno} ({last.line})", stage)
    return Outcome("runs", stage=stage)


def unclear(error: MpmkitError, stage: str) -> str:
    """What is wrong with a message; empty if it says where and what."""
    text = str(error)
    if len(text) > LONGEST + 1000 * len(getattr(error, "mistakes", ())):
        return f"a message of {len(text)} characters"
    if re.search(r" at 0x[0-9a-f]{6,}|Traceback|<class '", text):
        return "a message about the inside of Python"
    if len(text) < 15:
        return "a message that says nothing"
    if stage == "write":
        return "a scene that was read cannot be written"
    if stage == "load":
        if not isinstance(error, SceneError):
            return f"a {type(error).__name__} in place of a SceneError"
        if error.mistakes and not all(m.startswith("scene") for m in error.mistakes):
            return "a mistake without its path"
    return ""
