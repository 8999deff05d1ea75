"""What a hard case is: a scene that goes wrong easily, the figure that shows it, and the limit that figure must keep."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any, Literal

import attrs

if TYPE_CHECKING:
    from mpmkit.interfaces import ConstitutiveModel, ContactAlgorithm, ShapeFunction
    from mpmkit.simulation import Simulation

Status = Literal["holds", "bounded", "fails", "refused", "waiting"]
"""holds: every figure is within its limit. bounded: some are not, but the run came to its end and made no energy. fails: a guard
stopped the run, something is not finite, or energy was made. refused: the composition is refused before the first step. waiting: the
case needs a component that the kit does not have yet."""

ENERGY_MADE = 0.05
"""Energy made, relative to the largest energy of the run, above which a run that came to its end has failed."""


@attrs.frozen
class Composition:
    """One choice of components, under which a case is run.

    Attributes
    ----------
    shape, integrator : component
        Shape function; integrator with its transfer.
    contact : component or None
        What cases with several bodies use; None lets them share one field.
    precision : str
        ``"float64"`` or ``"float32"``.
    material : component or None
        A constitutive model in place of the one of the case, for models under test.
    extra : tuple of component
        Effects or boundary layers under test, added to the scene.
    """

    shape: ShapeFunction
    integrator: Any  # an ExplicitIntegrator
    contact: ContactAlgorithm | None = None
    precision: str = "float64"
    material: ConstitutiveModel | None = None
    extra: tuple[Any, ...] = ()

    @property
    def label(self) -> str:
        """Short name for a table, for example ``Quadratic · MUSL/FLIP · float64``."""
        transfer = getattr(self.integrator, "transfer", None)
        stepper = told(self.integrator) + (f"/{told(transfer)}" if transfer is not None else "")
        parts = [told(self.shape), stepper, *([told(self.contact)] if self.contact is not None else [])]
        parts += [told(one) for one in ((self.material,) if self.material is not None else ()) + self.extra]
        return " · ".join([*parts, *([self.precision] if self.precision != "float64" else [])])


@attrs.frozen
class Figure:
    """One number that a case measures and the limit that it must keep, both without a sign: |value| <= limit holds.

    A limit of zero asks for exactly zero.
    """

    name: str
    value: float
    limit: float

    @property
    def margin(self) -> float:
        """|value| / limit: at most 1 if it holds; infinite for what is not a number, and for anything but zero where the limit is zero."""
        if math.isnan(self.value):
            return math.inf
        if self.limit == 0.0:
            return 0.0 if self.value == 0.0 else math.inf
        return abs(self.value) / self.limit


@attrs.frozen
class Verdict:
    """What became of one case under one composition.

    Attributes
    ----------
    status : str
        See `Status`.
    figures : tuple of Figure
        What was measured; empty if the run did not come to its end.
    reason : str
        The message of the guard, of the refusal, or of what the case waits for.
    energy : float or None
        Largest energy made or lost by any of the case's runs, relative to the largest energy of that run; None if none was run.
    momentum : float or None
        Largest momentum that appeared without an impulse, relative to all momenta of that run; None if none was run.
    cautions : tuple of str
        Names of the cautions with which the composition warned (`mpmkit._core.composing.cautions`).
    """

    status: Status
    figures: tuple[Figure, ...] = ()
    reason: str = ""
    energy: float | None = None
    momentum: float | None = None
    cautions: tuple[str, ...] = ()

    @property
    def margin(self) -> float | None:
        """The worst margin of all figures; None if nothing was measured."""
        return max((f.margin for f in self.figures), default=None)


def to_all(composition: Composition) -> str:
    """The case says something about every composition."""
    return ""


@attrs.frozen
class Case:
    """A hard case.

    Attributes
    ----------
    name : str
        As on the command line: ``free-flight``.
    title : str
        One line.
    failure : str
        What typically goes wrong, and why.
    criterion : str
        The sharp criterion in words, with its numbers.
    source : str
        Where the case or its numbers come from.
    dim : int
        Dimensions of the space.
    measure : callable
        ``measure(composition, quick) -> list[Figure]``: makes the scene, runs it, and measures. With ``quick`` a shorter or coarser run
        with the same criterion. May raise CompositionError (refused) or StabilityError (fails).
    contact : bool
        Whether the case has bodies that meet, so that contact algorithms are varied too.
    applies : callable
        ``applies(composition) -> str``: why the case says nothing about this composition, or "".
    waits_for : str
        What the kit must have before the case can be run; "" if it can.
    material : bool
        Whether another constitutive model can take the place of the one of the case.
    """

    name: str
    title: str
    failure: str
    criterion: str
    source: str
    dim: int
    measure: Callable[[Composition, bool], list[Figure]]
    contact: bool = False
    applies: Callable[[Composition], str] = to_all
    waits_for: str = ""
    material: bool = False


_WATCHED: ContextVar[list[Any] | None] = ContextVar("simulations of the case being measured", default=None)


@contextmanager
def watched() -> Iterator[list[Simulation]]:
    """The simulations that `simulation` makes in this block, so that their ledgers can be looked at."""
    made: list[Any] = []
    token = _WATCHED.set(made)
    try:
        yield made
    finally:
        _WATCHED.reset(token)


def simulation(composition: Composition, grid: Any, **settings: Any) -> Simulation:
    """An empty simulation with the components of a composition, to which a case adds its bodies; its ledger is watched.

    Failed steps are not repeated with a smaller Courant number: what is judged is the composition, not the rescue.
    """
    import mpmkit as mpm

    settings = {"precision": composition.precision, "retries": 0} | settings
    sim: Simulation = mpm.Simulation(grid, composition.shape, composition.integrator, **settings)
    for one in composition.extra:
        sim += one
    made = _WATCHED.get()
    if made is not None:
        made.append(sim)
    return sim


def told(component: Any) -> str:
    """Name of a component with what differs from its defaults; the transfer of an integrator is not said."""
    cls = type(component)
    changed = [
        f"{a.name}={_short(getattr(component, a.name))}"
        for a in attrs.fields(cls)
        if a.init and a.name != "transfer" and a.default is not attrs.NOTHING and getattr(component, a.name) != _default(a)
    ]
    return f"{cls.__name__}({', '.join(changed)})" if changed else cls.__name__


def _default(attribute: Any) -> Any:
    return attribute.default.factory() if hasattr(attribute.default, "factory") else attribute.default


def _short(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
