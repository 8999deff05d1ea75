"""Do two programs solve the same problem? Asked before a ratio of their speeds is believed."""

from __future__ import annotations

from typing import Any

ROUNDING = {"f64": 1e-12, "f32": 1e-5}
"""Relative differences from rounding in 20 steps: sums over 2e5 particles, float32 with its eps of 1e-7 in 20 steps."""
BY_CONSTRUCTION = {
    "flip3": (
        1e-4,
        "mpmkit limits the velocities that light nodes give to the strain, the other programs leave out the forces there (which costs them "
        "momentum); a few nodes at the edge of the block differ",
    )
}
"""Cases in which mpmkit and the other programs cannot agree to rounding: how near they must be, and why."""


def difference(a: dict[str, float], b: dict[str, float]) -> tuple[float, str]:
    """Largest relative difference between two sets of diagnostics, and the name of the number it belongs to."""
    if set(a) != set(b):
        raise ValueError(f"diagnostics have different names: {', '.join(sorted(set(a) ^ set(b)))}")
    apart = {name: abs(a[name] - b[name]) / max(abs(a[name]), abs(b[name]), 1e-300) for name in a}
    worst = max(apart, key=lambda name: apart[name])
    return apart[worst], worst


def agreement(reference: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Compare the lines of two programs.

    Returns
    -------
    dict
        ``difference`` and ``of``, the number it belongs to; ``allowed``; ``agrees``; ``note`` if more than rounding is allowed.
    """
    for name in ("case", "size", "prec", "threads", "n"):
        if reference[name] != other[name]:
            return {"agrees": False, "note": f"another problem: {name} is {other[name]} in place of {reference[name]}"}
    worst, name = difference(reference["diag20"], other["diag20"])
    allowed, note = ROUNDING[reference["prec"]], ""
    if reference["case"] in BY_CONSTRUCTION and "mpmkit" in (reference["impl"], other["impl"]) and reference["impl"] != other["impl"]:
        loose, note = BY_CONSTRUCTION[reference["case"]]
        allowed = max(allowed, loose)
    return {"difference": worst, "of": name, "allowed": allowed, "agrees": worst <= allowed, "note": note}
