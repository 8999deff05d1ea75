"""The process that does the runs of a study: jobs come in as lines of JSON, answers go out the same way. See `child`."""

from __future__ import annotations

import json
import os
import select
import sys
from typing import Any

IDLE_SECONDS = 600.0
"""A worker that is forgotten ends by itself."""


def main() -> None:
    """Serve jobs until the other side closes."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8", buffering=1)
    os.dup2(2, 1)  # what a scene or component prints must not mix with answers
    jobs = os.fdopen(os.dup(0), "rb", buffering=0)

    def say(data: dict[str, Any]) -> None:
        answers.write(json.dumps(data) + "\n")
        answers.flush()

    while True:
        if not select.select([jobs], [], [], IDLE_SECONDS)[0]:
            return
        line = jobs.readline()
        if not line:
            return
        job = json.loads(line)
        sys.path += [p for p in job.get("sys_path", ()) if p not in sys.path]
        from mpmkit.studies.stepping import execute

        say({"answer": execute(job, ready=lambda: say({"ready": True}))})


if __name__ == "__main__":
    main()
