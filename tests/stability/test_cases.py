"""The default composition holds for every hard case."""

from __future__ import annotations

import pytest

from mpmkit.stability import Case, compositions
from mpmkit.stability.cases import cases
from mpmkit.stability.judge import judge

FAST = ("cell-crossing", "units")
"""Cases whose quick run is done in a second as plain Python; the others wait for ``-m physics``."""


def held(case: Case, quick: bool) -> None:
    composition = compositions.applied(case, compositions.default())
    assert composition is not None, f"{case.name} says nothing about the default composition"
    verdict = judge(case, composition, quick)
    if case.waits_for:
        assert verdict.status == "waiting"
    else:
        assert verdict.status == "holds", verdict.reason


@pytest.mark.parametrize("case", [cases()[name] for name in FAST], ids=FAST)
def test_the_default_composition_holds_in_quick_runs(case, monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    held(case, quick=True)


SLOW = {name: case for name, case in cases().items() if name not in FAST}


@pytest.mark.physics
@pytest.mark.parametrize("case", SLOW.values(), ids=SLOW)
def test_the_default_composition_holds_in_slow_quick_runs(case):
    held(case, quick=True)


@pytest.mark.physics
@pytest.mark.parametrize("case", cases().values(), ids=cases())
def test_the_default_composition_holds(case):
    held(case, quick=False)


@pytest.mark.physics
@pytest.mark.parametrize("transfer", ["APIC", "TPIC"])
@pytest.mark.parametrize("name", ["tiny-mass", "vibrating-bar"])
def test_what_the_strain_does_not_see_the_affine_matrix_does_not_carry(name, transfer):
    """USL limits velocities at light nodes: a matrix formed from the others made energy out of gradients that no stress resists."""
    from mpmkit import integrators

    axes = compositions.registered()
    composition = axes.one(None, integrators.USL(), getattr(integrators, transfer)())
    verdict = judge(cases()[name], compositions.applied(cases()[name], composition), quick=True)
    assert verdict.status == "holds", verdict.reason
