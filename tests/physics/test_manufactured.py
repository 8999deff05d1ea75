"""Manufactured solutions: observed orders (rate: 1.9 and more), and the errors themselves (pinned: measured, a few percent above)."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.physics


def test_observed_orders(example):
    waves = example("manufactured")
    waves.check(waves.main(quick=True))
