"""What ten steps of one random scene may end in."""

from __future__ import annotations

import math
import re
import tempfile
import warnings
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import tomli_w
from judge_files import TooLong, unclear, within

import mpmkit as mpm
from mpmkit._core.running import loop, timestep
from mpmkit.errors import CompositionError, MpmkitError, StabilityError

STEPS = 10
SECONDS = 60.0
CREATED = 0.2
"""Energy made in ten steps under suddenly released stress: velocities lag by half a step."""
MOMENTUM = {"float64": 1e-11, "float32": 1e-3}


@attrs.frozen
class Outcome:
    """ "runs", "refused", "stopped" by a guard, or "fault"; with a text, and what was measured."""

    kind: str
    text: str = ""
    momentum: float = 0.0
    balance: float = 0.0
    steps: int = 0


class Enough(BaseException):
    """So many steps were taken."""


def judge(mild: bool, scene: dict[str, Any], *, seconds: float = SECONDS) -> Outcome:
    """Compose and run one scene for `STEPS` steps."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        scene = dict(scene)
        for record in scene.get("records", ()):
            scene["records"] = [record | {"path": str(Path(folder) / record["path"])}]
        try:
            with within(seconds):
                return _judge(mild, tomli_w.dumps(scene))
        except KeyboardInterrupt:
            raise
        except TooLong:
            return Outcome("fault", f"takes longer than {seconds:g} s")
        except BaseException as error:  # noqa: BLE001  that is what is looked for
            import traceback

            ours = [f for f in traceback.extract_tb(error.__traceback__) if "mpmkit" in f.filename or "generated" in f.filename]
            where = " < ".join(f"{Path(f.filename).name}:{f.lineno} ({f.line})" for f in ours[:-4:-1])
            return Outcome("fault", f"{type(error).__name__}: {error} at {where}")


def _judge(mild: bool, text: str) -> Outcome:
    sim = run = None
    try:
        sim = mpm.scene.loads(text)
        composed = sim.compose()
        first = timestep.next_step(composed.engine).dt
        run = composed
        run_steps(sim, first)
    except Enough:
        pass
    except StabilityError as error:
        wrong = imprecise(error, sim)
        steps = run.engine.step_number if run is not None else 0
        if wrong or (mild and not ("above the stable limit" in str(error) or "no rule limits" in str(error))):
            return Outcome("fault", f"{wrong or 'a mild scene'}: {error}", steps=steps)
        return Outcome("stopped", str(error), steps=steps)
    except MpmkitError as error:
        wrong = unclear(error, "load" if sim is None else "compose")
        if run is not None and run.engine.step_number > 0:
            wrong = f"only after {run.engine.step_number} steps"
        if mild and not wrong and sim is None:
            wrong = "a mild scene"
        if wrong:
            return Outcome("fault", f"{wrong}: {type(error).__name__}: {error}")
        return Outcome("refused", f"{type(error).__name__}: {error}")
    return measure(mild, sim)


def run_steps(sim: mpm.Simulation, first: float) -> None:
    """Ten steps, or as many more as a time step that becomes smaller takes, up to thirty."""
    before = timestep.next_step

    def counted(engine: Any) -> Any:
        if engine.step_number >= 3 * STEPS:
            raise Enough
        return before(engine)

    loop.timestep.next_step = counted
    try:
        sim.run(until=STEPS * first * 0.999, quiet=True)
    finally:
        loop.timestep.next_step = before


def measure(mild: bool, sim: mpm.Simulation) -> Outcome:
    """Everything finite, momentum kept, no energy out of nothing."""
    run = sim.compose()
    row = run.ledger.row(0.0)
    momentum, balance = momentum_error(run, sim.grid.space), float(row["balance"])
    found = {"momentum": momentum, "balance": balance, "steps": sim.step_number}
    for body in sim.bodies:
        for name, array in sim.particles(body).items():
            if not np.isfinite(array).all():
                return Outcome(
                    "fault", f"{name} of {body.name} is not finite after {sim.step_number} steps, and no guard has spoken", **found
                )
    for name, value in row.items():
        if not math.isfinite(value):
            return Outcome("fault", f"{name} in the history is {value}", **found)
    if not momentum <= MOMENTUM[sim.precision]:
        return Outcome("fault", f"momentum error {momentum:.3g} ({sim.precision})", **found)
    if mild and not balance <= CREATED:
        return Outcome("fault", f"energy was created: balance {balance:.3g}", **found)
    return Outcome("runs", **found)


def momentum_error(run: Any, space: str) -> float:
    """As `Run.momentum_error`, without the radial direction, in which hoop stresses push and nothing is kept."""
    if space != "axisymmetric":
        return float(run.momentum_error())
    first, last = run.rows[0], run.ledger.last
    given = last["impulse_y"] + last["force_impulse_y"]
    scale = max(sum(float((s.get("m")[:, None] * np.abs(s.get("v"))).sum()) for s in run._stores), abs(given))
    return abs(last["momentum_y"] - first["momentum_y"] - given) / scale if scale > 0.0 else 0.0


def imprecise(error: StabilityError, sim: Any) -> str:
    """What the message of a guard lacks."""
    text = str(error)
    if not re.search(r"at step \d+", text) and "no rule limits" not in text:
        return "a guard that does not say when"
    if "To fix: " not in text and "give the integrator" not in text:
        return "a guard that does not say what to do"
    return unclear(error, "run") if not isinstance(error, CompositionError) else ""
