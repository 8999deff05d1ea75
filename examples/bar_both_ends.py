"""Both ends of a free bar are pulled by a step, or hit by a pulse: where the waves meet, the bar stretches but does not break.

Tests (b) and (c) of Chen and Brannon (2002), SAND2002-0482, section 4, Figs 3 to 6. Under the step the stress runs between 0 and 2
in the middle. Compressive pulses of duration L/C cross, double, come back from the ends as tension, and at 1.5 L/C every
point is back in its place and free of stress, each half moving outwards. The report asks whether particles part where two
tensile waves meet. They do not: a cell that holds a particle ties its nodes.

Runs in a few seconds. Writes docs/images/bar_both_ends.png when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.boundaries import TwoPointTraction
from mpmkit.exact import ForcedBar, Pulse, Step
from mpmkit.integrators import MUSL
from mpmkit.materials import LinearElastic
from mpmkit.shapes import Linear

L, E, RHO, C = 1.0, 1e4, 1.0, 100.0
TRIP = L / C  # a wave crosses the bar once
LOADS = {"step": "1.0", "pulse": "-1.0 if t < 0.01 else 0.0"}  # tension positive
BARS = {
    "step": ForcedBar(left=Step(1.0), right=Step(1.0), L=L, E=E, rho=RHO),
    "pulse": ForcedBar(left=Pulse(-1.0, TRIP), right=Pulse(-1.0, TRIP), L=L, E=E, rho=RHO),
}
TIMES = np.array([0.5, 1.5, 2.5, 3.5]) * TRIP
EXACT = {
    "mean stress at L/C, step": 2.0,
    "period of the end, step": 2 * TRIP,
    "mean stress at L/C, pulse": -2.0,
    "stress at 1.5 L/C, pulse": 0.0,
    "displacement at 1.5 L/C, pulse": 0.0,
    "speed at 1.5 L/C, pulse": 0.02,
}


def scene(N, load):
    h = L / N
    sim = mpm.Simulation(mpm.Grid(-2 * h, L + 2 * h, h, lateral="stress"), shape=Linear(), integrator=MUSL(cfl=0.2))
    sim += mpm.Body(mpm.Box(0.0, L), LinearElastic(E=E, nu=0.0, rho=RHO), particles_per_cell=1, name="bar")
    sim += TwoPointTraction(body="bar", traction=(f"-({LOADS[load]})",), face="xmin")
    sim += TwoPointTraction(body="bar", traction=(LOADS[load],), face="xmax")
    return sim


def follow(N, load, times):
    """Particles at the start, X, and their displacement, velocity and stress, one row for each time."""
    sim = scene(N, load)
    X, rows = sim.particles("bar")["x"][:, 0], []
    for t in times:
        sim.run(until=t, quiet=True)
        bar = sim.particles("bar")
        rows.append((bar["x"][:, 0] - X, bar["v"][:, 0], bar["stress"][:, 0]))
    return X, *np.swapaxes(rows, 0, 1)


def main(quick=False, picture=None):
    numbers = {}
    for load, exact in BARS.items():
        for N in (10, 100) if quick else (10, 100, 500):
            X, *_, stress = follow(N, load, TIMES)
            numbers[f"mean error, {load}, N = {N}"] = np.abs(stress - exact.stress(X, TIMES[:, None])).mean()

    t = np.arange(1, 101) * 0.04 * TRIP
    runs = {load: follow(100, load, t) for load in BARS}
    for load, (_, u, _, stress) in runs.items():
        numbers[f"mean stress at L/C, {load}"] = stress[24, 25:75].mean()
        numbers[f"widest gap between neighbours in cells, {load}"] = 1 + np.diff(u).max() * 100
        numbers[f"middle moves, {load}"] = np.abs(u[:, 49] + u[:, 50]).max()
    numbers["period of the end, step"] = period(t, runs["step"][1][:, -1])
    X, (u,), (v,), (stress,) = follow(100, "pulse", [1.5 * TRIP])
    numbers["stress at 1.5 L/C, pulse"] = np.abs(stress).mean()
    numbers["displacement at 1.5 L/C, pulse"] = np.abs(u).mean()
    quarters = np.abs(np.abs(X - 0.5 * L) - 0.25 * L) < 0.15 * L  # away from the ends and the middle, where fronts are
    numbers["speed at 1.5 L/C, pulse"] = (v * np.sign(X - 0.5 * L))[quarters].mean()
    if picture:
        draw(t, runs, picture)
    return numbers


def period(t, u):
    """Time between two passages of a rising displacement through its mean of 1e-4 m."""
    level = 0.5 * L / E
    k = np.flatnonzero((u[:-1] < level) & (u[1:] >= level))
    passes = t[k] + (level - u[k]) / (u[k + 1] - u[k]) * (t[1] - t[0])
    return passes[1] - passes[0]


def check(n):
    # Errors: what other codes of the same scheme reach with these particles.
    for name, step, pulse in (("N = 10", 0.43, 0.66), ("N = 100", 0.20, 0.33), ("N = 500", 0.11, 0.17)):
        assert n.get(f"mean error, step, {name}", 0.0) < step and n.get(f"mean error, pulse, {name}", 0.0) < pulse
    for load in BARS:
        assert abs(n[f"mean stress at L/C, {load}"] - EXACT[f"mean stress at L/C, {load}"]) < 0.05
        assert n[f"widest gap between neighbours in cells, {load}"] < 1 + 2.0 * 2 / E  # twice the strain of the doubled stress: not torn
        assert n[f"middle moves, {load}"] < 1e-12  # symmetry
    assert abs(n["period of the end, step"] / (2 * TRIP) - 1) < 0.02
    assert n["stress at 1.5 L/C, pulse"] < 0.33 and n["displacement at 1.5 L/C, pulse"] < 1e-6  # of 2 and of 1e-4 before
    assert abs(n["speed at 1.5 L/C, pulse"] / 0.02 - 1) < 0.02


def draw(t, runs, path):
    """Stress along the bar at four times, and the motion of chosen particles, for both loads."""
    figure = plotting.figure(9.2, 7.6)
    x = np.linspace(0.0, L, 2001)
    for part, (load, (X, u, _, stress)) in zip(figure.subfigures(2, 1), runs.items(), strict=True):
        exact = BARS[load]
        part.suptitle({"step": "both ends pulled by a step", "pulse": "both ends hit by a pulse of duration L/C"}[load], fontsize=10)
        axes = part.subplot_mosaic([["a", "b", "m"], ["c", "d", "m"]], width_ratios=(1, 1, 1.25))
        for name, k in zip("abcd", (9, 19, 34, 44), strict=True):
            axes[name].plot(x, exact.stress(x, t[k]), color="#22262b", lw=1)
            axes[name].plot(X, stress[k], lw=1.2)
            axes[name].annotate(f"t = {t[k] / TRIP:.1f} L/C", (0.03, 0.93), xycoords="axes fraction", va="top", color="#6b7280")
            axes[name].set(ylim={"step": (-0.9, 3.4), "pulse": (-3.2, 3.9)}[load], ylabel="stress [Pa]" if name in "ac" else "")
            axes[name].set_xlabel("x [m]" if name in "cd" else "")
        for k in (0, 24, 49, 50, 75, 99):
            axes["m"].plot(t / TRIP, exact.displacement(X[k], t) * 1e3, color="#22262b", lw=0.8)
            axes["m"].plot(t / TRIP, u[:, k] * 1e3, lw=1.4, label=f"X = {X[k]:.3g} m")
        axes["m"].set(xlabel="t [L/C]", ylabel="displacement [mm]", ylim=(-0.13, 0.2))
        axes["m"].legend(loc="upper left", ncols=2, handlelength=1.2, columnspacing=1, fontsize=8)
    plotting.save(figure, path)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "bar_both_ends")
