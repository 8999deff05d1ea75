"""A step needs no more instructions than benchmarks/instructions.json says: what a change costs, whatever the machine and its load."""

from __future__ import annotations

import shutil

import pytest


@pytest.mark.physics
@pytest.mark.skipif(shutil.which("valgrind") is None, reason="valgrind counts the instructions, and is not installed")
@pytest.mark.parametrize("setting", ["apic3 f64", "flip3 f32", "apic2 f64"])
def test_a_step_needs_no_more_instructions_than_recorded(setting, root, monkeypatch):
    # pinned: the count in the file with 10 %, room for another version of the compiler; the count itself repeats to the last digit
    monkeypatch.syspath_prepend(str(root))
    from benchmarks import instructions

    result = instructions.main(only=(setting,))
    assert result["grown"] == [], (
        f"{setting}: {result['counts'][setting]:.0f} instructions per particle-step, {result['known'].get(setting)} in the file; if the change is "
        "worth it, run python -m benchmarks instructions --write-instructions"
    )
