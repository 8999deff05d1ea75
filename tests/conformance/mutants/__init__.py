"""Components with one deliberate fault each: what every check of the conformance suite must find."""

import importlib
import pkgutil

import attrs

EVERYTHING = "everything"
"""For faults of form, after which nothing can be computed."""
MUTANTS = []


@attrs.frozen
class Mutant:
    """A faulty component, the checks that must find it, and others that cannot but fail with it."""

    cls: type
    checks: tuple[str, ...]
    also: tuple[str, ...] | str

    @property
    def id(self):
        return f"{self.cls.__name__}-{self.checks[0]}"


def mutant(*checks, also=()):
    """Register a component class as the one that these checks must find."""

    def add(cls):
        MUTANTS.append(Mutant(cls, checks, also))
        return cls

    return add


def collect():
    """All mutants, of all modules of this folder."""
    for found in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{found.name}")
    return MUTANTS
