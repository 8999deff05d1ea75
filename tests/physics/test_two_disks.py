"""The two disks of Sulsky, Chen and Schreyer: bands of other codes (pinned), energy and momentum (rounding)."""

from __future__ import annotations

from pathlib import Path

import pytest

from mpmkit import scene

pytestmark = pytest.mark.physics


def test_impact_and_rebound(example):
    disks = example("two_disks")
    disks.check(disks.main(quick=True))


def test_the_file_says_the_same_as_the_script(example):
    disks = example("two_disks")
    assert scene.dumps(scene.load(Path(disks.__file__).with_suffix(".toml"))).replace("rubber", "neo_hookean") == scene.dumps(disks.scene())
