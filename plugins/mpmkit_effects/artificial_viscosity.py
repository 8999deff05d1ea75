"""Artificial viscosity for shocks."""

import mpmkit as mpm
from mpmkit.math import sqrt


@mpm.kernel
def shock_pressure(L, rho, c, h, linear, quadratic):
    """q = rho h |D| (c1 c + c2 h |D|) for D = tr L < 0, else 0."""
    D = L[0] + L[4] + L[8]
    if D >= 0.0:
        return 0.0 * D
    return -rho * h * D * (linear * c - quadratic * h * D)


@mpm.kernel
def damped_signal(L, c, h, linear, quadratic):
    """c (sqrt(1 + z^2) + z) with the damping ratio z = c1 + c2 h |D| / c: the explicit limit of a damped wave."""
    D = L[0] + L[4] + L[8]
    z = 0.0 * c
    if D < 0.0:
        z = linear - quadratic * h * D / c
    return c * (sqrt(1.0 + z * z) + z)


@mpm.define
class ArtificialViscosity(mpm.Effect):
    """Viscous pressure in compression only, q = rho h |D| (c1 c + c2 h |D|), D = div v < 0, added to the stress as -q I.

    A repair of SAND2002-0482 eqs 2-1 and 2-2, which as printed take the root of a negative number, have not the
    dimension of a stress and would pull where they should push. Spreads a shock over a few cells, always dissipates
    (its work q |D| V dt is in the ledger), and shortens the time step by the damping ratio z = c1 + c2 h |D| / c.
    """

    references = (
        "von Neumann and Richtmyer (1950), doi:10.1063/1.1699639",
        "Wilkins (1980), doi:10.1016/0021-9991(80)90161-8",
        "Chen and Brannon (2002), SAND2002-0482, eqs 2-1 and 2-2 (repaired)",
    )
    linear: float = mpm.parameter("coefficient c1 of the linear term", ge=0.0, le=2.0, default=0.2, example=0.2)
    quadratic: float = mpm.parameter("coefficient c2 of the quadratic term", ge=0.0, le=10.0, default=2.0, example=2.0)
    viscous_pressure = shock_pressure
    signal_speed = damped_signal
