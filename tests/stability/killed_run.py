"""A run that is killed at a chosen moment of its writing, as a program of its own, and what must be left of it.

python killed_run.py start|resume FILE EVENT

Each frame and row is acknowledged on standard output after the call that writes it has returned; EVENT is the number of the Python or C
call, counted inside the modules that write, at which the process kills itself (0: never; then it prints how many there were).
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__)
WRITING = ("vtkhdf", "checkpoint", "history", "recorder", "writing", "disk", "paths")
UNTIL = 0.25

SCENE = """
until = {until}
[grid]
lower = [0.0, 0.0]
upper = [2.0, 1.0]
spacing = 0.25
[shape]
kind = "Linear"
[integrator]
kind = "MUSL"
dt = 5e-3
transfer = {{ kind = "APIC" }}
[[bodies]]
name = "a"
geometry = {{ kind = "Box", lower = [0.5, 0.25], upper = [0.75, 0.5] }}
material = {{ kind = "NeoHookean", E = 100.0, nu = 0.3, rho = 2.0 }}
v = [0.3, 0.1]
[[bodies]]
name = "b"
geometry = {{ kind = "Box", lower = [1.0, 0.375], upper = [1.25, 0.625] }}
material = {{ kind = "VonMises", E = 100.0, nu = 0.3, rho = 1.0, yield_stress = 1.0 }}
v = [-0.3, 0.0]
[[boundaries]]
kind = "Wall"
[[contacts]]
kind = "FrictionalContact"
friction = 0.2
[[records]]
path = "{path}"
every = 0.02
history = 3
fields = ["x", "v", "stress"]
compress = {compress}
"""


def scene(path: Path, compress: bool = False) -> str:
    """Two blocks of eight particles that meet and touch a wall."""
    return SCENE.format(until=UNTIL, path=path, compress=str(compress).lower())


def child(what: str, path: Path, event: int = 0, compress: bool = False) -> subprocess.CompletedProcess[str]:
    """Run to the end or the kill."""
    command = [sys.executable, str(HERE), what, str(path), str(event), *(["compress"] if compress else [])]
    return subprocess.run(command, env=os.environ | {"NUMBA_DISABLE_JIT": "0"}, text=True, capture_output=True, check=False, timeout=300)


def acknowledged(output: str) -> tuple[list[float], list[int]]:
    """Times of frames and steps of rows that were said to be written."""
    words = [line.split() for line in output.splitlines() if line.count(" ") == 1]
    return [float(w[1]) for w in words if w[0] == "frame"], [int(w[1]) for w in words if w[0] == "row"]


def events(output: str) -> int:
    """Calls counted in a run that was not killed."""
    return int(output.split("events ")[1].split()[0])


def check_left(path: Path, whole: Path, frames: list[float], rows: list[int]) -> str:
    """What is wrong with the files of a killed run, compared with those of a whole one; empty if nothing is."""
    import mpmkit as mpm
    from mpmkit._core.running.history import read_history

    try:
        good = mpm.Results(whole)
        if frames or path.exists():
            try:
                found = mpm.Results(path)
            except mpm.ResultsError as error:
                return f"{len(frames)} frames were acknowledged, and the file cannot be read: {error}" if frames else ""
            if len(found.times) < len(frames) or found.times.tolist() != good.times.tolist()[: len(found.times)]:
                return f"frames {frames} were acknowledged, there are {found.times.tolist()}"
            for one, other in zip(found.frames, good.frames, strict=False):
                for name in ("x", "v", "stress", "body", "id"):
                    if not np.array_equal(one[name], other[name]):
                        return f"{name} at t = {one.time:g} differs"
        if rows:
            left, all_rows = read_history(path.with_suffix(".history.csv")), read_history(whole.with_suffix(".history.csv"))
            n = len(left["step"])
            if n < len(rows) or any(not np.array_equal(column, all_rows[name][:n]) for name, column in left.items()):
                return f"rows of steps {rows} were acknowledged, there are {left['step'].tolist()}"
    except Exception as error:  # noqa: BLE001  whatever it is, it is a fault
        return f"{type(error).__name__}: {error}"
    return ""


def check_end(path: Path, whole: Path) -> str:
    """Whether a resumed run has left bitwise what a whole one leaves."""
    import mpmkit as mpm
    from mpmkit._core.running import checkpoint

    one, other = mpm.Results(path), mpm.Results(whole)
    if one.times.tolist() != other.times.tolist():
        return f"frames at {one.times.tolist()}"
    for a, b in zip(one.frames, other.frames, strict=True):
        for name in ("x", "v", "stress"):
            if not np.array_equal(a[name], b[name]):
                return f"{name} at t = {a.time:g} differs"
    if path.with_suffix(".history.csv").read_text() != whole.with_suffix(".history.csv").read_text():
        return "the history differs"
    ends = [checkpoint.load(p.with_suffix(".ckpt.h5"))[0] for p in (path, whole)]
    wrong = [name for name in ends[1] if not np.array_equal(ends[0][name], ends[1][name])]
    return f"the last checkpoint differs in {', '.join(wrong)}" if wrong else ""


def main(what: str, path: Path, event: int, compress: bool) -> None:
    import mpmkit as mpm
    from mpmkit._core.running import recorder
    from mpmkit._core.running.history import HistoryFile
    from mpmkit._core.running.vtkhdf import ParticleFile

    recorder.CHECKPOINT_SECONDS = 0.0  # with every frame
    sim = mpm.scene.loads(scene(path, compress)) if what == "start" else mpm.Simulation.from_checkpoint(path.with_suffix(".ckpt.h5"))
    sim.compose()
    append, row = ParticleFile.append, HistoryFile.append

    def say(text: str) -> None:
        os.write(1, f"{text}\n".encode())

    def append_and_say(self: Any, time: float, *more: Any, **named: Any) -> None:
        append(self, time, *more, **named)
        say(f"frame {time!r}")

    def row_and_say(self: Any, values: Any) -> None:
        row(self, values)
        say(f"row {int(values['step'])}")

    ParticleFile.append, HistoryFile.append = append_and_say, row_and_say  # type: ignore[method-assign]
    count = 0

    def profile(frame: Any, kind: str, arg: Any) -> None:
        nonlocal count
        name = os.path.basename(frame.f_code.co_filename)
        if name.startswith(WRITING) and name != HERE.name:
            count += 1
            if count == event:
                os.kill(os.getpid(), signal.SIGKILL)

    threading.setprofile(profile)
    sys.setprofile(profile)
    sim.run(until=UNTIL, quiet=True)
    sys.setprofile(None)
    say(f"events {count}")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), len(sys.argv) > 4)
