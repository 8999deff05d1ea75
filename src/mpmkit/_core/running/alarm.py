"""The alarm for energy out of nothing: what is left of the balance of works and energies, told early and in time."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.running.engine import SPEED
from mpmkit.errors import StabilityError

if TYPE_CHECKING:
    from mpmkit._core.running.engine import Engine

# Energy out of nothing, relative to the largest energy of the run, which contains it: at one half the energy has doubled.
CREATED_WARN, CREATED_STOP = 0.05, 0.5
EARLY, EARLY_STOP = 100, 0.8
"""In so many steps a sudden load may show a large share of the little energy that there is yet: velocities lag by half a step. What is
stopped then is four times as much energy as there was and was put in, at two looks of which the second is no better than the first."""
FIRST, OFTEN, FASTER = 20, 10, 2.0
"""Energies are looked at after each of the first steps, then after so many, and when the fastest signal has become faster by this factor
since the last look; whatever rows the history has."""


class EnergyAlarm:
    """Looks at the energy balance.

    What a time step above the stable limit makes multiplies within a few steps.
    """

    def __init__(self) -> None:
        self.warned = False
        self._fastest = 0.0
        self._before = 0.0  # balance at the last look, if it was suspicious

    def start(self, engine: Engine) -> None:
        """Before the first step."""
        self._fastest = float(engine.outs[:, SPEED].max())

    def due(self, engine: Engine) -> bool:
        """Whether the energies should be looked at after this step."""
        step = engine.step_number
        return bool(self._before) or step <= FIRST or step % OFTEN == 0 or float(engine.outs[:, SPEED].max()) > FASTER * self._fastest

    def look(self, engine: Engine, balance: float, rule: str) -> None:
        """Compare the balance with what is allowed.

        Raises
        ------
        StabilityError
            If so much energy was made that it has doubled; names the fastest particle.
        """
        self._fastest = float(engine.outs[:, SPEED].max())
        early = engine.step_number < EARLY
        before, self._before = self._before, 0.0
        if early and balance >= EARLY_STOP and not (before and balance >= before):
            self._before = balance
        elif not balance < (EARLY_STOP if early else CREATED_STOP):
            raise StabilityError(
                f"energy was created: {balance:.3g} times the largest energy of the run, at step {engine.step_number}, t = "
                f"{engine.t:.6g} s; fastest is {_fastest(engine)} (time step limited by {rule}). To fix: {_remedy(engine)}; see the "
                "history for when it began",
                shorter=True,
            )
        if balance > CREATED_WARN and not early and not self.warned:
            self.warned = True
            warnings.warn(
                f"energy is being created: balance {balance:+.2%} at step {engine.step_number}, t = {engine.t:.6g} s; fastest is "
                f"{_fastest(engine)} ({_remedy(engine)}?)",
                stacklevel=6,
            )

    def facts(self) -> dict[str, Any]:
        """State as plain data."""
        return {"warned": self.warned, "fastest": self._fastest, "before": self._before}

    def recall(self, facts: dict[str, Any]) -> None:
        """Go back to this state; what was warned of once is not warned of again."""
        self.warned, self._fastest, self._before = self.warned or facts["warned"], facts["fastest"], facts["before"]


def _remedy(engine: Engine) -> str:
    stepper = engine.c.integrator or engine.c.discretization
    fixed = getattr(stepper, "dt", None)
    step = "lower cfl" if fixed is None else f"a smaller dt (now {fixed:.3g} s), or leave dt out for an automatic time step"
    return step + ("; with USL use MUSL" if type(stepper).__name__ == "USL" else "")


def _fastest(engine: Engine) -> str:
    most, told = -math.inf, "no particle"
    for store in engine.stores:
        if store.n:
            speed = np.linalg.norm(store.get("v"), axis=1)
            p = int(np.argmax(speed))  # of NaN, if there is one
            if not speed[p] <= most:
                most, told = float(speed[p]), f"particle {store.points_now()[p]} of body {store.name!r} with {speed[p]:.4g} m/s"
    return told
