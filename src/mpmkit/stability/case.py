"""What a hard case is: a scene that goes wrong easily, the figure that shows it, and the limit that figure must keep."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal

import attrs

if TYPE_CHECKING:
    from mpmkit.interfaces import ContactModel, ExplicitIntegrator, Material, ShapeFunction
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
    integrator: ExplicitIntegrator
    contact: ContactModel | None = None
    precision: str = "float64"
    material: Material | None = None
    extra: tuple[Any, ...] = ()

    @property
    def label(self) -> str:
        """Short name for a table, for example ``Quadratic · MUSL/FLIP · float64``."""
        transfer = getattr(self.integrator, "transfer", None)
        stepper = type(self.integrator).__name__ + (f"/{_told(transfer)}" if transfer is not None else "")
        parts = [_told(self.shape), stepper, *([_told(self.contact)] if self.contact is not None else [])]
        parts += [_told(one) for one in ((self.material,) if self.material is not None else ()) + self.extra]
        return " · ".join([*parts, *([self.precision] if self.precision != "float64" else [])])


@attrs.frozen
class Figure:
    """One number that a case measures and the limit that it must keep, both without a sign: |value| <= limit holds."""

    name: str
    value: float
    limit: float

    @property
    def margin(self) -> float:
        """|value| / limit: at most 1 if it holds."""
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
    """

    status: Status
    figures: tuple[Figure, ...] = ()
    reason: str = ""


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
    applies: Callable[[Composition], str] = lambda composition: ""
    waits_for: str = ""
    material: bool = False


def simulation(composition: Composition, grid: Any, **settings: Any) -> Simulation:
    """An empty simulation with the components of a composition, to which a case adds its bodies."""
    import mpmkit as mpm

    sim = mpm.Simulation(grid, composition.shape, composition.integrator, precision=composition.precision, **settings)
    for one in composition.extra:
        sim += one
    return sim


def _told(component: Any) -> str:
    """Name of a component with what differs from its defaults."""
    cls = type(component)
    changed = [
        f"{a.name}={getattr(component, a.name)!r}"
        for a in attrs.fields(cls)
        if a.init and a.name != "transfer" and getattr(component, a.name) != (a.default.factory() if hasattr(a.default, "factory") else a.default)
    ]
    return f"{cls.__name__}({', '.join(changed)})" if changed else cls.__name__
