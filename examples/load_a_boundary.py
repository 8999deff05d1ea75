"""How to load a moving boundary: by a layer of particles, or at the boundary itself. Swapping one line of the scene decides.

The question of Chen and Brannon (2002), SAND2002-0482: section 1 lets a layer of particles carry the traction (eq 1-16), section 2 proposes
to give the boundary particle a vector to the boundary, with fields varying linearly in between. The bar of test (a) tells
them apart. Its last cell has two nodes; what the inner one gets of the load never stretches that cell. A layer hands its load
out from the particles' centres, so in the last cell only the share N = 1 - d/h remains, with d the depth of the layer's
centre: 1/2 for a layer of one cell, 3/4 for half a cell, 7/8 for a quarter. At the boundary itself d = 0 and the share is 1.
Behind the last cell all are right.

Runs in about ten seconds. Writes docs/images/load_a_boundary.png when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.boundaries import TractionLayer, TwoPointTraction, Wall
from mpmkit.integrators import MUSL
from mpmkit.materials import LinearElastic
from mpmkit.shapes import Linear

F, L, E, RHO, N = 1.0, 1.0, 1e4, 1.0, 50
H, TRIP = L / N, L / np.sqrt(E / RHO)
LOADS = {  # particles in a cell, boundary layer
    "layer, one cell": (1, TractionLayer(body="bar", traction=(F,), face="xmax")),
    "layer, half a cell": (2, TractionLayer(body="bar", traction=(F,), face="xmax", thickness=H / 2)),
    "layer, a quarter": (4, TractionLayer(body="bar", traction=(F,), face="xmax", thickness=H / 4)),
    "two points, 1 particle": (1, TwoPointTraction(body="bar", traction=(F,), face="xmax")),
    "two points, 2 particles": (2, TwoPointTraction(body="bar", traction=(F,), face="xmax")),
    "two points, 4 particles": (4, TwoPointTraction(body="bar", traction=(F,), face="xmax")),
}
SHARE = {name: 1.0 if "two" in name else 1 - 0.5 / ppc for name, (ppc, _) in LOADS.items()}
EXACT = {f"last cell, {name}": F for name in LOADS} | {f"second cell, {name}": F for name in LOADS}


def scene(ppc, load):
    sim = mpm.Simulation(mpm.Grid(0.0, L + 2 * H, H, lateral="stress"), shape=Linear(), integrator=MUSL(cfl=0.2))
    sim += mpm.Body(mpm.Box(0.0, L), LinearElastic(E=E, nu=0.0, rho=RHO), particles_per_cell=ppc, name="bar")
    sim += Wall("xmin", "no slip")
    sim += load
    return sim


def mean_stress(ppc, load):
    """Particles at the start, X, and their stress at 0.5 L/C and averaged over 0.2 to 1.8 L/C, when the end is under the load alone."""
    sim = scene(ppc, load)
    X, stress = sim.particles("bar")["x"][:, 0], []
    times = np.linspace(0.2, 1.8, 161) * TRIP
    for t in times:
        sim.run(until=t, quiet=True)
        stress.append(sim.particles("bar")["stress"][:, 0])
    return X, stress[np.argmin(np.abs(times - 0.5 * TRIP))], np.mean(stress, axis=0)


def main(quick=False, picture=None):
    chosen = {k: v for k, v in LOADS.items() if not (quick and v[0] == 4)}
    runs = {name: mean_stress(*load) for name, load in chosen.items()}
    numbers = {}
    for name, (X, _, mean) in runs.items():
        numbers[f"last cell, {name}"] = mean[X > L - H].mean()
        numbers[f"second cell, {name}"] = mean[(X < L - H) & (X > L - 2 * H)].mean()
    if picture:
        draw(runs, picture)
    return numbers


def check(n):
    for name, value in n.items():
        cell, load = name.split(", ", 1)
        share = SHARE[load] if cell == "last cell" else 1.0
        assert abs(value / F - share) < 0.02  # mean of a vibration over 160 samples


def draw(runs, path):
    """Left: the first stress wave near the loaded end. Right: the mean stress of the last cells."""
    figure = plotting.figure(9.2, 3.8)
    wave, mean = figure.subplots(1, 2, width_ratios=(1.2, 1))
    for name, colour in (("layer, one cell", "#c2455a"), ("layer, half a cell", "#d9772b"), ("two points, 2 particles", "#2f6db3")):
        X, stress, _ = runs[name]
        wave.plot(X, stress, lw=1.2, color=colour, label=name)
    wave.plot([0.4, 0.5, 0.5, L], [0, 0, F, F], color="#22262b", lw=1, label="exact", zorder=0)
    wave.set(xlim=(0.4, 1.01), ylim=(-0.1, 1.5), xlabel="x [m]", ylabel="stress [Pa]", title="t = 0.5 L/C")
    wave.legend(loc="lower right", fontsize=8)
    for (name, (X, _, stress)), style in zip(runs.items(), ("o-", "s-", "^-", "o-", "s-", "^-"), strict=False):
        near = X > L - 4 * H
        mean.plot((X[near] - L) / H, stress[near], style, lw=1, ms=4, color="#2f6db3" if "two" in name else "#c2455a", label=name)
    mean.axhline(F, color="#22262b", lw=0.8, zorder=0)
    mean.set(
        xlabel="cells from the loaded end", ylabel="mean stress [Pa]", title="mean while the end is under the load alone", ylim=(0.4, 1.1)
    )
    mean.legend(loc="lower left", fontsize=8)
    plotting.save(figure, path)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "load_a_boundary")
