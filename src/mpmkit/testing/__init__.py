"""Conformance checks for any component, and a single-point driver for constitutive models.

A plugin's whole test file::

    from mpmkit.testing import conformance

    test_plugin = conformance("mooney")
"""

from __future__ import annotations

from mpmkit.testing.element import History, drive
from mpmkit.testing.suite import Check, conformance, iter_checks, report

__all__ = ["Check", "History", "conformance", "drive", "iter_checks", "report"]
