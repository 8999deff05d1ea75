"""Hard cases for numerical stability: every component and composition is run through them.

`run` judges cases under compositions; ``mpmkit stability`` is the same on the command line, with a table and a picture.
"""

from __future__ import annotations

from mpmkit.stability.case import Case, Composition, Figure, Verdict
from mpmkit.stability.runner import run
from mpmkit.stability.suite import Suite

__all__ = ["Case", "Composition", "Figure", "Suite", "Verdict", "run"]
