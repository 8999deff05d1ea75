"""Steps that failed and are done again: back to the last good copy, and on with a smaller Courant number for a while."""

from __future__ import annotations

from typing import Any

import attrs

from mpmkit._core.running.timestep import Limit

AWAY = 20
"""A copy from fewer steps before the failure may be spoilt already; an older one is taken if there is one."""


NUMBERS = ("level", "release", "hold", "steps")


@attrs.frozen
class Repeat:
    """One going back.

    Attributes
    ----------
    step, t : int, float
        Where a step failed [s].
    back_step, back_t : int, float
        Where the run goes on from.
    share : float
        Courant number from there on, relative to the one asked for.
    why : str
        What failed, in one line.
    """

    step: int
    t: float
    back_step: int
    back_t: float
    share: float
    why: str

    def __str__(self) -> str:
        return (
            f"steps {self.back_step + 1} to {self.step} (t = {self.back_t:.6g} to {self.t:.6g} s) are repeated with the Courant number "
            f"times {self.share:g}, because a step failed: {self.why}"
        )


class Repeats:
    """How often a run went back, and how small its steps are because of it.

    Each time the Courant number is halved. Twice as long after the place of the failure as the run had gone back, and longer with every
    further time, it is doubled again until it is what was asked for: all of it follows from steps and times, nothing from the clock.
    """

    def __init__(self) -> None:
        self.done: list[Repeat] = []
        self.level = 0  # the Courant number is divided by 2^level
        self.release = 0.0  # time at which it is doubled again
        self.hold = 0.0  # and how long to wait for the next doubling
        self.steps = 0  # that were done in vain

    @property
    def share(self) -> float:
        """Factor of the Courant number."""
        return float(0.5**self.level)

    def slowed(self, limit: Limit, t: float) -> Limit:
        """The time step after the share that holds now; time `t` may end it."""
        while self.level and t >= self.release:
            self.level -= 1
            self.release = t + self.hold
        if not self.level:
            return limit
        return Limit(self.share * limit.dt, f"{limit.rule}; Courant number times {self.share:g} after a failed step")

    def went_back(self, step: int, t: float, back_step: int, back_t: float, why: str) -> Repeat:
        """Note a failure at `step` after which the run goes on from `back_step`."""
        self.level += 1
        self.steps += step - back_step
        self.done.append(Repeat(step, float(t), back_step, float(back_t), self.share, why))
        self.hold = float(t - back_t) * 2.0 ** min(len(self.done), 20)
        self.release = float(t + self.hold)
        return self.done[-1]

    def facts(self) -> dict[str, Any]:
        """State as plain data."""
        return {name: getattr(self, name) for name in ("level", "release", "hold", "steps")} | {
            "done": [attrs.asdict(r) for r in self.done]
        }

    def recall(self, facts: dict[str, Any]) -> None:
        """Take over what a checkpoint holds."""
        for name in NUMBERS:
            setattr(self, name, facts[name])
        self.done = [Repeat(**one) for one in facts["done"]]

    def summary(self) -> str:
        """One line for the end of a run."""
        times = ", ".join(f"t = {r.t:.6g} s" for r in self.done[:3]) + (" ..." if len(self.done) > 3 else "")
        return f"{len(self.done)}, {self.steps} steps done again (failed at {times})"
