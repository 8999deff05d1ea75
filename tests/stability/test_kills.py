"""Runs that are killed while they write: what was acknowledged is there, and the resumed run ends bitwise as one that was not killed.

A frame or row is acknowledged when the call that writes it returns. More: ``python tests/stability/fuzz.py kills --count 50``.
"""

import random
import sys

import pytest
from killed_run import acknowledged, check_end, check_left, child, events

pytestmark = [
    pytest.mark.physics,
    pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL"),
]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run that came to its end, and how many calls its writing took."""
    path = tmp_path_factory.mktemp("whole") / "whole.vtkhdf"
    done = child("start", path)
    assert done.returncode == 0, done.stderr
    return path, events(done.stdout)


@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.99])
def test_killed_and_resumed(share, whole, tmp_path):
    good, last = whole
    rng, path = random.Random(share), tmp_path / "run.vtkhdf"
    done = child("start", path, int(share * last) + rng.randrange(50))
    assert done.returncode == -9, done.stderr
    assert check_left(path, good, *acknowledged(done.stdout)) == ""
    if not path.with_suffix(".ckpt.h5").exists():
        assert share < 0.1
        return
    again = child("resume", path, rng.randrange(1, last // 4))
    assert again.returncode in (0, -9), again.stderr
    assert check_left(path, good, [], []) == ""
    assert child("resume", path).returncode == 0
    assert check_end(path, good) == ""
