"""Code blocks of a Markdown file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple


class Block(NamedTuple):
    """One fenced code block: its language, its text and the line it starts at."""

    language: str
    text: str
    line: int


def blocks(path: Path) -> list[Block]:
    """All fenced code blocks of `path`."""
    text = path.read_text(encoding="utf-8")
    found = re.finditer(r"^```(\S*)\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL)
    return [Block(m[1], m[2], text.count("\n", 0, m.start()) + 1) for m in found]
