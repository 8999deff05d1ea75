"""Outcomes that theory foretells: cases that do not hold under some compositions, with the reason and the remedy.

A rule that says so of a cell that holds is an error: it has to be mended or removed. What is unstable for a user too belongs to
`mpmkit._core.composing.cautions`, whose rules explain cells as well.
"""

from __future__ import annotations

from collections.abc import Callable

import attrs

from mpmkit._core.composing.cautions import CAUTIONS
from mpmkit.stability.case import Composition, Status, Verdict
from mpmkit.stability.facts import strains_first, strains_last_unmapped


@attrs.frozen
class Expected:
    """One rule.

    Attributes
    ----------
    cases : tuple of str
        Names of the cases it is about.
    when : callable
        ``when(composition) -> bool``.
    reason, remedy : str
        Why by theory, and what to do instead.
    status : tuple of str
        What is foretold.
    quick : bool
        Whether it shows in quick runs too; if not, a quick run may hold.
    """

    cases: tuple[str, ...]
    when: Callable[[Composition], bool]
    reason: str
    remedy: str
    status: tuple[Status, ...] = ("bounded",)
    quick: bool = True


@attrs.frozen
class Explanation:
    """Why a cell does not hold.

    Attributes
    ----------
    by : str
        The caution, or "expected".
    reason, remedy : str
        By theory; what to do instead.
    """

    by: str
    reason: str
    remedy: str


def _filters(c: Composition) -> bool:
    """PIC: the particle takes the grid's velocity and carries nothing else."""
    transfer = getattr(c.integrator, "transfer", None)
    return transfer is not None and transfer.affine == "none" and transfer.passes == 1 and "v" not in transfer.velocity.arguments


def _affine_by_moment(c: Composition) -> bool:
    """APIC."""
    transfer = getattr(c.integrator, "transfer", None)
    return transfer is not None and transfer.affine == "moment" and transfer.gradient == "shape"


def _keeps_first_size(c: Composition) -> bool:
    """GIMP: particles are boxes of the size they had at the start."""
    return bool(c.shape.particle_size == "initial")


PIC_LOSES = (
    "in every step PIC maps velocities to the nodes and back, which multiplies a wave of wave number k by 1 - (k h)^2 / 4 (quadratic "
    "splines), so that energy is lost at a rate that grows with the number of steps (Brackbill and Ruppel 1986)"
)

EXPECTED: tuple[Expected, ...] = (
    Expected(
        cases=("vibrating-bar",),
        when=lambda c: _filters(c) and not strains_last_unmapped(c.integrator),
        reason=PIC_LOSES,
        remedy="FLIP, APIC or another transfer that keeps what the grid cannot see",
    ),
    Expected(cases=("sudden-load",), when=_filters, reason=PIC_LOSES, remedy="FLIP, APIC, or a finer grid"),
    Expected(
        cases=("vibrating-bar",),
        when=lambda c: c.shape.nodes >= 4 and c.shape.particle_size == "none" and not strains_last_unmapped(c.integrator),
        reason=(
            "the error of the period is of second order in the cell and larger the wider the shape function: cubic splines reach two cells "
            "beyond a particle, and 13 cells are few for that (0.47 %, limit 0.3 %; 0.12 % with 26 cells)"
        ),
        remedy="twice the cells, or quadratic splines",
    ),
    Expected(
        cases=("crushed", "rank-one-collapse", "stiffening"),
        when=_affine_by_moment,
        reason=(
            "of the motion within a cell APIC keeps the affine part; what is left, the motion from particle to particle, is lost in each "
            "mapping, and in a lattice that is crushed or let go at a large stretch it carries a tenth of the energy (Jiang et al. 2015)"
        ),
        remedy="FLIP, or more cells",
    ),
    Expected(
        cases=("galilean",),
        when=_affine_by_moment,
        reason=(
            "what APIC loses in a mapping depends on where particles lie between the nodes, so an offset of the grid or a flight through "
            "it changes the energy that an impact leaves, by 2 and 5 % with 20 cells; momentum and angular momentum are kept to rounding"
        ),
        remedy="FLIP, or more cells",
    ),
    Expected(
        cases=("thin-wall",),
        when=_affine_by_moment,
        reason=(
            "the affine part extrapolates a particle's velocity to nodes a cell away, v + C (x_i - x_p), and the time step knows of "
            "|v| but not of |C| h: a sheet of one layer that is stopped at a wall within a step throws particles past it"
        ),
        remedy="a smaller cfl, or FLIP",
    ),
    Expected(
        cases=("crushed", "rank-one-collapse"),
        when=lambda c: strains_first(c.integrator),
        reason=(
            "USF takes stresses at the beginning of a step and uses them to its end: half a step ahead of the trapezoidal rule, which in "
            "a motion that turns round within some ten steps gives back more than was stored, by an amount that goes with dt"
        ),
        remedy="MUSL, or a smaller cfl",
    ),
    Expected(
        cases=("numerical-fracture", "shock"),
        when=_keeps_first_size,
        reason=(
            "boxes that keep their first size leave gaps when the body is stretched and overlap when it is compressed: the weights of a "
            "row of particles then no longer add up to a constant, and stress oscillates from cell to cell (Steffen et al. 2008)"
        ),
        remedy="ContiguousGIMP or a spline",
    ),
)
"""All rules."""


def explain(case: str, composition: Composition, verdict: Verdict) -> Explanation | None:
    """The explanation of a cell that does not hold; None if there is none."""
    for one in CAUTIONS:
        if one.name in verdict.cautions and case in one.shown_by:
            return Explanation(f"caution: {one.name}", one.reason, one.remedy)
    for rule in EXPECTED:
        if case in rule.cases and verdict.status in rule.status and rule.when(composition):
            return Explanation("expected", rule.reason, rule.remedy)
    return None


def contradicted(case: str, composition: Composition, verdict: Verdict, quick: bool) -> str:
    """What foretold that a cell that holds would not; "" if nothing did."""
    if verdict.status != "holds":
        return ""
    for one in CAUTIONS:
        if one.name in verdict.cautions and case in one.shown_by:
            return f"the caution {one.name!r} says that it shows in {case!r}, which holds"
    for rule in EXPECTED:
        if case in rule.cases and (rule.quick or not quick) and rule.when(composition):
            return f"the rule {rule.reason[:60]!r}... foretells {' or '.join(rule.status)}, but it holds"
    return ""
