"""Modules such as `mpmkit.materials`, whose names are looked up in the registry when they are used."""

from __future__ import annotations

from typing import Any

from mpmkit.errors import PluginError


def namespace(module: str, *kinds: str) -> tuple[Any, Any]:
    """Return ``__getattr__`` and ``__dir__`` for a module that shows the registered components of `kinds`."""

    def getattr_(name: str) -> Any:
        if name == "__all__":
            return dir_()
        if name.startswith("_"):
            raise AttributeError(name)
        from mpmkit._core.registry import registry

        try:
            return registry().get(name, *kinds).component
        except PluginError as error:
            # Python's import and completion machinery expects an AttributeError.
            raise AttributeError(str(error)) from None

    def dir_() -> list[str]:
        from mpmkit._core.registry import registry

        return sorted(registry().of(*kinds))

    return getattr_, dir_
