"""What ``mpmkit check`` runs in a process of its own: the checks of one target, each announced and reported in a file, line by line.

A plugin may print, hang, or end the process; the file says how far it got.
"""

from __future__ import annotations

import json
import os
import sys
from typing import IO, Any


def main(target: str, path: str, skip: int) -> None:
    """Run the checks of `target` but the first `skip`, which an earlier process has begun."""
    with open(path, "a", encoding="utf-8") as file:
        try:
            from mpmkit.errors import MpmkitError
            from mpmkit.testing.suite import identity, iter_checks, run_one

            for number, check in enumerate(iter_checks(target)):
                if number >= skip:
                    _write(file, {"begun": identity(check)})
                    _write(file, {"row": run_one(check)})
        except MpmkitError as error:
            _write(file, {"error": str(error)})
        else:
            _write(file, {"end": True})
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0)  # threads and exit functions that a plugin has left must not keep the process


def _write(file: IO[str], line: dict[str, Any]) -> None:
    file.write(json.dumps(line, default=str) + "\n")
    file.flush()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
