"""Copper plates at kilometres per second: they wait for a shock equation of state."""

from __future__ import annotations

from mpmkit.stability.case import Case, Composition, Figure


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Nothing to measure before the equation of state exists."""
    return []


CASE = Case(
    name="copper-plates",
    title="Two copper plates meet at 1 and 4 km/s",
    failure="Ringing behind the shock, tension where there should be pressure, a wrong shock speed; the work of the artificial viscosity "
    "must heat the material.",
    criterion="Symmetric impact, c0 = 3940 m/s, s = 1.489; at 1 km/s: shock speed within 1 % of 4684.5 m/s, pressure within 2 % of "
    "20.916 GPa, density within 1 % of 9997.0 kg/m^3, overshoot below 10 %, q : D >= 0 in every step.",
    source="Rankine-Hugoniot conditions; S.P. Marsh (1980), LASL Shock Hugoniot Data (copper)",
    dim=1,
    measure=measure,
    waits_for="a shock equation of state (Mie-Grueneisen with a linear Hugoniot)",
)
