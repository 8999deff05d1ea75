"""A thick tube, elastic and half plastic, as a ring and as a quarter (pinned: 2 % in displacement, 5 % in stress, 20 cells in the wall)."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.physics


def test_lame_and_hill(example):
    tube = example("thick_cylinder")
    tube.check(tube.main(quick=True))
