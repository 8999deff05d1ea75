"""The contract of an effect: anything else a scene may call for."""

from __future__ import annotations

from typing import ClassVar

from mpmkit.interfaces.component import Component
from mpmkit.kernels import Kernel


class Effect(Component):
    """Something that acts on all bodies; it supplies only the hooks it needs, and costs nothing where it has none.

    Attributes
    ----------
    acceleration : Kernel, optional
        Node hook. Returns the acceleration (x, y, z) [m/s^2] of a node; may ask for ``v`` (of the node), ``x``, ``t``, ``dt``.
    body_force : Kernel, optional
        Particle hook. Returns the force per mass (x, y, z) [m/s^2]; may ask for ``x``, ``X``, ``v``, ``t``, ``value``.
    viscous_pressure : Kernel, optional
        Particle hook. Returns a pressure q >= 0 [Pa] that is added to the stress as -q I; may ask for L, ``rho``,
        ``c``, ``h``. The field ``q`` is stored and its work is counted as dissipated.
    signal_speed : Kernel, optional
        Particle hook. Returns the speed [m/s] that replaces ``c`` in the limit of the time step.
    work : str
        Ledger column of node and body forces: "external" or "dissipated".
    """

    kind: ClassVar[str] = "effect"
    acceleration: ClassVar[Kernel | None] = None
    body_force: ClassVar[Kernel | None] = None
    viscous_pressure: ClassVar[Kernel | None] = None
    signal_speed: ClassVar[Kernel | None] = None
    work: ClassVar[str] = "external"

    def rates(self) -> dict[str, float]:
        """Limits of the time step that are not waves: rule name -> rate [1/s]; dt <= 1 / rate."""
        return {}
