"""The ledger: mass, momentum, energies, works and their balance, one row at a time."""

from __future__ import annotations

from mpmkit._core.running.engine import Engine

COLUMNS = (
    "step", "t", "dt", "mass", "momentum_x", "momentum_y", "momentum_z", "angular_x", "angular_y", "angular_z",
    "kinetic", "stored", "dissipated", "external_work", "boundary_work", "energy", "balance",
    "impulse_x", "impulse_y", "impulse_z", "force_impulse_x", "force_impulse_y", "force_impulse_z", "volume",
)  # fmt: skip
"""Columns of the history: SI units; angular momentum about the origin; impulses of walls and of external forces so far."""


class Ledger:
    """Rows of the history, and the relative energy balance since the start.

    energy = kinetic + stored + dissipated; balance = (energy - energy at the start - works of external forces and
    boundaries) / scale, where the scale is the largest energy or work seen so far. Dissipated energy is that of the
    materials, of artificial viscosity, of damping, and of friction at walls and in contact.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.first_energy: float | None = None
        self.scale = 0.0
        self.last: dict[str, float] = {}

    def row(self, dt: float) -> dict[str, float]:
        """Sum up the present state."""
        e = self.engine
        s = e.ledger()
        dissipated = s["dissipated"] + s["viscous"] + s["effect_dissipation"] + s["friction"]
        energy = s["kinetic"] + s["stored"] + dissipated
        if self.first_energy is None:
            self.first_energy = energy
        work = s["external"] + s["boundary"]
        self.scale = max(self.scale, abs(energy), abs(s["kinetic"]), abs(s["stored"]), abs(work))
        imbalance = energy - self.first_energy - work
        row: dict[str, float] = {"step": e.step_number, "t": e.t, "dt": dt} | {k: s[k] for k in s if k in COLUMNS}
        row |= {"dissipated": dissipated, "external_work": s["external"], "boundary_work": s["boundary"], "energy": energy}
        row["balance"] = imbalance / self.scale if self.scale > 0.0 else 0.0
        row |= {f"force_impulse_{a}": s[f"force_{a}"] for a in "xyz"}
        self.last = {name: row[name] for name in COLUMNS}
        return self.last
