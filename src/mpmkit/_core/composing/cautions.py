"""What composes but is known to go wrong: rules with the reason, the remedy, and the hard cases that show it.

A rule looks at declared facts (verbs of the recipe, smoothness and reach of the shape function, affine form of the transfer), never at
names, so it covers components of third parties too. Each rule is demonstrated: `mpmkit stability` runs the cases that it names, and
complains if one of them holds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

import attrs

if TYPE_CHECKING:
    from mpmkit._core.composing.composition import Composition


@attrs.frozen
class Caution:
    """One rule.

    Attributes
    ----------
    name : str
        Short, for reports.
    severity : str
        "unstable": composing it warns, in `explain` and in a run. "inaccurate": `explain` notes it.
    when : callable
        ``when(composition) -> bool``, from declared facts and the scene.
    reason, remedy : str
        Why by theory, and what to do instead.
    shown_by : tuple of str
        Hard cases (``mpmkit stability``) that do not hold because of it.
    """

    name: str
    severity: Literal["unstable", "inaccurate"]
    when: Callable[[Composition], bool]
    reason: str
    remedy: str
    shown_by: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        return f"{self.reason}. To fix: {self.remedy}"


def found(c: Composition) -> list[Caution]:
    """The rules that apply to a composition."""
    return [one for one in CAUTIONS if one.when(c)]


def warnings(c: Composition) -> list[str]:
    """Texts about what is known to be unstable."""
    return [one.text for one in found(c) if one.severity == "unstable"]


def notes(c: Composition) -> list[str]:
    """Texts about what is known to be inaccurate."""
    return [one.text for one in found(c) if one.severity == "inaccurate"]


def _strains_raw_velocities(c: Composition) -> bool:
    """Strains from velocities f_i / m_i of the momentum update, neither mapped again nor limited, with slopes that jump."""
    if c.stored_operator or c.shape is None or c.shape.smooth or c.fraction > 0.0 or "remap" in c.verbs:
        return False
    return {"momentum", "strain"} <= set(c.verbs) and c.verbs.index("momentum") < c.verbs.index("strain")


def _turns_to_first_order(c: Composition) -> bool:
    """F <- (I + dt L) F where bodies can turn."""
    return c.dim > 1 and getattr(c.integrator, "strain", "") == "first-order"


CAUTIONS: tuple[Caution, ...] = (
    Caution(
        name="strains from raw velocities",
        severity="unstable",
        when=_strains_raw_velocities,
        reason=(
            "the recipe takes strains from the nodal velocities of the momentum update as they are, with a shape function whose slopes "
            "jump: the strain that a particle's own force returns to it goes with slope^2 / weight at the node, which has no bound as "
            "the weight goes to zero while the slope does not, so a particle that drifts past a node is torn off, with energy from "
            "nothing (Bardenhagen 2002; with continuous slopes the ratio stays bounded)"
        ),
        remedy="MUSL, USF, USL with its limit (limit=0.5), or a shape function with continuous slopes",
        shown_by=("tiny-mass",),
    ),
    Caution(
        name="first-order strain",
        severity="inaccurate",
        when=_turns_to_first_order,
        reason=(
            "strain='first-order' updates F by I + dt L, whose determinant is 1 + a^2 where velocities are those of a rotation by an "
            "angle a in a step: bodies that prescribed velocities turn swell, and their stress makes energy"
        ),
        remedy="strain='exponential' (the default) or 'midpoint'; 'centred' for bodies that spin freely",
        shown_by=("turned-by-the-grid",),
    ),
)
"""All rules, in the order in which they are told."""
