"""A small body in free flight, simulated as plain Python: what any composition must leave alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import ConstitutiveModel
from mpmkit.testing.collect import expect, expect_close
from mpmkit.testing.scenes import plain_python, wave_speed

VELOCITY = (0.8, -0.4)
"""Of the body [m/s]; it crosses cells in both directions."""
E = 1e4
SPACING = 0.25


def law() -> ConstitutiveModel:
    """Of the body."""
    from mpmkit.materials import NeoHookean

    made: ConstitutiveModel = NeoHookean(E=E, nu=0.3, rho=1000.0)
    return made


def flight(g: tuple[float, float] | None = None, **choices: Any) -> Any:
    """Results of a flight of 0.2 s, under gravity if `g` is given; `choices` as of `Simulation`, MUSL with B-splines if none."""
    import mpmkit as mpm
    from mpmkit import effects, integrators, shapes

    if "discretization" not in choices:
        choices = {"shape": shapes.QuadraticBSpline(), "integrator": integrators.MUSL()} | choices
    with plain_python():
        sim = mpm.Simulation(mpm.Grid(lower=(0.0, 0.0), upper=(1.0, 1.0), spacing=SPACING), **choices)
        sim += mpm.Body(mpm.Box((0.3, 0.3), (0.6, 0.55)), law(), v=VELOCITY)
        if g is not None:
            sim += effects.Gravity(g)
        return sim.run(until=0.2, quiet=True)


def check_free_flight(**choices: Any) -> None:
    """A body that nothing acts on keeps its velocity, stays without stress and conserves mass and momentum.

    Tolerance (rounding): 1e-12 of velocity and of modulus; some twenty steps, each with rounding of a few machine epsilons.
    """
    results = flight(**choices)
    first, last = results.frames[0], results.frames[-1]
    steps = int(results.history["step"][-1])
    expect(steps > 5, f"the flight took only {steps} steps")
    wanted = np.zeros_like(last["v"])
    wanted[:, :2] = VELOCITY
    expect_close(last["v"], wanted, 1e-12, "velocity of the particles after a free flight")
    expect_close(last["x"] - first["x"], 0.2 * wanted, 1e-12, "displacement of the particles after a free flight")
    expect_close(last["stress"], np.zeros_like(last["stress"]), 1e-12 * E * steps, "stress of the particles after a free flight")
    expect_close(last["m"].sum(), first["m"].sum(), 0.0, "mass of the body after a free flight")


def check_free_fall(**choices: Any) -> None:
    """Under uniform acceleration all particles have v0 + g t and stay without stress; they move alike.

    Tolerance (rounding): 1e-12 of velocity and modulus. The place is that of the scheme: x0 + v0 t + g t^2 / 2 to g t times half a step.
    """
    g = (0.3, -1.2)
    results = flight(g, **choices)
    first, last = results.frames[0], results.frames[-1]
    t, steps = 0.2, int(results.history["step"][-1])
    stepper: Any = choices.get("discretization") or choices.get("integrator")
    longest = getattr(stepper, "dt", None) or getattr(stepper, "cfl", 1.0) * SPACING / wave_speed(law())
    v = np.zeros_like(last["v"])
    v[:, :2] = np.add(VELOCITY, np.multiply(t, g))
    expect_close(last["v"], v, 1e-12, "velocity of the particles after a free fall")
    moved = last["x"] - first["x"]
    expect_close(moved, np.broadcast_to(moved[0], moved.shape), 1e-12, "displacements of particles that fall together")
    ideal = np.add(np.multiply(t, VELOCITY), 0.5 * t**2 * np.array(g))
    late = 0.5 * t * longest * float(np.linalg.norm(g)) * (1.0 + 1e-9)
    expect_close(moved[0, :2], ideal, late, "displacement of a free fall, to half a step")
    expect_close(last["stress"], np.zeros_like(last["stress"]), 1e-12 * E * steps, "stress of the particles after a free fall")
