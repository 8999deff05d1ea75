"""What is said to somebody who asks for advice: time and error of a scene, what is better, and how sure that is."""

from __future__ import annotations

from typing import Any

import attrs

from mpmkit.studies.numbers import number, plain, seconds, times
from mpmkit.studies.published import BEYOND, COARSER, INSIDE

APPLIES, ALIKE = 0.75, 0.9
"""From which likeness on a study says something about a scene, and from which on it is a good witness."""
FAIRLY, UNSURE, NOT_KNOWN = "fairly sure", "unsure", "not known"
SAME_TIME = 0.8
"""Below this share of the time another composition is called cheaper."""
ORIGINS = {INSIDE: "measured there", BEYOND: "by its observed order", COARSER: "with more cells than here, so expect more"}
HOWTO = (
    'To find out, let it be its own witness: a study with this scene, the axis "grid.spacing" and the error { kind = "Finest", '
    'field = "v", relative = true } compares it with its finest run.'
)


@attrs.frozen
class Option:
    """One composition at one cell size.

    Attributes
    ----------
    label : str
        In short.
    choices : dict
        Paths into the scene with their values, as for an axis of a study.
    spacing : float
        Cell size [m].
    error : float, optional
        What the study lets expect.
    origin : str
        Where the error is from: measured in the study, by its observed order, coarser than any run.
    seconds, steps, particles
        Predicted for this machine.
    """

    label: str
    choices: dict[str, Any]
    spacing: float
    error: float | None
    origin: str
    seconds: float | None
    steps: int | None
    particles: int | None
    bytes: int | None = None
    note: str = ""

    @property
    def place(self) -> str:
        """What it is, and its cell size."""
        return f"{self.label} at cell size {plain(self.spacing, 'm', 3)}"


@attrs.frozen
class Advice:
    """What is known of a scene before it runs; `sentences` says it.

    Attributes
    ----------
    scene : str
    wanted : float
        Asked error, without a unit.
    here : Option
        The scene as composed.
    done : float
        Share of the scene's run that was stepped to predict its time.
    travel : float
        How many cells its particles move, at most.
    measure : str, optional
        The error of the study that it is held against.
    options : list of Option
        Others that reach the error, fastest first.
    study : str, optional
        The published study that applies; None if none does.
    likeness : float
        How much its problem has in common with the scene's, from 0 to 1; that of the nearest study if none applies.
    nearest : str
        The nearest study, if there is any.
    same, differs : list of str
        What they have in common, and what not.
    smallest : float, optional
        Smallest error in the study.
    sure : str
        `FAIRLY`, `UNSURE` or `NOT_KNOWN`.
    """

    scene: str
    wanted: float
    here: Option
    done: float
    travel: float
    measure: str | None = None
    options: list[Option] = attrs.Factory(list)
    study: str | None = None
    likeness: float = 0.0
    nearest: str = ""
    same: list[str] = attrs.Factory(list)
    differs: list[str] = attrs.Factory(list)
    smallest: float | None = None
    sure: str = NOT_KNOWN

    def data(self) -> dict[str, Any]:
        """As plain data."""
        return {**attrs.asdict(self), "sentences": self.sentences()}

    def sentences(self) -> list[str]:
        """In words."""
        out = [self._now()]
        if self.study is None:
            return [*out, *self._unknown()]
        if self.here.error is not None:
            told = ORIGINS[self.here.origin]
            verdict = "enough" if self.enough else "not enough"
            how = "likely" if self.likeness >= ALIKE else "perhaps"
            out.append(
                f"Its error is {how} about {number(self.here.error)} ({self.measure}; study {self.study!r}, {told}): {verdict} for "
                f"{number(self.wanted)}."
            )
        else:
            out.append(f"Nothing is known of its error: the study {self.study!r} has no run of this composition at such a cell size.")
        out += self._better()
        out.append(self._why())
        return out

    def _now(self) -> str:
        here = self.here
        if here.seconds is None:
            return f"{self.scene} as composed, {here.place}: {here.note}."
        how = "it was stepped to its end" if self.done >= 1.0 else f"from {number(100 * self.done)} % of the run"
        size = f"{here.particles or 0:,} particles, about {here.steps or 0:,} steps"
        return f"{self.scene} as composed, {here.place}: {size}, {seconds(here.seconds)} of stepping on this machine ({how})."

    @property
    def enough(self) -> bool:
        """Whether the scene as composed is likely to have the wanted error."""
        return self.here.error is not None and self.here.error <= self.wanted and self.here.origin != COARSER

    def _better(self) -> list[str]:
        if not self.options:
            best = f"; its smallest error is {number(self.smallest)}" if self.smallest is not None else ""
            return [
                f"No composition of the study {self.study!r} reaches {number(self.wanted)}{best}. Finer cells than it had would be a guess."
            ]
        out = []
        for k, option in enumerate(self.options):
            if option.seconds is None:
                out.append(f"{option.place} should reach it, but {option.note}.")
                continue
            line = f"{'The cheapest' if k == 0 else 'Also'} for {number(self.wanted)}: {option.place}"
            line += f", about {seconds(option.seconds)} ({option.particles or 0:,} particles)"
            if k == 0 and self.here.seconds:
                ratio = option.seconds / self.here.seconds
                cheaper = ratio < SAME_TIME
                line += f", {times(1.0 / ratio)} faster than now" if cheaper else f", {times(ratio)} the time of now"
                line += "; what you have is good" if self.enough and not cheaper else ""
            out.append(f"{line}; expected error {number(option.error)}, {option.origin}.")
        return out

    def _why(self) -> str:
        line = f"How sure: {self.sure}. The study {self.study!r} is alike in {number(100 * self.likeness)} %: "
        return line + (", ".join(self.same) or "nothing") + (f"; but {', '.join(self.differs)}." if self.differs else ".")

    def _unknown(self) -> list[str]:
        if not self.nearest:
            return ["No published study has an error of this kind; nothing is known of the error of this scene.", HOWTO]
        shared = f" It has in common: {', '.join(self.same)}." if self.same else ""
        near = f"The nearest, {self.nearest!r}, is alike in {number(100 * self.likeness)} %; it differs: {', '.join(self.differs)}."
        return [f"No published study is of a problem like this one, so nothing is known of its error. {near}{shared}", HOWTO]
