"""Print the shell command of README.md that holds a given word: CI runs what the README says, and nothing else.

Usage: readme.py README.md WORD
"""

import re
import sys
from pathlib import Path


def commands(text: str) -> list[str]:
    """The lines of all ``sh`` blocks."""
    return [line for block in re.findall(r"^```sh\n(.*?)^```", text, flags=re.MULTILINE | re.DOTALL) for line in block.splitlines() if line]


def main(path: str, word: str) -> int:
    """Print the one command with `word`; 1 if there is not exactly one."""
    found = [c for c in commands(Path(path).read_text(encoding="utf-8")) if word in c]
    if len(found) != 1:
        print(f"{path}: one command with {word!r} is expected, found {len(found)}", file=sys.stderr)
        return 1
    print(found[0])
    return 0


if __name__ == "__main__":
    raise SystemExit(main(*sys.argv[1:]))
