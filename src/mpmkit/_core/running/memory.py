"""Memory that a run is going to need, compared with what there is, before anything of it is allocated."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.composing.layout import components
from mpmkit._core.running.snapshot import IN_MEMORY
from mpmkit._core.running.unpacking import LARGE_FRAME
from mpmkit.errors import CompositionError
from mpmkit.fields import PARTICLE_FIELDS

if TYPE_CHECKING:
    from mpmkit._core.composing.plan import Plan

SORTING = 16
"""Bytes per particle for its number, and to sort by place."""
PARTLY_FILLED = 2.0
"""Nodes that are stored for each node in a filled cell: blocks at the surface are partly empty."""


def check(plan: Plan, available: int | None = None) -> None:
    """Compare what a run will need with the memory there is.

    Particles are counted from the shapes of the bodies, without sampling them; a body of a method with a mesh is not counted.

    Parameters
    ----------
    plan : Plan
        Of the composition; its layouts say what a particle and a node take.
    available : int, optional
        Bytes that may be used; those of the machine if not given.

    Raises
    ------
    CompositionError
        If it is too little: says how much is needed for what, how much there is, and what to do.
    """
    if plan.composition.stored_operator:
        return
    available = available_bytes() if available is None else available
    needed, particles = needed_bytes(plan)
    total = sum(needed.values())
    if available is None or total <= available:
        return
    parts = ", ".join(f"{text(n)} for {what}" for what, n in needed.items() if n > 0.001 * total)
    smaller = "" if plan.composition.sim.precision == "float32" else ', or take precision="float32"'
    raise CompositionError(
        f"this run needs about {text(total)} of memory for about {particles:,} particles ({parts}), and {text(available)} are available. "
        f"To fix: use a coarser grid or fewer particles_per_cell{smaller}"
    )


def needed_bytes(plan: Plan) -> tuple[dict[str, int], int]:
    """Bytes by what they are for, and the number of particles, both estimated."""
    c = plan.composition
    sim, dim, itemsize = c.sim, c.dim, np.dtype(plan.dtype).itemsize
    particles = state = 0
    cells = 0.0
    for k, body in enumerate(sim.bodies):
        n = body.estimated_count(sim.grid)
        particles += n
        state += n * itemsize * c.group_of(k).layout.size
        cells += n / (body.particles_per_cell or 2**dim)
    needed = {
        "the fields of the particles": state,
        "their positions at the start": particles * 8 * dim,
        "sorting them": particles * SORTING,
        "the nodes": int(PARTLY_FILLED * cells) * itemsize * plan.node_layout.size,
        "a frame to be written": max((_frame(r.fields, c, particles) for r in sim.records), default=0),
        "two copies of the state": 2 * state if state <= IN_MEMORY else 0,
    }
    return needed, particles


def _frame(fields: tuple[str, ...], c: Any, particles: int) -> int:
    """Bytes of a frame as it is kept until it is written: all of it, or of a large one only where each particle lies."""
    whole = 4 * particles * (3 + sum(_shown(name, c) for name in fields if name != "x"))
    return whole if whole < LARGE_FRAME else 4 * particles


def _shown(name: str, c: Any) -> int:
    """Components of a field in a result file."""
    field = next((g.layout.fields[name] for g in c.groups if name in g.layout.fields), PARTICLE_FIELDS.get(name))
    return 0 if field is None else 3 if field.shape == "vector" else len(components(field, "3D", 3))


def available_bytes() -> int | None:
    """Memory that this process may still take: of the machine, of its control groups, and of its own limit; None if not known."""
    found = [n for n in (_of_machine(), *_of_groups(), _of_process()) if n is not None]
    return max(0, min(found)) if found else None


def text(n: int) -> str:
    """Bytes with a unit, such as "3.2 GB"."""
    for limit, unit in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if n >= limit:
            return f"{n / limit:.3g} {unit}"
    return f"{n} B"


def _of_machine() -> int | None:
    for line in _lines("/proc/meminfo"):
        if line.startswith("MemAvailable:"):
            return int(line.split()[1]) * 1024
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None


def _of_groups(root: str = "/sys/fs/cgroup", groups: str = "/proc/self/cgroup") -> list[int]:
    """What the control groups of this process leave, those around them included; both versions of the interface."""
    left = []
    for line in _lines(groups):
        _, controllers, path = line.strip().split(":", 2)
        if controllers == "":
            base, names = Path(root), ("memory.max", "memory.current", "inactive_file")
        elif "memory" in controllers.split(","):
            base, names = Path(root) / "memory", ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        else:
            continue
        here = base / path.strip("/")
        for folder in (here, *here.parents):
            if folder.is_relative_to(base):
                left += _left(folder, *names)
    return left


def _left(folder: Path, limit: str, used: str, reclaimable: str) -> list[int]:
    """The limit less what is used; files that the system only holds for later reading are given back when memory is short."""
    most, now = _lines(folder / limit), _lines(folder / used)
    if not most or not now or not most[0].strip().isdigit():
        return []
    files = [int(line.split()[1]) for line in _lines(folder / "memory.stat") if line.startswith(f"{reclaimable} ")]
    return [int(most[0]) - int(now[0]) + sum(files)]


def _of_process() -> int | None:
    """A limit on the address space, as by ``ulimit -v``."""
    try:
        import resource
    except ImportError:
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    size = [int(line.split()[1]) * 1024 for line in _lines("/proc/self/status") if line.startswith("VmSize:")]
    return None if limit == resource.RLIM_INFINITY or not size else limit - size[0]


def _lines(path: str | Path) -> list[str]:
    try:
        return Path(path).read_text().splitlines()
    except OSError:
        return []
