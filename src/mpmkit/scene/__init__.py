"""Scene files: a simulation as TOML or JSON, read into the same classes that scripts use.

A scene file is data. Reading one looks names up in the registry, converts units and checks values; it never
executes anything that the file says.
"""

from __future__ import annotations

from mpmkit.scene.files import dumps, load, loads, save, to_script

__all__ = ["dumps", "load", "loads", "save", "to_script"]
