"""What a rule is that foretells an outcome of the suite."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import attrs

from mpmkit.stability.case import Composition, Figure, Status

ANY: Mapping[str, float] = {"": float("inf")}
"""Whatever is measured."""


@attrs.frozen
class Expected:
    """One rule.

    Attributes
    ----------
    cases : tuple of str
        Names of the cases it is about.
    when : callable
        ``when(composition) -> bool``, from declared facts (`mpmkit.stability.facts`).
    reason, remedy : str
        Why by theory, and what to do instead.
    status : tuple of str
        What is foretold.
    quick : bool
        Whether it shows in quick runs too; if not, a quick run may hold.
    always : bool
        Whether it comes whenever the rule applies; False for noise, which may by chance stay within the limit.
    figures : mapping of str to float
        Beginnings of the names of the figures it is about, each with the largest size that the reason accounts for.
    """

    cases: tuple[str, ...]
    when: Callable[[Composition], bool]
    reason: str
    remedy: str
    status: tuple[Status, ...] = ("bounded",)
    quick: bool = True
    always: bool = True
    figures: Mapping[str, float] = ANY

    def about(self, figure: Figure) -> bool:
        """Whether the rule speaks of this figure."""
        return any(figure.name.startswith(name) for name in self.figures)

    def accounts_for(self, figure: Figure) -> bool:
        """Whether the figure is no larger than the reason makes it."""
        return any(figure.name.startswith(name) and abs(figure.value) <= most for name, most in self.figures.items())
