"""The checks of a plugin in child processes: whatever it does, the report goes on and says what happened."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import attrs

from mpmkit.errors import PluginError

MOST_DEATHS = 8
"""Processes that may die or hang before the checks that are left are given up."""
LOADING = {"kind": "plugin", "check": "entry point loads"}


@attrs.frozen
class Death:
    """How a child process ended before it was done; `last` is the end of what it wrote to stderr."""

    how: str
    last: str = ""


def plugins() -> dict[str, str]:
    """Installed plugins by name with their distribution, from metadata alone: nothing is imported."""
    off = {n.strip() for n in os.environ.get("MPMKIT_DISABLE_PLUGINS", "").split(",")}
    points = sorted(entry_points(group="mpmkit"), key=lambda p: p.name)
    return {p.name: p.dist.name if p.dist else "unknown" for p in points if p.name not in off}


def check_plugin(target: str, timeout: float = 120.0, stop: threading.Event | None = None) -> list[dict[str, Any]]:
    """Rows of `mpmkit.testing.report` for one plugin, distribution or component, each check within `timeout` seconds.

    A check during which the process dies or hangs is a failed one with that reason; another process goes on with the next. If not even
    the first check is reached, other third-party plugins are left out, in case one of them is to blame. When `stop` is set, the process is
    ended and the rows so far are returned.

    Raises
    ------
    PluginError
        If nothing has that name.
    """
    rows: list[dict[str, Any]] = []
    begun, deaths, alone = 0, 0, False
    stop = stop or threading.Event()
    while True:
        lines, death = _run(target, begun, timeout, _others(target) if alone else (), stop)
        rows += [line["row"] for line in lines if "row" in line]
        errors = [line["error"] for line in lines if "error" in line]
        if errors:
            raise PluginError(errors[0])
        if death is None or stop.is_set():
            return rows
        started = [line["begun"] for line in lines if "begun" in line]
        deaths += 1
        if started:
            begun += len(started)
            rows.append(_row(started[-1], f"{death.how}{_quoted(death.last)}", timeout))
        elif not alone and not begun and _others(target):
            alone = True
            continue
        else:
            rows.append(_row({"component": target} | LOADING, f"before the first check {death.how}{_quoted(death.last)}", timeout))
            return rows
        if deaths >= MOST_DEATHS:
            rows.append(_row({"component": target} | LOADING, f"given up after {deaths} processes; later checks were not run", 0.0))
            return rows


def _row(check: dict[str, Any], reason: str, seconds: float) -> dict[str, Any]:
    return check | {"passed": False, "reason": reason, "known": False, "seconds": seconds, "warnings": []}


def _quoted(text: str) -> str:
    return "".join(f"\n    {line}" for line in text.strip().splitlines()[-6:])


def _others(target: str) -> tuple[str, ...]:
    """Third-party plugins beside the target."""
    return tuple(name for name, distribution in plugins().items() if distribution != "mpmkit" and target not in (name, distribution))


def _run(
    target: str, skip: int, timeout: float, without: tuple[str, ...], stop: threading.Event
) -> tuple[list[dict[str, Any]], Death | None]:
    """One child process: the lines it wrote, and how it ended if not well."""
    off = [name for name in os.environ.get("MPMKIT_DISABLE_PLUGINS", "").split(",") if name] + list(without)
    environment = {**os.environ, "MPMKIT_DISABLE_PLUGINS": ",".join(off)}
    with tempfile.TemporaryDirectory() as folder:
        path, said = Path(folder) / "rows.jsonl", Path(folder) / "stderr.txt"
        path.touch()
        command = [sys.executable, "-X", "faulthandler", "-m", "mpmkit.testing.child", target, str(path), str(skip)]
        with said.open("wb") as stderr:
            child = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=stderr, env=environment, start_new_session=True
            )
            try:
                late = _wait(child, path, timeout, stop)
            finally:
                _kill(child)
        lines = _lines(path)
        if lines and ("end" in lines[-1] or "error" in lines[-1]):
            return lines, None
        last = said.read_text(encoding="utf-8", errors="replace")
    if late:
        return lines, Death(f"did not end within {timeout:g} s")
    status = child.returncode
    if status < 0:
        return lines, Death(f"the process was killed by signal {-status} ({_signal_name(-status)})", last)
    return lines, Death(f"the process ended with status {status}", last)


def _wait(child: subprocess.Popen[bytes], path: Path, timeout: float, stop: threading.Event) -> bool:
    """Wait for the child; True if it wrote nothing for `timeout` seconds."""
    size, since = -1, time.monotonic()
    while child.poll() is None and not stop.is_set():
        now = path.stat().st_size
        if now != size:
            size, since = now, time.monotonic()
        elif time.monotonic() - since > timeout:
            return True
        time.sleep(0.05)
    return False


def _kill(child: subprocess.Popen[bytes]) -> None:
    """End the child and the processes it has started, which share its process group."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child.pid, signal.SIGKILL)
    child.wait()


def _lines(path: Path) -> list[dict[str, Any]]:
    """What the child wrote; a line that was cut short is left out."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines(keepends=True) if line.endswith("\n")]


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return "unknown"
