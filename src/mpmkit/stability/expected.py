"""Outcomes that theory foretells: cases that do not hold under some compositions, with the reason and the remedy.

A rule that says so of a cell that holds is an error: it has to be mended or removed. What is unstable for a user too belongs to
`mpmkit._core.composing.cautions`, whose rules explain cells as well.
"""

from __future__ import annotations

from collections.abc import Callable

import attrs

from mpmkit._core.composing.cautions import CAUTIONS
from mpmkit.stability.case import Composition, Status, Verdict


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


def _stress_last_once(c: Composition) -> bool:
    """USL: strains from the updated velocities, without a second mapping; dissipative, and judged by energy gained only."""
    from mpmkit.interfaces.recipe import Recipe

    recipe = Recipe()
    c.integrator.step(recipe)
    return "remap" not in recipe.verbs and recipe.verbs.index("momentum") < recipe.verbs.index("strain")


PIC_LOSES = (
    "in every step PIC maps velocities to the nodes and back, which multiplies a wave of wave number k by 1 - (k h)^2 / 4 (quadratic "
    "splines), so that energy is lost at a rate that grows with the number of steps (Brackbill and Ruppel 1986)"
)

EXPECTED: tuple[Expected, ...] = (
    Expected(
        cases=("vibrating-bar",),
        when=lambda c: _filters(c) and not _stress_last_once(c),
        reason=PIC_LOSES,
        remedy="FLIP, APIC or another transfer that keeps what the grid cannot see",
    ),
    Expected(cases=("sudden-load",), when=_filters, reason=PIC_LOSES, remedy="FLIP, APIC, or a finer grid"),
    Expected(
        cases=("vibrating-bar",),
        when=lambda c: c.shape.nodes >= 4 and c.shape.particle_size == "none" and not _stress_last_once(c),
        reason=(
            "the error of the period is of second order in the cell and larger the wider the shape function: cubic splines reach two cells "
            "beyond a particle, and 13 cells are few for that (0.47 %, limit 0.3 %; 0.12 % with 26 cells)"
        ),
        remedy="twice the cells, or quadratic splines",
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
