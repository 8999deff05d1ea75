"""Entry points loaded one by one: failures kept with their reason, duplicates refused, near names suggested."""

from __future__ import annotations

import os
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

import attrs
import pluggy

from mpmkit import hookspecs
from mpmkit.errors import PluginError, did_you_mean, shown
from mpmkit.interfaces import KINDS, Component


@attrs.frozen
class Entry:
    """One registered component and where it comes from."""

    component: type[Component]
    plugin: str
    distribution: str
    version: str

    @property
    def name(self) -> str:
        return self.component.__name__

    @property
    def kind(self) -> str:
        return self.component.kind


@attrs.frozen
class Broken:
    """An entry point that could not be loaded."""

    plugin: str
    distribution: str
    version: str
    reason: str
    error: BaseException


class Registry:
    """All installed components.

    Parameters
    ----------
    points : iterable of EntryPoint
        Where to look; by default every installed distribution's ``mpmkit`` group. Names in the environment variable
        MPMKIT_DISABLE_PLUGINS (separated by commas) are left out.
    """

    def __init__(self, points: Any = None) -> None:
        self.entries: list[Entry] = []
        self.broken: list[Broken] = []
        self.manager = pluggy.PluginManager("mpmkit")
        self.manager.add_hookspecs(hookspecs)
        off = {n.strip() for n in os.environ.get("MPMKIT_DISABLE_PLUGINS", "").split(",")}
        for point in sorted(entry_points(group="mpmkit") if points is None else points, key=lambda p: (p.name, p.value)):
            if point.name not in off:
                self._load(point)
        self.duplicates = self._find_duplicates()

    def _load(self, point: EntryPoint) -> None:
        distribution = point.dist.name if point.dist else "unknown"
        version = point.dist.version if point.dist else "unknown"
        try:
            module = point.load()
            self.manager.register(module, name=f"{distribution}:{point.name}")
            if not hasattr(module, "mpmkit_components"):
                raise PluginError(f"{point.value} has no function mpmkit_components() marked with mpm.hookimpl")
            for component in module.mpmkit_components():
                if not (isinstance(component, type) and issubclass(component, Component)) or component.kind not in KINDS:
                    raise PluginError(f"{component!r} is not a component class; derive it from one of the interfaces")
                self.entries.append(Entry(component, point.name, distribution, version))
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001  (a plugin may raise anything, SystemExit included; the rest must load)
            reason = f"{type(error).__name__}: {error}"
            self.broken.append(Broken(point.name, distribution, version, reason, error))

    def _find_duplicates(self) -> dict[tuple[str, str], list[Entry]]:
        found: dict[tuple[str, str], list[Entry]] = {}
        for entry in self.entries:
            found.setdefault((entry.kind, entry.name), []).append(entry)
        return {key: entries for key, entries in found.items() if len({id(e.component) for e in entries}) > 1}

    def of(self, *kinds: str) -> dict[str, Entry]:
        """Entries of the given kinds (all if none is given) by name."""
        return {e.name: e for e in self.entries if not kinds or e.kind in kinds}

    def get(self, name: str, *kinds: str) -> Entry:
        """Entry of a name; `PluginError` with the nearest name, or naming both distributions of a duplicate."""
        for (kind, duplicate), entries in self.duplicates.items():
            if duplicate == name and (not kinds or kind in kinds):
                where = " and ".join(f"{e.distribution} {e.version} ({e.component.__module__})" for e in entries)
                raise PluginError(
                    f"two plugins register a {kind} named {name!r}: {where}; uninstall or disable one (MPMKIT_DISABLE_PLUGINS)"
                )
        known = self.of(*kinds)
        if name not in known:
            what = " or ".join(kinds) or "component"
            lost = "".join(f"\n  not loaded: {b.plugin} ({b.distribution} {b.version}): {b.reason}" for b in self.broken)
            raise PluginError(
                f"no {what} named {shown(name)} is registered{did_you_mean(name, known)}\n  registered: {', '.join(sorted(known))}"
                f"      see: mpmkit list-plugins{lost}"
            )
        return known[name]


@cache
def registry() -> Registry:
    """The registry of this process."""
    return Registry()


def entry_of(component: type[Component] | Component) -> Entry | None:
    """Where a component class comes from; None if no plugin registers it (a class of the user's script)."""
    cls = component if isinstance(component, type) else type(component)
    return next((e for e in registry().entries if e.component is cls), None)
