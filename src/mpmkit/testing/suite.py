"""From a name to checks, from checks to a pytest function or a report."""

from __future__ import annotations

import time
import warnings
import zlib
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from mpmkit._core.registry import Broken, Entry, registry
from mpmkit.errors import MpmkitError, PluginError, did_you_mean
from mpmkit.interfaces import Component
from mpmkit.testing.calling import variants
from mpmkit.testing.checks import table
from mpmkit.testing.collect import Declared

ALWAYS = {
    "entry point loads": "The plugin can be imported and returns component classes, and no other one of the kind has the same name.",
    "examples construct": "The component can be built from the examples of its parameters, with each choice and example in turn.",
    "known failures are checks": "Each entry of ``expected_failures`` names a check of this component; one that passes is a failure there.",
}
"""Checks that are made of every component beside those in the table of `mpmkit.testing.checks`."""

Target = str | type[Component] | Component | None


class Check(NamedTuple):
    """One check of one component.

    Attributes
    ----------
    component : type or str
        The class; the name of the plugin if it cannot be loaded.
    name : str
        For example ``objectivity`` or ``objectivity[strain="small"]``.
    run : callable
        Raises if the component does not conform. A failure that the component declares in ``expected_failures`` does not raise, and
        one that is declared but does not happen raises.
    known : str
        The declared reason of a known failure, or "".
    """

    component: type[Component] | str
    name: str
    run: Callable[[], None]
    known: str = ""

    @property
    def id(self) -> str:
        return f"{self.component if isinstance(self.component, str) else self.component.__name__}-{self.name}"


def iter_checks(target: Target = None) -> Iterator[Check]:
    """Checks of everything that `target` means.

    Parameters
    ----------
    target : str, component class, component or None
        Name of a plugin, of a distribution or of a component; a class (registered or not); one component with given parameters; or None
        for all that is registered.

    Raises
    ------
    PluginError
        If nothing has that name.
    """
    if isinstance(target, Component):
        yield from _of_instances(type(target), [("", target)])
        return
    if isinstance(target, type):
        yield from _of_class(target)
        return
    entries, broken = _find(target)
    for plugin in broken:
        yield Check(plugin.plugin, "entry point loads", _raiser(plugin))
    for entry in entries:
        yield Check(entry.component, "entry point loads", _unique(entry))
        yield from _of_class(entry.component)


def conformance(target: Target = None) -> Callable[..., None]:
    """One parametrised pytest function for all checks of `target` (see `iter_checks`)."""
    import pytest

    checks = list(iter_checks(target))

    @pytest.mark.parametrize("check", checks, ids=[check.id for check in checks])
    def test_conformance(check: Check) -> None:
        check.run()

    return test_conformance


def report(target: Target = None) -> list[dict[str, Any]]:
    """Run all checks; one row of plain data for each.

    Returns
    -------
    list of dict
        component, kind, check, passed, reason (of a failure, or of a known one), known (whether the failure is declared), seconds,
        warnings (texts of those that the check gave, each once).
    """
    return [run_one(check) for check in iter_checks(target)]


def identity(check: Check) -> dict[str, Any]:
    """Component, kind and name of a check, as in `report`."""
    kind = "plugin" if isinstance(check.component, str) else check.component.kind
    name = check.component if isinstance(check.component, str) else check.component.__name__
    return {"component": name, "kind": kind, "check": check.name}


def run_one(check: Check) -> dict[str, Any]:
    """Run one check; a row of `report`. Whatever the component raises, SystemExit included, is a failure; its warnings are kept."""
    row = identity(check) | {"passed": True, "reason": f"known failure: {check.known}" if check.known else "", "known": bool(check.known)}
    began = time.perf_counter()
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        try:
            check.run()
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001  a component under test may raise anything; the others must be checked too
            reason = str(error) if isinstance(error, (AssertionError, MpmkitError)) else f"{type(error).__name__}: {error}"
            row |= {"passed": False, "reason": reason}
    texts = dict.fromkeys(f"{warning.category.__name__}: {warning.message}" for warning in given)
    return row | {"seconds": time.perf_counter() - began, "warnings": list(texts)}


def _find(target: str | None) -> tuple[list[Entry], list[Broken]]:
    found = registry()
    if target is None:
        return found.entries, found.broken
    entries = [e for e in found.entries if target in (e.plugin, e.distribution, e.name)]
    broken = [b for b in found.broken if target in (b.plugin, b.distribution)]
    if not entries and not broken:
        names = {e.plugin for e in found.entries} | {e.distribution for e in found.entries} | {e.name for e in found.entries}
        names |= {b.plugin for b in found.broken} | {b.distribution for b in found.broken}
        raise PluginError(
            f"no plugin, distribution or component named {target!r} is installed{did_you_mean(target, names)} (see: mpmkit list-plugins)"
        )
    return entries, broken


def _raiser(plugin: Broken) -> Callable[[], None]:
    def run() -> None:
        raise PluginError(f"{plugin.plugin} ({plugin.distribution} {plugin.version}) cannot be loaded: {plugin.reason}") from plugin.error

    return run


def _unique(entry: Entry) -> Callable[[], None]:
    def run() -> None:
        registry().get(entry.name, entry.kind)  # raises for two components of one kind and name

    return run


def _of_class(cls: type[Component]) -> Iterator[Check]:
    try:
        made = list(variants(cls))
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001  reported as a failed check
        yield Check(cls, "examples construct", _failed(f"cannot build {cls.__name__} from the examples of its parameters: {error}", error))
        return
    yield Check(cls, "examples construct", lambda: None)
    yield from _of_instances(cls, made)


def _failed(reason: str, error: BaseException) -> Callable[[], None]:
    def run() -> None:
        raise AssertionError(reason) from error

    return run


def _of_instances(cls: type[Component], made: list[tuple[str, Component]]) -> Iterator[Check]:
    names = []
    for suffix, component in made:
        for declared in table():
            if declared.kind not in ("all", cls.kind) or (declared.once and suffix):
                continue
            name = declared.name + suffix
            try:
                if not declared.applies(component):
                    continue
            except KeyboardInterrupt:
                raise
            except BaseException as error:  # noqa: BLE001  a property of the component that fails is reported; other checks go on
                yield Check(cls, name, _failed(f"{type(error).__name__}: {error}", error))
                continue
            names.append(name)
            known = cls.expected_failures.get(name, "")
            yield Check(cls, name, _runner(declared, component, name, known), known)
    yield Check(cls, "known failures are checks", lambda: _known(cls, names))


def _runner(declared: Declared, component: Component, name: str, known: str) -> Callable[[], None]:
    def run() -> None:
        rng = np.random.default_rng(zlib.crc32(f"{type(component).__name__} {name}".encode()))
        try:
            declared.function(component, rng)
        except AssertionError:
            if known:
                return
            raise
        if known:
            raise AssertionError(
                f"{type(component).__name__} declares {name!r} as a known failure ({known}), but the check passes: remove the entry"
            )

    return run


def _known(cls: type[Component], names: list[str]) -> None:
    for name in cls.expected_failures:
        if name not in names:
            raise AssertionError(f"{cls.__name__}.expected_failures names {name!r}, which is no check of it{did_you_mean(name, names)}")
