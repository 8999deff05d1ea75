"""The one hook a plugin implements."""

from __future__ import annotations

from collections.abc import Iterable

import pluggy

from mpmkit.interfaces.component import Component

hookspec = pluggy.HookspecMarker("mpmkit")
hookimpl = pluggy.HookimplMarker("mpmkit")


@hookspec
def mpmkit_components() -> Iterable[type[Component]]:  # type: ignore[empty-body]
    """Return the component classes of this plugin, of any kinds.

    A distribution points to the module that holds this function with one line::

        [project.entry-points.mpmkit]
        rubber = "mpmkit_rubber"
    """
