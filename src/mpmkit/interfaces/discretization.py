"""The contract of a discretization: how nodes and material points are tied together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import attrs

from mpmkit.interfaces.component import Component

if TYPE_CHECKING:
    from mpmkit.interfaces.recipe import Recipe


@attrs.frozen(eq=False)
class StoredPoints:
    """Material points of one body with neighbour lists made once.

    Attributes
    ----------
    x, V0, size, v
        As of sampled particles: float64[n, dim], [n], [n, dim], [n, dim].
    nodes : float64[k, dim]
        Positions of the body's own nodes [m].
    connectivity : int64[n, m]
        The m nodes of each point.
    N, dN : float64[n, m], float64[n, m, dim]
        Shape functions and their gradients with respect to X at the points.
    F, stress
        Initial state; None for the identity and zero.
    """

    x: Any
    V0: Any
    size: Any
    v: Any
    nodes: Any
    connectivity: Any
    N: Any
    dN: Any  # noqa: N815  (the literature's letters)
    F: Any = None
    stress: Any = None


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
    time_order : int
        Order of the error in the time step on a given mesh; 0 if none is claimed. Observed as for integrators.
    """

    kind: ClassVar[str] = "discretization"
    names_reach_kernels: ClassVar[bool] = False
    operator: ClassVar[str] = "grid"
    configuration: ClassVar[str] = "current"
    time_order: ClassVar[int] = 0

    @classmethod
    def capabilities(cls) -> dict[str, Any]:
        return super().capabilities() | {"operator": cls.operator, "order in time": cls.time_order or None}

    def nodes_per_point(self, dim: int) -> int:
        """For ``operator = "stored"``: length of the neighbour lists."""
        raise NotImplementedError(f"{type(self).__name__} must define nodes_per_point(dim)")

    def mesh(self, grid: Any, body: Any) -> StoredPoints:
        """For ``operator = "stored"``: nodes, points and their operators for one body."""
        raise NotImplementedError(f"{type(self).__name__} must define mesh(grid, body)")

    def step(self, s: Recipe) -> None:
        """Write one step as a sequence of verbs."""
        raise NotImplementedError(f"{type(self).__name__} must define step(s)")
