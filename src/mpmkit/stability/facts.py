"""What cases and expected outcomes ask of components: declared facts, never names, so that third parties' components are covered too."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from mpmkit.testing.recipes import recipe

if TYPE_CHECKING:
    from mpmkit.stability.case import Composition


def strains_first(integrator: Any) -> bool:
    """Strains and stresses before the momentum update (USF)."""
    verbs = recipe(integrator)
    return verbs.index("strain") < verbs.index("momentum")


def strains_last_unmapped(integrator: Any) -> bool:
    """Strains from the updated nodal velocities as they are (USL): no second mapping, and not before the momentum."""
    return "remap" not in recipe(integrator) and not strains_first(integrator)


def strains_unmapped(c: Composition) -> bool:
    """The same of a composition."""
    return strains_last_unmapped(c.integrator)


def strains_raw(c: Composition) -> bool:
    """Strains from f_i / m_i as it is at the lightest nodes too, by slopes that jump."""
    return strains_unmapped(c) and "limit" not in recipe(c.integrator) and slopes_jump(c)


def maps_again(c: Composition) -> bool:
    """Strains from a second mapping of the new velocities (MUSL)."""
    return "remap" in recipe(c.integrator)


def filters(c: Composition) -> bool:
    """The particle takes the grid's velocity and carries nothing else (PIC)."""
    transfer = _transfer(c)
    return transfer is not None and transfer.affine == "none" and transfer.passes == 1 and "v" not in transfer.velocity.arguments


def filters_in_passes(c: Composition) -> bool:
    """The particle takes the grid's velocity, filtered in several passes (XPIC)."""
    transfer = _transfer(c)
    return transfer is not None and transfer.passes > 1 and "v" not in transfer.velocity.arguments


def carries_affine(c: Composition) -> bool:
    """The particle takes the grid's velocity and carries the affine part of the motion around it (APIC, MLS, TPIC)."""
    transfer = _transfer(c)
    return transfer is not None and transfer.affine != "none" and "v" not in transfer.velocity.arguments


def affine_by_moments(c: Composition) -> bool:
    """The affine part is that of first moments, by which rotation is conserved (APIC, MLS)."""
    transfer = _transfer(c)
    return transfer is not None and transfer.affine == "moment"


def gradient_by_moments(c: Composition) -> bool:
    """Gradients are those of a least-squares fit, first moments over the second moment of the weights (MLS)."""
    transfer = _transfer(c)
    return transfer is not None and transfer.gradient == "moment"


def keeps_velocities(c: Composition) -> bool:
    """The particle keeps its velocity and adds the change of the grid's (FLIP)."""
    transfer = _transfer(c)
    return transfer is not None and "v" in transfer.velocity.arguments


def keeps_first_size(c: Composition) -> bool:
    """Particles are boxes of the size they had at the start (GIMP)."""
    return bool(c.shape.particle_size == "initial")


def follows_size(c: Composition) -> bool:
    """Particles are boxes that are stretched with the body (contiguous GIMP)."""
    return bool(c.shape.particle_size == "current")


def slopes_jump(c: Composition) -> bool:
    """Particles are points, and slopes jump at cell faces (tents)."""
    return not c.shape.smooth and bool(c.shape.particle_size == "none")


def wide(c: Composition) -> bool:
    """Splines of four nodes and more."""
    return bool(c.shape.nodes >= 4 and c.shape.particle_size == "none")


def one_field(c: Composition) -> bool:
    """Bodies share one velocity field."""
    return c.contact is None


def single_precision(c: Composition) -> bool:
    """Numbers of 24 bits."""
    return c.precision == "float32"


def _transfer(c: Composition) -> Any:
    return getattr(c.integrator, "transfer", None)
