"""Where generated modules and their machine code are kept: one folder per digest, in the first place that can be written.

Every file is written under another name and renamed, so that processes that compile the same composition at the same
time, or are killed while they do, leave whole files or none. Machine code begins with its own digest, and what does not
fit it is compiled again. A place that cannot be written is read all the same, and never written.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import sys
import tempfile
import time
import types
import warnings
from functools import cache
from pathlib import Path
from typing import Any

ABANDONED_SECONDS = 3600.0
"""Age of a temporary file that no process is going to rename any more."""
_DIGEST = 32


@cache
def places() -> tuple[tuple[Path, ...], str]:
    """Folders to look in, best first: MPMKIT_CACHE_DIR if set, then the user's cache folder, up to the first that can be written.

    Returns
    -------
    folders : tuple of Path
        Of these at most the last can be written.
    reason : str
        Why the last cannot be written; empty if it can.
    """
    named = os.environ.get("MPMKIT_CACHE_DIR")
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    found: list[Path] = []
    reason = ""
    for place in [*([Path(named)] if named else []), Path(base) / "mpmkit"]:
        found.append(place.absolute())
        try:
            place.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=place):
                return tuple(found), ""
        except OSError as error:
            reason = str(error)
    return tuple(found), reason


@cache
def folder() -> Path:
    """Where new code is written: one of `places`, else a temporary folder of this process; one line of notice unless it is the first."""
    found, reason = places()
    if not reason:
        if len(found) > 1:
            _notice(f"the cache folder {found[0]} is not writable; compiling into {found[-1]}")
        return found[-1]
    try:
        place = Path(tempfile.mkdtemp(prefix="mpmkit-"))
    except OSError:
        _notice(f"the cache folder is not writable ({reason}), nor is a temporary one; compiled code is not kept")
        return found[-1]
    atexit.register(_remove, place, os.getpid())
    _notice(f"the cache folder is not writable ({reason}); compiling into {place}, for this process only")
    return place


def home(digest: str) -> Path:
    """Folder of a generated module: where it lies already, else where it is going to be written."""
    return next((p / digest for p in _readable() if (p / digest / "step.py").is_file()), None) or folder() / digest


def read(digest: str, name: str) -> bytes | None:
    """A file kept by `write`; None if there is none, or none that is whole."""
    for place in _readable():
        try:
            data = (place / digest / name).read_bytes()
        except OSError:
            continue
        if hashlib.sha256(data[_DIGEST:]).digest() == data[:_DIGEST]:
            return data[_DIGEST:]
    return None


def write(digest: str, name: str, data: bytes) -> None:
    """Keep a file beside a module; if that fails (a full disk) it is missing the next time, and a notice says so."""
    _write(folder() / digest / name, hashlib.sha256(data).digest() + data)


def versions() -> str:
    """What compiled code depends on beside its source: versions and the machine."""
    import llvmlite
    import numba
    import numpy as np

    import mpmkit

    # NUMBA_CPU_NAME and NUMBA_CPU_FEATURES choose another processor than the host's
    config: Any = numba.config
    features = config.CPU_FEATURES
    cpu = numba.core.codegen.get_host_cpu_features() if features is None else features  # type: ignore[no-untyped-call]
    host = config.CPU_NAME or llvmlite.binding.get_host_cpu_name()
    python = ".".join(map(str, sys.version_info[:3]))
    packages = f"numba {numba.__version__} llvmlite {llvmlite.__version__} numpy {np.__version__}"
    return f"mpmkit {mpmkit.__version__} python {python} {packages} {host} {cpu}"


def load(digest: str, text: str, names: dict[str, Any]) -> types.ModuleType:
    """Make the module from its text, with the components under their `names`; the text is also kept as a file, for people to read."""
    path = home(digest) / "step.py"
    if not path.is_file() or path.read_bytes() != text.encode():
        path = folder() / digest / "step.py"
        _write(path, text.encode())
    module = types.ModuleType(f"mpmkit_step_{digest}")
    module.__file__ = str(path)
    vars(module).update(names)
    sys.modules[module.__name__] = module  # numba pickles functions by module name
    # from the text in memory: neither the file nor Python's bytecode of it has to be trusted
    exec(compile(text, str(path), "exec"), vars(module))
    return module


def _readable() -> tuple[Path, ...]:
    """Places to look in; the folder of this process too, once there is one."""
    found, _ = places()
    return found if not folder.cache_info().currsize or folder() in found else (*found, folder())


def _write(path: Path, data: bytes) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for old in path.parent.glob("*.tmp"):
            if time.time() - old.stat().st_mtime > ABANDONED_SECONDS:
                old.unlink(missing_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise
    except FileNotFoundError:
        pass  # another process has removed an old file or the whole folder just now: compiled again next time
    except OSError as error:
        _notice(f"cannot write to {path.parent} ({error.strerror}); compiled code is not kept")


@cache
def _notice(text: str) -> None:
    """Once for each text."""
    warnings.warn(f"mpmkit: {text}", stacklevel=4)


def _remove(place: Path, process: int) -> None:
    """Remove the folder of this process; forked children leave it to their parent."""
    if os.getpid() == process:
        shutil.rmtree(place, ignore_errors=True)
