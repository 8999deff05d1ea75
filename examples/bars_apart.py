"""Two bars with one empty cell between them, pulled at their outer ends: an empty cell is a gap, and nothing crosses it.

Test (e) of Chen and Brannon (2002), SAND2002-0482, section 4, Figs 11 and 12. Both bodies share one velocity field and there is no
contact algorithm; still each bar moves as if it were alone, because with linear functions no node belongs to both. That
is checked to the last bit: the left bar is computed once more without the right one. Smoother shape functions reach
further: with a quadratic spline and two particles per cell one empty cell is no gap.

Runs in a few seconds. Writes docs/images/bars_apart.png when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.boundaries import TwoPointTraction
from mpmkit.exact import ForcedBar, Step
from mpmkit.integrators import MUSL
from mpmkit.materials import LinearElastic
from mpmkit.shapes import Linear, QuadraticBSpline

F, L, E, RHO, C = 1.0, 0.5, 1e4, 1.0, 100.0
TRIP = L / C
LEFT = ForcedBar(left=Step(F), right="free", L=L, E=E, rho=RHO)  # positions from the left end of each bar
RIGHT = ForcedBar(left="free", right=Step(F), L=L, E=E, rho=RHO)
TIMES = np.array([0.5, 1.5, 2.5, 3.5]) * TRIP
EXACT = {"acceleration of the left bar": -F / (RHO * L), "acceleration of the right bar": F / (RHO * L), "cross-talk, linear": 0.0}


def scene(N, bodies=("left", "right"), shape=None, ppc=1):
    """Cells of 1/N; a fixed time step, so that leaving out a bar does not change it by rounding."""
    h = 1 / N
    integrator = MUSL(dt=0.2 * h / C)
    sim = mpm.Simulation(mpm.Grid(-4 * h, 1 + 5 * h, h, lateral="stress"), shape=shape or Linear(), integrator=integrator)
    elastic = LinearElastic(E=E, nu=0.0, rho=RHO)
    if "left" in bodies:
        sim += mpm.Body(mpm.Box(0.0, L), elastic, particles_per_cell=ppc, name="left")
        sim += TwoPointTraction(body="left", traction=(-F,), face="xmin")
    if "right" in bodies:
        sim += mpm.Body(mpm.Box(L + h, 2 * L + h), elastic, particles_per_cell=ppc, name="right")
        sim += TwoPointTraction(body="right", traction=(F,), face="xmax")
    return sim


def follow(sim, body, times=TIMES):
    """Particles at the start, X, and their displacement, velocity and stress, one row for each time."""
    X, rows = sim.particles(body)["x"][:, 0], []
    for t in times:
        sim.run(until=t, quiet=True)
        now = sim.particles(body)
        rows.append((now["x"][:, 0] - X, now["v"][:, 0], now["stress"][:, 0]))
    return X, *np.swapaxes(rows, 0, 1)


def cross_talk(shape, ppc):
    """Largest change of the left bar's stress when the right bar is left out."""
    *_, beside = follow(scene(100, ("left", "right"), shape, ppc), "left")
    *_, alone = follow(scene(100, ("left",), shape, ppc), "left")
    return np.abs(beside - alone).max()


def main(quick=False, picture=None):
    numbers, runs = {}, {}
    for N in (20, 100) if quick else (20, 100, 500):
        runs[N] = left, right = [follow(scene(N), body) for body in ("left", "right")]
        start = L + 1 / N
        errors = [np.abs(left[3] - LEFT.stress(left[0], TIMES[:, None])), np.abs(right[3] - RIGHT.stress(right[0] - start, TIMES[:, None]))]
        numbers[f"mean error, N = {N}"] = np.mean(errors) / F
        numbers["acceleration of the left bar"], numbers["acceleration of the right bar"] = (
            v[-1].mean() / TIMES[-1] for _, _, v, _ in (left, right)
        )
    numbers["cross-talk, linear"] = cross_talk(Linear(), 1)
    numbers["cross-talk, linear, 2 particles per cell"] = cross_talk(Linear(), 2)
    numbers["cross-talk, quadratic spline, 2 particles per cell"] = cross_talk(QuadraticBSpline(), 2)
    if picture:
        draw(runs, picture)
    return numbers


def check(n):
    # Errors: what other codes of the same scheme reach with these particles.
    for name, largest in (("N = 20", 0.26), ("N = 100", 0.22), ("N = 500", 0.11)):
        assert n.get(f"mean error, {name}", 0.0) < largest
    assert abs(n["acceleration of the left bar"] * RHO * L / F + 1) < 1e-12  # Newton's second law, to rounding
    assert abs(n["acceleration of the right bar"] * RHO * L / F - 1) < 1e-12
    assert n["cross-talk, linear"] == n["cross-talk, linear, 2 particles per cell"] == 0.0
    assert n["cross-talk, quadratic spline, 2 particles per cell"] > 0.1 * F


def draw(runs, path):
    """Stress along both bars at four times: 100 and 500 particles and the exact one, with the gap drawn wider."""
    figure = plotting.figure(9.2, 4.6)
    x = np.linspace(0.0, L, 1001)
    apart = 0.06  # how wide the gap is drawn
    for k, panel in enumerate(figure.subplots(2, 2, sharex=True, sharey=True).flat):
        for side, exact in ((0, LEFT), (1, RIGHT)):
            shift = side * (L + apart)
            panel.plot(x + shift, exact.stress(x, TIMES[k]), color="#22262b", lw=1, label=None if side else "exact")
            for N, colour in zip(sorted(runs)[-2:], ("#d9772b", "#2f6db3"), strict=True):
                X, *_, stress = runs[N][side]
                panel.plot(X + side * (apart - 1 / N), stress[k], lw=1.1, color=colour, label=None if side else f"{N} particles")
        panel.axvspan(L, L + apart, color="#e9ebee", lw=0)
        panel.annotate(f"t = {TIMES[k] / TRIP:.1f} bar lengths / C", (0.02, 0.97), xycoords="axes fraction", va="top", color="#6b7280")
        panel.set(ylim=(-0.55, 1.75), ylabel="stress [Pa]" if k % 2 == 0 else "", xlabel="x [m]" if k > 1 else "")
        panel.set_xticks([0, 0.25, 0.5, L + apart, 0.75 + apart, 1 + apart], ["0", "0.25", "", "0.5", "0.75", "1"])
    figure.axes[1].legend(loc="upper right", fontsize=8)
    plotting.save(figure, path)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "bars_apart")
