"""Two elastic-plastic bars collide: with hardening they bounce off at half their speed, perfectly plastic at a fifth of it.

Tests (f) and (g) of Chen and Brannon (2002), SAND2002-0482, section 4, Figs 13 to 20: tangent modulus E/4 and 0, with 50 and 100 particles
in each bar. The report gives neither speed nor yield stress; here V0 = 0.1 and Y = 4, so that rho C V0 = 10 = 2.5 Y. Reference is
the exact solution that follows every front. With hardening an elastic precursor of -4 runs ahead of a plastic wave at
half its speed, behind which the stress is -7. Perfectly plastic bars cannot carry more than -4: all flow gathers in a
hinge at the interface, as much as it takes, in whatever share between the two bars.

Runs in about ten seconds (quick: 50 particles only). Writes docs/images/bar_plastic_impact.png when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.contacts import FrictionalContact
from mpmkit.exact import PlasticBarImpact
from mpmkit.integrators import MUSL
from mpmkit.materials import VonMises
from mpmkit.shapes import Linear

L, E, RHO, V0, Y, GAP = 0.5, 1e4, 1.0, 0.1, 4.0, 0.02
LAWS = {"hardening": E / 4, "perfect": 0.0}  # tangent moduli
BARS = {law: PlasticBarImpact(V0=V0, L=L, E=E, rho=RHO, Y=Y, Et=Et) for law, Et in LAWS.items()}
START, TRIP = GAP / (2 * V0), L / np.sqrt(E / RHO)
TIMES = TRIP * np.arange(-0.5, 6.0, 0.02)  # after the contact
EXACT = {
    f"{what}, {law}, N = {N}": value
    for N in (50, 100)
    for law, bar in BARS.items()
    for what, value in {
        "begins late by": 0.0,
        "separation": bar.separation_time,
        "restitution": bar.restitution,
        "shortening": bar.plastic_shortening(bar.separation_time),
    }.items()
}


def scene(N, law):
    h = L / N
    metal = VonMises(E=E, nu=0.0, rho=RHO, yield_stress=Y, tangent_modulus=LAWS[law], strain="small")
    sim = mpm.Simulation(mpm.Grid(-4 * h, 2 * L + GAP + 4 * h, h, lateral="stress"), shape=Linear(), integrator=MUSL(cfl=0.2))
    sim += mpm.Body(mpm.Box(0.0, L), metal, v=+V0, particles_per_cell=1, name="left")
    sim += mpm.Body(mpm.Box(L + GAP, 2 * L + GAP), metal, v=-V0, particles_per_cell=1, name="right")
    sim += FrictionalContact()
    return sim


def run(N, law):
    """Distance of the left bar's particles from the contact, its momentum and stress at TIMES, and both bars at the end."""
    sim = scene(N, law)
    X, momentum, stress = L - sim.particles("left")["x"][:, 0], [], []
    for t in START + TIMES:
        sim.run(until=t, quiet=True)
        left = sim.particles("left")
        momentum.append(left["v"].mean() / V0)
        stress.append(left["stress"][:, 0])
    return X, np.array(momentum), np.array(stress), sim.particles()


def measure(N, momentum, stress, end):
    """The contact from the force on the left bar, which is the slope of its momentum; plastic strain from both bars."""
    force = -np.gradient(momentum, TIMES) * RHO * L * V0
    touching = TIMES[force > 0.5]  # of 7 and 4 in the main impact, 1.7 and 2 before separation
    return {
        "begins late by": touching[0],
        "separation": touching[-1],
        "restitution": -momentum[-1],
        "shortening": (end["eps_p"] * L / N).sum() / 2,  # of one bar
        "largest stress": np.abs(stress).max(),
    }


def main(quick=False, picture=None):
    runs = {(law, N): run(N, law) for N in ((50,) if quick else (50, 100)) for law in LAWS}
    numbers = {}
    for (law, N), (_, momentum, stress, end) in runs.items():
        numbers |= {f"{what}, {law}, N = {N}": value for what, value in measure(N, momentum, stress, end).items()}
    if picture:
        draw(runs, picture)
    return numbers


def check(n):
    # Bands of other codes with contact and these particles: restitution 0.04 and 0.03, separation 5 %, shortening 5 and 6 %.
    for name, value in n.items():
        what, law, _ = name.split(", ")
        bar, hardening = BARS[law], law == "hardening"
        match what:
            case "begins late by":
                assert abs(value) < 5e-4
            case "separation":
                assert abs(value / bar.separation_time - 1) < 0.05
            case "restitution":
                assert abs(value - bar.restitution) < (0.04 if hardening else 0.03)
            case "shortening":
                assert abs(value / EXACT[name] - 1) < (0.05 if hardening else 0.06)
            case "largest stress":
                assert value < (1.1 * 7.0 if hardening else Y * (1 + 1e-9))  # overshoot of the plateau; the yield surface


def draw(runs, path):
    """For both laws: stress in the left bar at three times, and the momentum until after the separation."""
    figure = plotting.figure(9.2, 6.0)
    N = max(N for _, N in runs)
    fine = np.linspace(0.0, L, 1001)
    for part, law in zip(figure.subfigures(2, 1), LAWS, strict=True):
        bar, (X, _, stress, _) = BARS[law], runs[law, N]
        part.suptitle({"hardening": "linear hardening, tangent modulus E/4", "perfect": "perfect plasticity"}[law], fontsize=10)
        axes = part.subplots(1, 4, width_ratios=(1.1, 1.1, 1.1, 1.3))
        for axis, trips in zip(axes, (0.6, 1.4, 2.3), strict=False):
            k = np.argmin(np.abs(TIMES - trips * TRIP))
            axis.plot(fine, bar.stress(fine, TIMES[k]), color="#22262b", lw=1, label="exact")
            axis.plot(X, stress[k], lw=1.2, label=f"{N} particles")
            axis.annotate(f"{trips} L/C after contact", (0.97, 0.97), xycoords="axes fraction", ha="right", va="top", color="#6b7280")
            axis.set(ylim=(-8.2, 2.6), xlabel="from the contact [m]", xticks=(0, 0.25, 0.5), yticks=(-8, -6, -4, -2, 0))
        axes[0].set_ylabel("stress [Pa]")
        axes[2].legend(loc="lower right", fontsize=8)
        after = TIMES[TIMES > 0]
        axes[3].plot(after / TRIP, [-bar.mean_velocity(t) / V0 for t in after], color="#22262b", lw=1, label="exact")
        for n, colour in ((50, "#d9772b"), (100, "#2f6db3")):
            if (law, n) in runs:
                axes[3].plot(TIMES / TRIP, runs[law, n][1], lw=1.2, color=colour, label=f"{n} particles")
        axes[3].axvline(bar.separation_time / TRIP, color="#9aa1a9", lw=0.8, ls=":")
        axes[3].set(xlabel="time after contact [L/C]", ylabel="momentum / start", ylim=(-0.65, 1.1))
        axes[3].legend(loc="upper right", fontsize=8)
    plotting.save(figure, path)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "bar_plastic_impact")
