"""The child process of the suite: it takes cells from its standard input, judges them, and answers with verdicts.

A component under test may crash, never end, or print: the answers go to what was standard output when the process began, all that is
printed goes to standard error, and the parent ends a process that does not answer in time.
"""

from __future__ import annotations

import os
import pickle
import sys
from typing import Any, BinaryIO


def serve(cells: BinaryIO, answers: BinaryIO) -> None:
    """Judge until there are no more cells; the first message is the parent's import path."""
    sys.path[:] = receive(cells)
    from mpmkit.stability.judge import judge

    while True:
        try:
            case, composition, quick = receive(cells)
        except EOFError:
            return
        send(answers, judge(_found(case), composition, quick))


def send(stream: BinaryIO, message: Any) -> None:
    """One message, preceded by its length."""
    data = pickle.dumps(message)
    stream.write(len(data).to_bytes(8, "little") + data)
    stream.flush()


def receive(stream: BinaryIO) -> Any:
    """The next message.

    Raises
    ------
    EOFError
        If the other side has ended.
    """
    head = stream.read(8)
    if len(head) < 8:
        raise EOFError
    size = int.from_bytes(head, "little")
    data = stream.read(size)
    if len(data) < size:
        raise EOFError
    return pickle.loads(data)


def _found(case: Any) -> Any:
    """A case by its name, since most cannot be pickled, or the case itself."""
    if isinstance(case, str):
        from mpmkit.stability.cases import cases

        return cases()[case]
    return case


def main() -> None:
    """Answer on what standard output was; let everything that is printed go to standard error."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    serve(sys.stdin.buffer, answers)


if __name__ == "__main__":
    main()
