"""A bar, fixed at its left end and pulled by a step at its right: the stress wave runs to and fro between 0, 1 and 2.

Test (a) of Chen and Brannon (2002), SAND2002-0482, section 4, Figs 1 and 2, with 10, 100 and 500 particles, one in each cell. The
report says that the method here behaves like finite elements with one Gauss point; so the same bar, material and boundary
layers run once more with FEM, which is one line of METHODS. The exact stress is d'Alembert's. Displacements stay below 2e-4 L,
so that no particle leaves its cell.

Runs in about ten seconds (quick: without the 500 particles). Writes docs/images/bar_pulled.png when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.boundaries import TwoPointTraction, Wall
from mpmkit.discretizations import FEM
from mpmkit.exact import ForcedBar, Step
from mpmkit.integrators import MUSL
from mpmkit.materials import LinearElastic
from mpmkit.shapes import Linear

F, L, E, RHO = 1.0, 1.0, 1e4, 1.0
BAR = ForcedBar(right=Step(F), left="fixed", L=L, E=E, rho=RHO)
TRIP = L / BAR.C  # the wave crosses the bar once
TIMES = np.array([0.5, 1.5, 2.5, 3.5]) * TRIP
METHODS = {
    "MPM": {"shape": Linear(), "integrator": MUSL(cfl=0.2)},
    "FEM": {"discretization": FEM(cfl=0.2)},
}
EXACT = {
    "stress behind the front": F,
    "front": 0.5 * L,
    "front, FEM": 0.5 * L,
    "furthest displacement of the end": 2 * F * L / E,
    "mean displacement of the end": F * L / E,
    "period": 4 * TRIP,
}


def scene(N, method="MPM"):
    h = L / N
    sim = mpm.Simulation(mpm.Grid(0.0, L + 2 * h, h, lateral="stress"), **METHODS[method])
    sim += mpm.Body(mpm.Box(0.0, L), LinearElastic(E=E, nu=0.0, rho=RHO), particles_per_cell=1, name="bar")
    sim += Wall("xmin", "no slip"), TwoPointTraction(body="bar", traction=(F,), face="xmax")
    return sim


def profiles(N, method="MPM"):
    """Particles at the start, X, and their stress at each of TIMES."""
    sim = scene(N, method)
    X, stress = sim.particles("bar")["x"][:, 0], []
    for t in TIMES:
        sim.run(until=t, quiet=True)
        stress.append(sim.particles("bar")["stress"][:, 0])
    return X, np.array(stress)


def end_motion(N, until):
    """Displacement of the last particle, which lies half a cell inside the bar, over time."""
    sim = scene(N)
    X, times, moved = sim.particles("bar")["x"][-1, 0], np.linspace(0.0, until, 121), [0.0]
    for t in times[1:]:
        sim.run(until=t, quiet=True)
        moved.append(sim.particles("bar")["x"][-1, 0] - X)
    return X, times, np.array(moved)


def error(X, stress):
    """Mean over the bar and TIMES of the error in stress, in units of the load."""
    return float(np.abs(stress - BAR.stress(X, TIMES[:, None])).mean() / F)


def place(X, stress, level):
    """Where a profile that rises to the right passes a level, in steps much finer than the particles."""
    fine = np.linspace(X[0], X[-1], 20001)
    return fine[np.argmax(np.interp(fine, X, stress) > level)]


def main(quick=False, picture=None):
    runs = {(method, N): profiles(N, method) for method in METHODS for N in ((10, 100) if quick else (10, 100, 500))}
    numbers = {f"mean error, {method}, N = {N}": error(X, stress) for (method, N), (X, stress) in runs.items()}

    X, (stress, *_) = runs["MPM", 100]
    numbers["stress behind the front"] = stress[X > 0.7].mean()
    numbers["front"] = place(X, stress, 0.5 * F)
    numbers["front, FEM"] = place(X, runs["FEM", 100][1][0], 0.5 * F)
    numbers["width of the front in cells"] = (place(X, stress, 0.9 * F) - place(X, stress, 0.1 * F)) * 100
    numbers["highest stress at the first time"] = stress.max()

    motion = end_motion(100, 6 * TRIP)
    _, t, u = motion
    rising = np.flatnonzero((u[:-1] < F * L / E) & (u[1:] >= F * L / E))
    passes = t[rising] + (F * L / E - u[rising]) / (u[rising + 1] - u[rising]) * t[1]
    numbers["furthest displacement of the end"] = u.max()
    numbers["mean displacement of the end"] = np.interp(np.linspace(0, 4 * TRIP, 1000), t, u).mean()
    numbers["period"] = passes[1] - passes[0]
    if picture:
        draw(runs, motion, picture)
    return numbers


def check(n):
    # Errors: what other codes of the same scheme reach with these particles; the rest: the wave's own numbers.
    for name, largest in ((", N = 10", 0.40), (", N = 100", 0.16), (", N = 500", 0.08)):
        assert all(value < largest for key, value in n.items() if key.endswith(name))
    assert abs(n["stress behind the front"] - F) < 0.003 * F
    assert abs(n["front"] - 0.5) < 0.03 and abs(n["front, FEM"] - 0.5) < 0.03
    assert n["width of the front in cells"] < 8 and n["highest stress at the first time"] < 1.30 * F
    for name in ("furthest displacement of the end", "mean displacement of the end", "period"):
        assert abs(n[name] / EXACT[name] - 1) < 0.02


def draw(runs, motion, path):
    """Stress along the bar, one column for each number of particles and one row for each time; the end over time below."""
    figure = plotting.figure(9.2, 8.4)
    above, below = figure.subfigures(2, 1, height_ratios=(3.2, 1))
    columns = sorted({N for _, N in runs})
    panels = above.subplots(len(TIMES), len(columns), sharex=True, sharey=True, squeeze=False)
    x = np.linspace(0.0, L, 2001)
    for row, panel_row in enumerate(panels):
        for N, panel in zip(columns, panel_row, strict=True):
            panel.plot(x, BAR.stress(x, TIMES[row]), color="#22262b", lw=1, label="exact")
            for method, width in (("FEM", 2.6), ("MPM", 1.2)):
                X, stress = runs[method, N]
                panel.plot(
                    X,
                    stress[row],
                    "o-" if N == 10 else "-",
                    lw=width,
                    ms=3.5,
                    color={"FEM": "#efb98d", "MPM": "#2f6db3"}[method],
                    label=method,
                )
            panel.set(ylim=(-0.6, 2.9), yticks=(0, 1, 2))
        panel_row[0].set_ylabel(f"stress [Pa]\nt = {TIMES[row] / TRIP:.1f} L/C")
    for N, panel, last in zip(columns, panels[0], panels[-1], strict=True):
        panel.set_title(f"{N} particles")
        last.set_xlabel("x [m]")
    panels[0, 0].legend(loc="upper left", ncols=3, columnspacing=1, handlelength=1.2, borderpad=0)

    axis, (X, t, u) = below.subplots(), motion
    axis.plot(t / TRIP, BAR.displacement(X, t) * 1e3, color="#22262b", lw=1, label="exact")
    axis.plot(t / TRIP, u * 1e3, label="last of 100 particles, MPM")
    axis.set(xlabel="t [L/C]", ylabel="displacement\nof the end [mm]", xlim=(0, 6), ylim=(0, 0.29))
    axis.legend(loc="upper left", ncols=2)
    plotting.save(figure, path)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "bar_pulled")
