"""The command line: one file per command, imported when the command is called."""

from __future__ import annotations

from mpmkit.cli.app import main

__all__ = ["main"]
