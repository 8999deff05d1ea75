"""Bodies at rest."""

from __future__ import annotations

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure, simulation
from mpmkit.stability.cases._tools import fixed, run, step, wave_speed, with_material

H, STEPS = 0.1, 100_000


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Two blocks that touch each other and a floor, off the grid's lines; a hundredth of the steps in quick runs."""
    from mpmkit.boundaries import Wall
    from mpmkit.materials import NeoHookean

    material = with_material(composition, NeoHookean(E=1e4, nu=0.3, rho=1.0))
    grid = mpm.Grid((0.0, 0.0), (1.0, 0.6), H)
    dt = step(composition, H, wave_speed(material, grid, composition))
    sim = simulation(fixed(composition, dt), grid)
    sim += mpm.Body(mpm.Box((0.23, 0.0), (0.48, 0.25)), material, name="left", lattice="body")
    sim += mpm.Body(mpm.Box((0.48, 0.0), (0.73, 0.25)), material, name="right", lattice="body")
    sim += Wall("ymin")
    if composition.contact is not None:
        sim += composition.contact
    before = {name: sim.particles(name) for name in ("left", "right")}
    x, F = ({name: np.array(p[field]) for name, p in before.items()} for field in ("x", "F"))
    run(sim, (STEPS // 100 if quick else STEPS) * dt)
    after = {name: sim.particles(name) for name in before}
    return [
        Figure("distance moved / h", max(float(np.abs(after[n]["x"] - x[n]).max()) / H for n in after), 0.0),
        Figure("speed", max(float(np.abs(after[n]["v"]).max()) for n in after), 0.0),
        Figure("change of F", max(float(np.abs(after[n]["F"] - F[n]).max()) for n in after), 0.0),
    ]


CASE = Case(
    name="rest",
    title="Two blocks and a floor touch each other and nothing acts",
    failure="Sums of weights or slopes that are not exactly one or zero, contact or walls that push bodies which only touch, and a strain "
    "update whose exponential of zero is not the identity let bodies creep.",
    criterion="After 10^5 steps every position, velocity and deformation gradient is exactly what it was: the limit is zero.",
    source="Newton's first law.",
    dim=2,
    measure=measure,
    contact=True,
    material=True,
)
