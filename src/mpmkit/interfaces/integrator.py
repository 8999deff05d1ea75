"""The contracts of an integrator, the order of one step, and of the transfer it uses."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from mpmkit.interfaces.component import Component
from mpmkit.kernels import Kernel
from mpmkit.parameters import define, parameter

if TYPE_CHECKING:
    from mpmkit.interfaces.recipe import Recipe


class Transfer(Component):
    """How a particle's velocity follows from the grid.

    Attributes
    ----------
    velocity : Kernel
        Returns the new particle velocity in one direction from any of ``v`` (its old one), ``v_grid`` (interpolated
        from the updated grid), ``dv_grid`` (interpolated change of the grid velocity), ``v_smooth`` (interpolated
        from the filtered grid velocity, if ``passes`` > 1) and parameters.
    affine : str
        "none", "moment" (C = B D^-1 from the first moment, APIC) or "gradient" (C = grad v, TPIC): the particle
        carries C and maps v + C (x_i - x_p) to the nodes.
    gradient : str
        "shape" (forces and strains with the slopes of the shape functions) or "moment" (with N_i (x_i - x_p) D^-1, the
        gradient of a moving-least-squares fit; then affine must be "moment").
    passes : int
        XPIC: number of times the velocity passes between particles and grid; 1 for all others.
    angular_momentum : bool
        Whether angular momentum is conserved to rounding, that of the affine velocity fields included, with B-splines away from the
        boundary and with an integrator that claims the same.
    """

    kind: ClassVar[str] = "transfer"
    velocity: ClassVar[Kernel]
    affine: ClassVar[str] = "none"
    gradient: ClassVar[str] = "shape"
    passes: int = 1
    angular_momentum: ClassVar[bool] = False

    @classmethod
    def capabilities(cls) -> dict[str, object]:
        return super().capabilities() | {"affine": cls.affine, "conserves angular momentum": cls.angular_momentum}


class Integrator(Component):
    """The order of one step: a recipe of verbs that can be held against the paper.

    A subclass writes ``step(self, s)``; the verbs of ``s`` are documented in `mpmkit.interfaces.recipe.Recipe`.

    Attributes
    ----------
    time_order : int
        Order of the error in the time step on a given grid; 0 if none is claimed. The conformance suite observes it, for integrators with
        a parameter ``dt``.
    angular_momentum : bool
        Whether angular momentum is conserved to rounding with a transfer that claims the same.
    """

    kind: ClassVar[str] = "integrator"
    names_reach_kernels: ClassVar[bool] = False
    time_order: ClassVar[int] = 0
    angular_momentum: ClassVar[bool] = False

    @classmethod
    def capabilities(cls) -> dict[str, object]:
        more = {"order in time": cls.time_order or None, "conserves angular momentum": cls.angular_momentum}
        return super().capabilities() | more

    def step(self, s: Recipe) -> None:
        """Write one step as a sequence of verbs; called once, when the simulation is composed."""
        raise NotImplementedError(f"{type(self).__name__} must define step(self, s)")


@define
class ExplicitIntegrator(Integrator):
    """An explicit integrator: what USF, USL and MUSL have in common. A subclass adds its parameter ``transfer``."""

    time_order: ClassVar[int] = 1
    angular_momentum: ClassVar[bool] = True
    transfer: ClassVar[Transfer]
    cfl: float = parameter("time step as a fraction of h / (|v| + c)", gt=0.0, le=1.0, default=0.4, kw_only=True)
    dt: float | None = parameter("fixed time step; automatic if not given", unit="s", gt=0.0, default=None, kw_only=True)
    strain: str = parameter(
        "update of F: exp(dt L) F; Cayley's midpoint form; (I + dt L) F as printed; or from L in the middle of the displacement, "
        "with which a body that spins freely does not swell",
        choices=("exponential", "midpoint", "first-order", "centred"),
        default="exponential",
        kw_only=True,
    )
    mass: str = parameter(
        "mass matrix; consistent is dense and for small problems in which no moving body meets a wall",
        choices=("lumped", "consistent"),
        default="lumped",
        kw_only=True,
    )
