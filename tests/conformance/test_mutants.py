"""Each check finds the fault it is there for, and the faults of others leave it alone."""

import pytest
from mutants import EVERYTHING, collect

from mpmkit._core.registry import Entry, registry
from mpmkit._core.running.workers import available
from mpmkit.testing import scenes
from mpmkit.testing.checks import table
from mpmkit.testing.suite import ALWAYS, iter_checks, run_one

MUTANTS = collect()
COMPILED = {"compiled equals plain Python", "single precision stays single", "single precision is close to double"}
WHOLE = {declared.name for declared in table() if declared.function.__module__.endswith(".whole")}


@pytest.fixture(autouse=True)
def _as_it_was(monkeypatch):
    monkeypatch.setattr(scenes, "MACH", scenes.MACH)  # one mutant changes it


def base(name):
    return name.split("[")[0]


def failures(mutant, names):
    """Reasons of the checks among `names` that fail, by name; its own checks with all choices of parameters, others with the first."""
    checks = [c for c in iter_checks(mutant.cls) if c.name in names or base(c.name) in mutant.checks]
    rows = [run_one(check) for check in checks]
    return {base(row["check"]): row["reason"] for row in rows if not row["passed"]}


@pytest.mark.physics
@pytest.mark.parametrize("mutant", MUTANTS, ids=[m.id for m in MUTANTS])
def test_a_fault_is_found_by_its_check_and_by_no_other(mutant, monkeypatch):
    """Checks that compile or run whole scenes of all kinds are tried on their own mutants only, for time."""
    if "one thread equals two" in mutant.checks and available() < 2:
        pytest.skip("needs two cores")
    if "a scene file keeps it" in mutant.checks:
        monkeypatch.setattr(registry(), "entries", [*registry().entries, Entry(mutant.cls, "mutants", "mutants", "1.0")])
    mine = {d.name for d in table() if d.kind in ("all", mutant.cls.kind)} | set(ALWAYS)
    found = failures(mutant, (mine - COMPILED - WHOLE) | set(mutant.checks))
    missed = set(mutant.checks) - set(found)
    assert not missed, f"{mutant.cls.__name__} passes {missed}"
    if mutant.also != EVERYTHING:
        assert set(found) <= set(mutant.checks) | set(mutant.also), found


@pytest.mark.parametrize("declared", table(), ids=[f"{d.kind}-{d.name}" for d in table()])
def test_every_check_has_a_mutant(declared):
    assert any(declared.name in m.checks and declared.kind in ("all", m.cls.kind) for m in MUTANTS), "write a component that fails it"


def test_the_checks_that_are_always_made_have_mutants():
    # a plugin that cannot be loaded is tested with the registry, in tests/unit/test_testing.py
    assert set(ALWAYS) - {"entry point loads"} <= {name for m in MUTANTS for name in m.checks}


def test_every_check_says_what_it_does():
    assert [d.name for d in table() if len(d.doc) < 30] == []
