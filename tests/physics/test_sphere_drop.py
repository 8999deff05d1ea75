"""A ball bounces off a rough floor: Coulomb's and Hertz's laws (pinned: 1 % and 14 % measured), energy (pinned)."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.physics


def test_the_floor_obeys_coulomb_and_hertz(example):
    drop = example("sphere_drop")
    drop.check(drop.main(quick=True))
