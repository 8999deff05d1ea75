"""What cases and expected outcomes ask of an integrator: when its recipe takes strains, and from which velocities."""

from __future__ import annotations

from typing import Any

from mpmkit.testing.recipes import recipe


def strains_first(integrator: Any) -> bool:
    """Strains and stresses before the momentum update (USF)."""
    verbs = recipe(integrator)
    return verbs.index("strain") < verbs.index("momentum")


def strains_last_unmapped(integrator: Any) -> bool:
    """Strains from the updated nodal velocities as they are (USL): no second mapping, and not before the momentum."""
    return "remap" not in recipe(integrator) and not strains_first(integrator)
