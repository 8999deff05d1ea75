"""The ledger: mass, momentum, energies, works and their balance, one row at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit._core.running.engine import SPEED, Engine

COLUMNS = (
    "step", "t", "dt", "mass", "momentum_x", "momentum_y", "momentum_z", "angular_x", "angular_y", "angular_z",
    "kinetic", "stored", "dissipated", "external_work", "boundary_work", "energy", "balance",
    "impulse_x", "impulse_y", "impulse_z", "force_impulse_x", "force_impulse_y", "force_impulse_z", "volume",
    "left_particles", "left_mass", "left_momentum_x", "left_momentum_y", "left_momentum_z", "left_energy", "repeated",
)  # fmt: skip
"""Columns of the history: SI units; angular momentum about the origin; impulses of walls and of external forces so far; what particles
that were taken out carried away; steps that failed and were done again so far."""


ROUNDING = 100.0
"""Velocities that may be rounding alone, in machine epsilons times the speed of waves and particles."""


class Ledger:
    """Rows of the history, and the relative energy balance since the start.

    energy = kinetic + stored + dissipated; balance = (energy + left_energy - energy at the start - works of external forces and
    boundaries) / scale, where the scale is the largest energy or work seen so far, and no less than that of motions which are
    rounding alone: a body at rest has no other. Dissipated energy is that of the materials, of artificial viscosity, of damping, of
    friction at walls and in contact, and of particles held at a face. Kinetic and stored energy, mass and momentum are those of the
    particles that are there; what others have taken with them out of the domain is left_energy, left_mass and left_momentum. What these
    had dissipated before stays in dissipated.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.first_energy: float | None = None
        self.scale = 0.0
        self.last: dict[str, float] = {}

    def row(self, dt: float, repeated: int = 0) -> dict[str, float]:
        """Sum up the present state; `repeated` steps were done in vain."""
        s = self.engine.ledger()
        energy, work, dissipated, scale = self._energies(s)
        if self.first_energy is None:
            self.first_energy = energy
        self.scale = scale
        row: dict[str, float] = {"step": self.engine.step_number, "t": self.engine.t, "dt": dt} | {k: s[k] for k in s if k in COLUMNS}
        row |= {"dissipated": dissipated, "external_work": s["external"], "boundary_work": s["boundary"], "energy": energy}
        row["balance"] = self._balance(s, energy, work, scale)
        row |= {f"force_impulse_{a}": s[f"force_{a}"] for a in "xyz"} | {"repeated": repeated}
        self.last = {name: row[name] for name in COLUMNS}
        return self.last

    def balance(self) -> float:
        """The balance of the present state, without a row."""
        s = self.engine.ledger()
        energy, work, _, scale = self._energies(s)
        return self._balance(s, energy, work, scale)

    def _energies(self, s: dict[str, float]) -> tuple[float, float, float, float]:
        """Energy, work, dissipated energy and scale."""
        dissipated = s["dissipated"] + s["viscous"] + s["effect_dissipation"] + s["friction"] + s["left_dissipated"]
        energy = s["kinetic"] + s["stored"] + dissipated
        work = s["external"] + s["boundary"]
        rounding = ROUNDING * float(np.finfo(self.engine.dtype).eps) * float(self.engine.outs[:, SPEED].max())
        least = 0.5 * s["mass"] * rounding**2
        return energy, work, dissipated, max(self.scale, abs(energy), abs(s["kinetic"]), abs(s["stored"]), abs(work), least)

    def _balance(self, s: dict[str, float], energy: float, work: float, scale: float) -> float:
        assert self.first_energy is not None
        imbalance = energy + s["left_energy"] - self.first_energy - work
        return imbalance / scale if scale > 0.0 else 0.0

    def facts(self) -> dict[str, Any]:
        """State as plain data."""
        return {"first_energy": self.first_energy, "scale": self.scale, "last": self.last}

    def recall(self, facts: dict[str, Any]) -> None:
        """Go back to this state."""
        self.first_energy, self.scale, self.last = facts["first_energy"], facts["scale"], facts["last"]
