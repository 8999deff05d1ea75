"""The contract of a contact algorithm: what two bodies do to each other at a node they share."""

from __future__ import annotations

from typing import ClassVar

from mpmkit.interfaces.component import Component
from mpmkit.kernels import Kernel


class ContactAlgorithm(Component):
    """The impulse between two bodies at one shared node, each body having its own velocity field.

    The core finds the shared nodes, the normal (from body a to body b) and the gap between the bodies' surfaces, and
    applies the impulse to a and its opposite to b, so that momentum is conserved exactly whatever the kernel returns.

    Attributes
    ----------
    impulse : Kernel
        Returns the impulse on body a (x, y, z) [N s]. May ask for ``m_a, v_a, m_b, v_b`` (nodal masses and
        velocities as three numbers), ``normal`` (unit vector from a to b), ``gap`` [m] (negative when the bodies
        overlap), ``dt`` and parameters.
    """

    kind: ClassVar[str] = "contact"
    impulse: ClassVar[Kernel]
