"""A block on an incline: Coulomb's law to 1 %, drift of a sticking block below 1e-3 cells per second, the project's own criteria (pinned)."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.physics


def test_it_slides_or_stays(example):
    incline = example("incline")
    incline.check(incline.main(quick=True))
