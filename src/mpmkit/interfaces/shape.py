"""The contract of a shape function: weights and slopes in one direction."""

from __future__ import annotations

from typing import ClassVar

from mpmkit.interfaces.component import Component
from mpmkit.kernels import Kernel


class ShapeFunction(Component):
    """Weights of the nodes around a particle in one direction; the core forms the products over the directions.

    With xi the particle's coordinate in cells, the first node is ``floor(xi - offset)`` and ``f = xi - first`` is
    the local coordinate. Near the boundary of the domain the core folds the weight of a node outside into the two
    outermost nodes, as if the field were continued linearly: a missing node's value is 2 v_0 - v_1. So partition of
    unity, linear reproduction and the sum of gradients stay exact, and the outermost node is interpolating.

    Attributes
    ----------
    nodes : int
        Nodes in one direction; a property where it depends on parameters.
    offset : float
        See above: 0 for nodes = 2, 0.5 for 3 nodes around the nearest, 1 for 4.
    weights : Kernel
        ``weights(f)`` or ``weights(f, half)`` returns (weights, slopes), two tuples of length ``nodes``; the slopes
        are derivatives with respect to xi. ``half`` is half the particle's edge in cells.
    particle_size : str
        "none", "initial" (half is constant) or "current" (half follows F, the box has the second moments of the deformed particle).
    order : int
        Highest degree that is reproduced in one cell (1 for linear and GIMP, 2, 3).
    smooth : bool
        Whether slopes are continuous. If not, the affine matrix of APIC and TPIC is formed with velocities whose change
        is limited at nodes lighter than half a particle.
    max_half : float
        Largest ``half`` [cells] for which ``nodes`` suffices.
    positive : bool
        Whether no weight is ever negative. With negative weights a node may be left with no mass, or less than none.
    """

    kind: ClassVar[str] = "shape"
    nodes: int = 2
    offset: float = 0.0
    weights: ClassVar[Kernel]
    particle_size: ClassVar[str] = "none"
    order: ClassVar[int] = 1
    smooth: ClassVar[bool] = True
    max_half: float = 0.5
    positive: ClassVar[bool] = True

    @classmethod
    def capabilities(cls) -> dict[str, object]:
        return super().capabilities() | {"order": cls.order, "particle size": cls.particle_size, "positive": cls.positive}
