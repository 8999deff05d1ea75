"""A ringing bar: period, amplitude and energy against the exact mode (pinned: bands of other codes on the same grids)."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.physics


def test_the_bar_rings_on(example):
    bar = example("vibrating_bar")
    bar.check(bar.main(quick=True))
