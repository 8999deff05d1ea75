"""Two equal elastic bars collide: compressed to -rho C V0 they part again after twice the time of a wave through one bar.

Test (d) of Chen and Brannon (2002), SAND2002-0482, section 4, Figs 7 to 10: bars of length 0.5, half a metre apart, 50 and 100 particles
each; the report does not give the speed, here it is 0.4 m/s each, a strain of 0.4 %. Two ways are compared. Without a contact
algorithm all bodies share one velocity field, as in the report: the impact is felt when the faces are still up to one cell
apart, and with other speeds or smoother shape functions bars may even stick. With FrictionalContact each body has its
own field and the gap between the faces counts: the impact begins and ends on time. The faces meet at a node here.

Runs in half a minute (quick: 50 particles only, a few seconds). Writes docs/images/bar_impact.png when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.contacts import FrictionalContact
from mpmkit.exact import BarImpact
from mpmkit.integrators import MUSL
from mpmkit.materials import LinearElastic
from mpmkit.shapes import Linear

L, E, RHO, GAP, V0 = 0.5, 1e4, 1.0, 0.5, 0.4
IMPACT = BarImpact(V0=V0, L=L, gap=GAP, E=E, rho=RHO)
START, LONG, TRIP = IMPACT.contact_time, IMPACT.duration, L / IMPACT.C
TIMES = START + TRIP * np.arange(-3.0, 4.0, 0.02)
FLIGHT, REBOUND = np.linspace(0.0, TIMES[0], 10)[1:-1], np.linspace(TIMES[-1], 1.25 * START, 4)[1:]
SCENES = {"contact": FrictionalContact(), "single field": None}
MEASURED = {
    "begins": START,
    "duration": LONG,
    "stress at L/C": IMPACT.contact_stress,
    "lowest kinetic energy": 0.0,
    "restitution": 1.0,
    "momentum": 0.0,
}
EXACT = {f"{what}, {how}, N = {N}": value for N in (50, 100) for how in SCENES for what, value in MEASURED.items()}


def scene(N, contact=None):
    elastic = LinearElastic(E=E, nu=0.0, rho=RHO)
    sim = mpm.Simulation(mpm.Grid(0.0, 2 * L + GAP, L / N, lateral="stress"), shape=Linear(), integrator=MUSL(cfl=0.2))
    sim += mpm.Body(mpm.Box(0.0, L), elastic, v=+V0, particles_per_cell=1, name="left")
    sim += mpm.Body(mpm.Box(L + GAP, 2 * L + GAP), elastic, v=-V0, particles_per_cell=1, name="right")
    if contact:
        sim += contact
    return sim


def run(N, contact=None, rebound=REBOUND):
    """Particles at the start, X, positions at all times; at TIMES the momentum of the left bar and the stress; the history."""
    sim = scene(N, contact)
    X = sim.particles()["x"][:, 0]
    x, momentum, stress = [X], [], []
    for t in [*FLIGHT, *TIMES, *rebound]:
        sim.run(until=t, quiet=True)
        both, left = sim.particles(), sim.particles("left")
        x.append(both["x"][:, 0])
        if TIMES[0] <= t <= TIMES[-1]:
            momentum.append(left["v"].mean() / V0)
            stress.append(both["stress"][:, 0])
    return X, np.array(x), np.array(momentum), np.array(stress), sim.history


def measure(momentum, stress, history):
    """Begin and end of the contact from the force on the left bar, which is the slope of its momentum; the rest from both bars."""
    force = -np.gradient(momentum, TIMES) * L / IMPACT.C  # in units of rho C V0, its exact value
    touching = TIMES[force > 0.5]
    return {
        "begins": touching[0],
        "duration": touching[-1] - touching[0],
        "stress at L/C": stress[np.searchsorted(TIMES, touching[0] + TRIP)].mean(),
        "lowest kinetic energy": history["kinetic"].min() / history["kinetic"][0],
        "restitution": -momentum[-1],
        "momentum": np.abs(history["momentum_x"]).max() / (RHO * L * V0),
    }


def main(quick=False, picture=None):
    runs = {
        (how, N): run(N, contact, REBOUND if picture else ()) for N in ((50,) if quick else (50, 100)) for how, contact in SCENES.items()
    }
    numbers = {}
    for (how, N), (_, _, momentum, stress, history) in runs.items():
        numbers |= {f"{what}, {how}, N = {N}": value for what, value in measure(momentum, stress, history).items()}
    if picture:
        draw(runs, picture)
    return numbers


def check(n):
    for name, value in n.items():
        what, how, N = name.split(", ")
        early = 0.5 * L / int(N[4:]) / V0 if how == "single field" else 0.0  # faces one cell apart already share a node
        match what:
            case "begins":
                assert abs(value - (START - early)) < 5e-4
            case "duration":
                assert abs(value / LONG - 1) < 0.03
            case "stress at L/C":
                assert abs(value / IMPACT.contact_stress - 1) < 0.05
            case "lowest kinetic energy":
                assert value < 0.02
            case "restitution":
                assert 0.95 < value < 1.0
            case "momentum":
                assert value < 1e-12


def draw(runs, path):
    """Above: stress before, in and after full compression. Below: the motion (Fig 7), and the momentum of the left bar."""
    figure = plotting.figure(9.2, 6.4)
    N = max(N for _, N in runs)
    X, x, _, stress, _ = runs["contact", N]
    side = X > L + 0.5 * GAP
    fine = np.linspace(0.0, L, 1001)
    above, below = figure.subfigures(2, 1, height_ratios=(1, 1.25))
    for panel, trips in zip(above.subplots(1, 4, sharey=True), (0.3, 0.8, 1.3, 1.8), strict=True):
        k = np.argmin(np.abs(TIMES - START - trips * TRIP))
        panel.plot(
            np.concatenate([fine - L, fine]),
            [*IMPACT.stress(fine, TIMES[k]), *IMPACT.stress(fine + L + GAP, TIMES[k])],
            color="#22262b",
            lw=1,
        )
        panel.plot(X - L - GAP * side, stress[k], lw=1.2)
        panel.axvline(0.0, color="#9aa1a9", lw=0.8, ls=":")
        panel.set(
            title=f"{trips} L/C after contact",
            xlabel="distance from the contact [m]",
            xticks=(-0.5, 0, 0.5),
            ylim=(1.45 * IMPACT.contact_stress, -0.4 * IMPACT.contact_stress),
        )
    above.axes[0].set_ylabel("stress [Pa]")

    motion, history = below.subplots(1, 2)
    for k in range(0, 2 * N, N // 10):
        motion.plot(x[:, k], [0.0, *FLIGHT, *TIMES, *REBOUND], color="#d9772b" if side[k] else "#2f6db3", lw=0.9)
    motion.axhline(START, color="#9aa1a9", lw=0.8)
    motion.set(xlabel="x [m]", ylabel="t [s]", title=f"every {N // 10}th particle of two bars of {N}, with contact")
    t = (TIMES - START) / TRIP
    history.plot(t, np.clip(1 - t, -1, 1), color="#22262b", lw=1, label="exact")
    for (how, n), (_, _, momentum, *_) in runs.items():
        history.plot(t, momentum, lw=1.4, ls="-" if how == "contact" else "--", label=f"{how}, {n} particles")
    history.set(xlabel="time after contact [L/C]", ylabel="momentum of the left bar / start", xlim=(-3, 6.5))
    history.legend(loc="upper right")
    plotting.save(figure, path)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "bar_impact")
