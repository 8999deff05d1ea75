"""What explains a cell that does not hold, and what of it is not true.

Rules (`mpmkit.stability.foretold`) name figures and how large they may be: what is beyond, or another figure, is not explained; and a rule
that foretells what does not come is an error, which has to be mended or removed. What is unstable for a user too belongs to
`mpmkit._core.composing.cautions`, whose rules explain cells as well.
"""

from __future__ import annotations

from collections.abc import Iterable

import attrs

from mpmkit._core.composing.cautions import CAUTIONS
from mpmkit.stability.case import Composition, Verdict
from mpmkit.stability.foretold import EXPECTED
from mpmkit.stability.rule import ANY, Expected

__all__ = ["ANY", "EXPECTED", "Expected", "Explanation", "contradicted", "explain"]


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


def explain(case: str, composition: Composition, verdict: Verdict) -> Explanation | None:
    """The explanation of a cell that does not hold; None if there is none, or none of a part of what is measured."""
    for one in CAUTIONS:
        if one.name in verdict.cautions and case in one.shown_by:
            return Explanation(f"caution: {one.name}", one.reason, one.remedy)
    rules = [r for r in EXPECTED if case in r.cases and verdict.status in r.status and r.when(composition)]
    beyond = [f for f in verdict.figures if not f.margin <= 1.0]
    if not all(any(r.accounts_for(f) for r in rules) for f in beyond):
        return None
    # a run that did not come to its end has no figures: only rules about whatever is measured speak of it
    told = [r for r in rules if any(r.accounts_for(f) for f in beyond) or (not beyond and r.figures is ANY)]
    if not told:
        return None
    return Explanation("expected", _joined(r.reason for r in told), _joined(r.remedy for r in told))


def _joined(texts: Iterable[str]) -> str:
    return ". Further: ".join(dict.fromkeys(texts))


def contradicted(case: str, composition: Composition, verdict: Verdict, quick: bool) -> str:
    """What foretold that a cell, or a figure of it, would not hold, and it does; "" if nothing did."""
    if verdict.status == "holds":
        for one in CAUTIONS:
            if one.name in verdict.cautions and case in one.shown_by:
                return f"the caution {one.name!r} says that it shows in {case!r}, which holds"
    for rule in EXPECTED:
        if case not in rule.cases or not rule.always or (quick and not rule.quick) or not rule.when(composition):
            continue
        beyond = any(rule.about(f) and not f.margin <= 1.0 for f in verdict.figures)
        if verdict.status == "holds" or (verdict.status == "bounded" and verdict.figures and not beyond):
            return f"the rule {rule.reason[:60]!r}... foretells {' or '.join(rule.status)}, but it holds"
    return ""
