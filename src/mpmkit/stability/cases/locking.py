"""Nearly incompressible solids in bending and in plastic flow: both wait for an effect against locking."""

from __future__ import annotations

from mpmkit.stability.case import Case, Composition, Figure

EFFECT = "an effect against volumetric locking (F-bar, B-bar or a cell-averaged J)"


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Nothing to measure before the effect exists."""
    return []


CASES = (
    Case(
        name="cooks-membrane",
        title="Cook's membrane with nu = 0.4999",
        failure="With one volume constraint for each particle there are more constraints than degrees of freedom: the membrane is locked "
        "to "
        "less than 70 % of its deflection, and the pressure is a checkerboard.",
        criterion="Plane strain, E = 240.565, nu = 0.4999, load 100: deflection at (48, 52) within 5 % of 7.69 with 32 cells on the loaded "
        "side, pressures of neighbours within 20 % of the mean.",
        source="R.D. Cook (1974), Improved two-dimensional finite element, J. Struct. Div. 100; converged finite elements",
        dim=2,
        measure=measure,
        waits_for=EFFECT,
    ),
    Case(
        name="weak-footing",
        title="Footing on a weightless cohesive half-space",
        failure="Plastic flow keeps the volume: locked particles carry a load that rises without a limit.",
        criterion="Perfectly plastic, cohesion c: plateau of the mean pressure within -0 and +5 % of 5.1416 c.",
        source="L. Prandtl (1920), Ueber die Haerte plastischer Koerper; (2 + pi) c",
        dim=2,
        measure=measure,
        waits_for=EFFECT,
    ),
)
