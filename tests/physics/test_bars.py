"""The one-dimensional bars of SAND2002-0482 against their exact solutions.

Each example's `check` holds the tolerances: bands that other codes of the same scheme reach (pinned), and rounding where it says so.
"""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.physics


@pytest.mark.parametrize("name", ["bar_pulled", "bar_both_ends", "bar_impact", "bars_apart", "bar_plastic_impact", "load_a_boundary"])
def test_bar(example, name):
    bar = example(name)
    numbers = bar.main(quick=True)
    assert numbers
    bar.check(numbers)


def test_drawing_does_not_need_the_full_run(example, tmp_path):
    """One picture of an example in quick mode, so that a change of the drawing code is noticed."""
    bar = example("load_a_boundary")
    bar.main(quick=True, picture=tmp_path / "picture.png")
    assert (tmp_path / "picture.png").stat().st_size > 10_000
