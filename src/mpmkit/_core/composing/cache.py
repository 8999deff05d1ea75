"""Where generated modules live: one folder per digest, safe for concurrent processes, with fallbacks."""

from __future__ import annotations

import importlib.util
import os
import sys
import tempfile
import warnings
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any


@cache
def folder() -> Path:
    """MPMKIT_CACHE_DIR if set, else the user's cache folder, else a temporary one (with one line of notice)."""
    named = os.environ.get("MPMKIT_CACHE_DIR")
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    for place in [Path(named)] if named else [Path(base) / "mpmkit"]:
        try:
            place.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=place):
                return place
        except OSError as error:
            reason = error
    place = Path(tempfile.mkdtemp(prefix="mpmkit-"))
    warnings.warn(f"mpmkit: the cache folder is not writable ({reason}); compiling into {place}, for this process only", stacklevel=2)
    return place


def versions() -> str:
    """What compiled code depends on beside its source: versions and the machine."""
    import llvmlite
    import numba
    import numpy as np

    import mpmkit

    cpu = numba.core.codegen.get_host_cpu_features()  # type: ignore[no-untyped-call]
    host = llvmlite.binding.get_host_cpu_name()
    python = ".".join(map(str, sys.version_info[:3]))
    packages = f"numba {numba.__version__} llvmlite {llvmlite.__version__} numpy {np.__version__}"
    return f"mpmkit {mpmkit.__version__} python {python} {packages} {host} {cpu}"


def load(digest: str, text: str, names: dict[str, Any]) -> ModuleType:
    """Write the module if it is not there, and import it with the components under their `names`."""
    place = folder() / digest
    path = place / "step.py"
    if not path.exists() or path.read_text() != text:
        place.mkdir(exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=place, suffix=".tmp")
        with os.fdopen(handle, "w") as f:
            f.write(text)
        os.replace(temporary, path)
    spec = importlib.util.spec_from_file_location(f"mpmkit_step_{digest}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    vars(module).update(names)
    sys.modules[spec.name] = module  # numba pickles functions by module name
    spec.loader.exec_module(module)
    return module
