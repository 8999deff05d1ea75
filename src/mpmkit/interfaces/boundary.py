"""The contract of a boundary layer: conditions carried by nodes, or by layers of particles."""

from __future__ import annotations

from typing import Any, ClassVar

import attrs

from mpmkit.interfaces.component import Component
from mpmkit.kernels import Kernel


@attrs.frozen(eq=False)
class Selection:
    """Particles of a layer: numbers int[n], the area float[n] each stands for, normals float[n, 3], vectors to the boundary float[n, 3]."""

    chosen: Any
    area: Any
    normals: Any
    arms: Any


class BoundaryLayer(Component):
    """An essential condition on nodes, or a natural condition carried by particles.

    A layer supplies either the node hooks or the particle hook.

    Attributes
    ----------
    constrain : Kernel
        Node hook. Returns the admissible velocity (x, y, z) for a nodal velocity ``v``; applying it twice changes
        nothing more. May ask for ``v``, ``normal`` (unit vector out of the domain, for a layer on faces), ``x`` (of
        the node), ``t``, ``value`` (if it has a parameter of type `Value`) and parameters.
    hold : Kernel
        Node hook of a layer that lets nodes go (a wall). ``constrain`` then decides by the velocity that the forces alone
        would give whether the layer acts; where it does, ``hold`` is the condition on all velocities of the node,
        whatever their sign, so that a wall at rest does no work. Of recipes that strain first, the strain is formed
        with the nodes held that were in the step before.
    rub : Kernel
        Node hook, called after ``constrain`` in the momentum update. Returns the velocity after friction; may
        moreover ask for ``dv_n``, the normal velocity that ``constrain`` has just taken away (>= 0).
    load : Kernel
        Particle hook. Returns ``(force, arm)``: the force (x, y, z) [N] on the particle and the vector (x, y, z)
        from the particle to the point where it acts; mapped to the nodes as f_i = force (N_i + arm . grad N_i). May
        ask for ``traction`` (value of the layer's traction), ``area`` [m^2], ``normal``, ``arm0`` (initial vector to
        the boundary), ``F``, ``J``, ``V``, ``V0``.
    bilateral : bool
        True if ``constrain`` prescribes components whatever the velocity is (needed by a consistent mass matrix).
    """

    kind: ClassVar[str] = "boundary"
    constrain: ClassVar[Kernel | None] = None
    hold: ClassVar[Kernel | None] = None
    rub: ClassVar[Kernel | None] = None
    load: ClassVar[Kernel | None] = None

    @property
    def bilateral(self) -> bool:
        return True

    def faces_of(self, grid: Any) -> tuple[str, ...]:
        """Faces of the domain this layer acts on ("xmin", "xmax", "ymin" ...); empty for a layer of particles."""
        return ()

    def nodes_in(self, x: Any, t: float) -> Any:
        """For a layer on nodes that are not on faces: bool[n] for node positions float[n, dim] at time t; None otherwise."""
        return None

    def select(self, points: Any, grid: Any) -> Selection | None:
        """For a layer of particles: which particles of its body carry the load, from the sampled `Points`."""
        return None

    def speed(self) -> float:
        """Largest speed [m/s] this layer prescribes, for the time step."""
        return 0.0
