"""The contract of a discretization: how nodes and material points are tied together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from mpmkit.interfaces.component import Component

if TYPE_CHECKING:
    from mpmkit.interfaces.recipe import Recipe


class Discretization(Component):
    """The operators N_ip and G_ip = grad N_i(x_p) between nodes i and material points p, and the order of one step.

    Materials, boundary layers, effects, records and the ledger see points and nodes only, so they work unchanged
    with every discretization.

    Attributes
    ----------
    operator : str
        "grid" (rebuilt every step from a background grid by a `ShapeFunction`: MPM) or "stored" (neighbour lists
        made once by ``mesh``: FEM, RKPM ...).
    configuration : str
        "current" (gradients with respect to x, Cauchy stress) or "reference" (with respect to X, first Piola-Kirchhoff stress).
    """

    kind: ClassVar[str] = "discretization"
    operator: ClassVar[str] = "grid"
    configuration: ClassVar[str] = "current"

    def mesh(self, grid: Any, geometry: Any) -> Any:
        """For ``operator = "stored"``: nodes, points and their operators for one body; returns a `StoredOperator`."""
        raise NotImplementedError

    def step(self, s: Recipe) -> None:
        """Write one step as a sequence of verbs."""
        raise NotImplementedError
