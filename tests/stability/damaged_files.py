"""Damage to the files of a run, and what reading them may end in: the very same numbers, or a ResultsError that names the file."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit._core.running import checkpoint


def flip(raw: bytes, rng: random.Random) -> bytes:
    """A few bits."""
    changed = bytearray(raw)
    for _ in range(rng.choice((1, 1, 1, 4, 40))):
        changed[rng.randrange(len(raw))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def cut(raw: bytes, rng: random.Random) -> bytes:
    """The end is missing."""
    return raw[: rng.randrange(len(raw))]


def hole(raw: bytes, rng: random.Random) -> bytes:
    """A sector of zeros, as after a power cut."""
    at = rng.randrange(len(raw)) // 512 * 512
    size = rng.choice((512, 4096))
    return raw[:at] + bytes(min(size, len(raw) - at)) + raw[at + size :]


def noise(raw: bytes, rng: random.Random) -> bytes:
    """A sector of something else."""
    at = rng.randrange(len(raw))
    return raw[:at] + rng.randbytes(min(200, len(raw) - at)) + raw[at + 200 :]


def moved(raw: bytes, rng: random.Random) -> bytes:
    """A piece is lost from the middle, and the rest moved up."""
    at = rng.randrange(len(raw))
    return raw[:at] + raw[at + rng.choice((1, 8, 512)) :]


def grown(raw: bytes, rng: random.Random) -> bytes:
    """Something behind the end."""
    return raw + rng.randbytes(rng.choice((1, 100, 5000)))


DAMAGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (flip, flip, flip, cut, hole, noise, moved, grown)


def contents(path: Path) -> dict[str, Any]:
    """Everything that can be read from a result file and what lies beside it."""
    found: dict[str, Any] = {}
    results = mpm.Results(path)
    found["times"], found["scene"], found["meta"] = results.times.tolist(), results.scene, dict(results.meta)
    for frame in results.frames:
        found[f"step {frame.time!r}"] = frame.step
        for name in frame:
            found[f"{name} {frame.time!r}"] = frame[name]
    return found


def state(path: Path) -> dict[str, Any]:
    """Everything in a checkpoint."""
    arrays, attributes = checkpoint.load(path)
    return {**arrays, "attributes": attributes}


def continued(path: Path) -> dict[str, Any]:
    """What is in a result file after it was opened to go on writing, as `resume` does, and closed."""
    from mpmkit._core.running.vtkhdf import ParticleFile

    ParticleFile.reopen(path).close()
    return contents(path)


def rows(path: Path) -> dict[str, Any]:
    """Everything in a history, and again after it was opened to go on writing."""
    from mpmkit._core.running.history import HistoryFile, read_history

    found = read_history(path)
    HistoryFile.reopen(path).close()
    again = read_history(path)
    assert same(found, again) == "", "opening a history has changed it"
    return found


def shortened(found: dict[str, Any], good: dict[str, Any]) -> dict[str, Any]:
    """What a history has lost at its end is as if the run had been killed before: nothing wrong is read."""
    lost = len(good["step"]) - len(found["step"])
    return good if lost <= 0 or found.keys() != good.keys() else {name: column[:-lost] for name, column in good.items()}


def same(a: dict[str, Any], b: dict[str, Any]) -> str:
    """The first name in which two readings differ; empty if none."""
    if a.keys() != b.keys():
        return f"names {sorted(map(str, a.keys() ^ b.keys()))[:3]}"
    for name, value in a.items():
        if isinstance(value, np.ndarray):
            if value.dtype != b[name].dtype or not np.array_equal(value, b[name]):
                return name
        elif value != b[name]:
            return name
    return ""


def judge(read: Callable[[Path], dict[str, Any]], path: Path, good: dict[str, Any]) -> tuple[str, str]:
    """("same" | "refused" | "fault", text)."""
    try:
        found = read(path)
        differs = same(found, shortened(found, good) if read is rows else good)
    except mpm.ResultsError as error:
        text = str(error)
        clear = path.name.split(".")[0] in text and len(text) < 1500
        return ("refused", text) if clear else ("fault", f"an unclear message: {text[:300]}")
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001  that is what is looked for
        return "fault", f"{type(error).__name__}: {error}"
    return ("fault", f"{differs} is wrong, and nobody said so") if differs else ("same", "")
