"""One case under one composition: what was measured, and the verdict."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any

import attrs

from mpmkit.errors import CompositionError, MpmkitError, StabilityError
from mpmkit.stability.case import ENERGY_MADE, Case, Composition, Figure, Status, Verdict, watched

if TYPE_CHECKING:
    from mpmkit.simulation import Simulation

MOMENTUM_ERROR = {"float64": 1e-9, "float32": 1e-3}
"""Largest relative momentum error with a component under test, by precision: rounding of some thousand steps."""
KEPT = "\nlast good state"
"""Where the words of a stopped run about its last good state begin: the files of a cell are gone when it is read."""
SETTLED = 100
"""Steps before the balance of energy counts: velocities lag by half a step, which after n steps of a sudden load is 1 / (2 n)."""


def judge(case: Case, composition: Composition, quick: bool = False) -> Verdict:
    """Run a case under a composition; nothing that the case, a component or a guard raises comes out of here.

    With an effect or boundary layer under test (`Composition.extra`) the exact solution of the case no longer holds, so only what holds
    for every scene is judged: the run comes to its end, energy is not made, momentum comes from impulses.
    """
    if case.waits_for:
        return Verdict("waiting", reason=f"waits for {case.waits_for}")
    with warnings.catch_warnings(), watched() as made:
        warnings.simplefilter("ignore")
        figures: tuple[Figure, ...] = ()
        status: Status | None = None
        reason = ""
        try:
            figures = tuple(case.measure(composition, quick))
        except CompositionError as error:
            status, reason = "refused", str(error)
        except StabilityError as error:
            status, reason = "fails", str(error).split(KEPT)[0]
        except (KeyboardInterrupt, SystemExit):
            raise
        except BaseException as error:  # noqa: BLE001  a component under test may raise anything; the suite goes on
            status, reason = "fails", f"unexpected {type(error).__name__}: {error}"
            if isinstance(error, MpmkitError):
                reason = f"{type(error).__name__}: {error}"
    energy, created, momentum = _ledgers(made)
    found = Verdict("holds", figures, reason, energy, momentum, _cautions(made))
    if status is not None:
        return attrs.evolve(found, status=status)
    if composition.extra:
        found = attrs.evolve(found, figures=_universal(composition, created, momentum))
    return attrs.evolve(found, status=_status(found.figures, created), reason=_worst(found.figures, created))


def _status(figures: tuple[Figure, ...], created: float) -> Status:
    if not all(math.isfinite(f.value) for f in figures):
        return "fails"
    if all(f.margin <= 1.0 for f in figures):
        return "holds"
    return "fails" if created > ENERGY_MADE else "bounded"


def _worst(figures: tuple[Figure, ...], created: float) -> str:
    """The figures that are beyond their limits, in words; "" if none is."""
    beyond = [f"{f.name} is {f.value:.3g}, the limit {f.limit:.3g}" for f in figures if not f.margin <= 1.0]
    if beyond and created > ENERGY_MADE:
        beyond.append(f"energy made: {created:.3g} of the largest energy of the run")
    return "; ".join(beyond)


def _universal(composition: Composition, created: float, momentum: float | None) -> tuple[Figure, ...]:
    return (
        Figure("energy made", max(created, 0.0), ENERGY_MADE),
        Figure("momentum error", math.nan if momentum is None else momentum, MOMENTUM_ERROR[composition.precision]),
    )


def _ledgers(made: list[Simulation]) -> tuple[float | None, float, float | None]:
    """Largest error of energy, largest energy made, largest error of momentum, of all simulations that have stepped."""
    energy: float | None = None
    momentum: float | None = None
    created = 0.0
    for sim in made:
        run: Any = sim._run
        if run is None or len(run.rows) < 2:
            continue
        balances = [row["balance"] for row in run.rows if row["step"] >= SETTLED] or [run.rows[-1]["balance"]]
        energy = max([abs(energy or 0.0), *map(abs, balances)], key=_size)
        created = max([created, *balances], key=_size)
        momentum = max(momentum or 0.0, run.momentum_error(), key=_size)
    return energy, created, momentum


def _size(value: float) -> float:
    """For a comparison in which what is not a number is the worst."""
    return math.inf if math.isnan(value) else value


def _cautions(made: list[Simulation]) -> tuple[str, ...]:
    from mpmkit._core.composing import cautions

    runs = [sim._run for sim in made if sim._run is not None]
    return tuple(sorted({one.name for run in runs for one in cautions.found(run.plan.composition)}))
