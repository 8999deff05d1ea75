"""A rubber ball is thrown onto a rough floor, flattens, and bounces off with spin.

The ball falls under gravity while it flies forward, without spin. In the impact its underside slides, so Coulomb's law ties the
two impulses together, whatever the ball is made of: it loses friction times as much forward momentum as the floor gives it
upward (hardly less: in places the vibrating underside sticks for a moment), and this impulse at the distance R makes it spin.
Duration and peak of the contact force follow Hertz's theory of a sphere on a rigid plane within a few percent at eight cells
per radius,

    d = (15 m v^2 / (16 sqrt(R) E*))^(2/5),  peak = 5/4 m v^2 / d,  duration = 2.94 d / v,  E* = E / (1 - nu^2)

(Johnson, Contact Mechanics, 1985, section 11.4). The ball does not rise as high as it was dropped from: some of its energy is
left in vibration.

Runs in half a minute (quick: five cells per radius, a few seconds). Writes sphere.vtkhdf, and docs/images/sphere_drop.png
when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.boundaries import Wall
from mpmkit.effects import Gravity
from mpmkit.integrators import MUSL
from mpmkit.materials import NeoHookean
from mpmkit.shapes import GIMP

R, DROP, FORWARD, FRICTION, G = 0.1, 0.1, 3.0, 0.2, 9.81
RUBBER = NeoHookean(E=1e6, nu=0.3, rho=1000.0)
SPEED = np.sqrt(2 * G * DROP)  # of the fall at the floor
DEPTH = (15 * (4 / 3 * np.pi * R**3 * RUBBER.rho) * SPEED**2 * (1 - RUBBER.nu**2) / (16 * np.sqrt(R) * RUBBER.E)) ** 0.4
DURATION, PEAK = 2.94 * DEPTH / SPEED, 1.25 * SPEED**2 / DEPTH  # Hertz: contact time [s], largest force per mass [m/s^2]
ABOVE_TENTH = 0.854  # share of its duration that Hertz's pulse is above a tenth of its peak
EXACT = {"duration": 1.0, "peak force": 1.0, "impulse along / up": FRICTION, "spin": 1.0}


def scene(cells):
    """A ball with so many cells along its radius."""
    grid = mpm.Grid(lower=(0.0, 0.0, 0.0), upper=(1.2, 0.3, 0.4), spacing=R / cells)
    sim = mpm.Simulation(grid, shape=GIMP(), integrator=MUSL(), until=0.3)
    sim += mpm.Body(mpm.Sphere(center=(0.15, 0.15, R + DROP), radius=R), RUBBER, v=(FORWARD, 0.0, 0.0), name="ball", conserve="volume")
    sim += Wall("zmin", friction=FRICTION), Gravity((0.0, 0.0, -G))
    sim += mpm.Record("sphere.vtkhdf", every=0.01, fields=("x", "v", "stress", "V0"), history=2, overwrite=True)
    return sim


def main(quick=False, picture=None):
    cells = 5 if quick else 8
    results = scene(cells).run(quiet=quick)
    history = results.history
    t, force = floor_force(history)
    (start, end), before, after = t[force > 0.1 * force.max()][[0, -1]], results.at(0.1), results.at(0.21)
    impulse = [np.interp((0.1, 0.21), history["t"], history[f"impulse_{a}"]) @ (-1, 1) / history["mass"][0] for a in "xz"]
    height = [frame["x"][:, 2].mean() - R for frame in results.frames if frame.time > end]
    if picture:
        draw(results, picture)
    return {
        "cells along the radius": cells,
        "duration": (end - start) / (ABOVE_TENTH * DURATION),
        "peak force": force.max() / PEAK,
        "rise": max(height) / DROP,
        "impulse along / up": -impulse[0] / impulse[1],
        "spin": (spin(after) - spin(before)) * 0.4 * R / -impulse[0],
        "lowest particle": min(frame["x"][:, 2].min() for frame in results.frames) / R,
        "energy balance": np.abs(history["balance"]).max(),
    }


def floor_force(history, rows=5):
    """Times, and the floor's vertical force per mass, a mean over a few rows of the history."""
    t, impulse = history["t"], history["impulse_z"] / history["mass"][0]
    return 0.5 * (t[rows:] + t[:-rows]), (impulse[rows:] - impulse[:-rows]) / (t[rows:] - t[:-rows])


def spin(frame):
    """Mean rate of turning in the direction of rolling [rad/s]."""
    x, v = frame["x"] - frame["x"].mean(axis=0), frame["v"] - frame["v"].mean(axis=0)
    return (x[:, 2] * v[:, 0] - x[:, 0] * v[:, 2]).sum() / (x[:, 2] ** 2 + x[:, 0] ** 2).sum()


def check(n):
    cell = 1 / n["cells along the radius"]  # the grid feels the floor about a cell too early
    assert abs(n["duration"] - 1) < 0.8 * cell and abs(n["peak force"] - 1) < 0.8 * cell
    assert 0.98 * FRICTION < n["impulse along / up"] < 1.001 * FRICTION  # Coulomb
    assert 0.9 < n["spin"] < 1.02  # of a rigid ball; this one is flattened, so the arm is shorter
    assert 0.8 < n["rise"] < 1.0
    assert n["lowest particle"] > 0.0 and n["energy balance"] < 0.005


def draw(results, path):
    """The ball cut open at three instants in one picture, and the force of the floor beside Hertz's."""
    import matplotlib.pyplot as plt
    from scipy.integrate import solve_ivp

    plt.style.use(plotting.HERE / "look.mplstyle")
    frames = [results.at(t) for t in (0.0, 0.15, 0.28)]
    behind = [frame["x"][:, 1] > 0.15 for frame in frames]
    fields = ("x", "stress", "body", "V0")
    together = {name: np.concatenate([f[name][far] for f, far in zip(frames, behind, strict=True)]) for name in fields}
    strobe = mpm.Results.in_memory([(0.0, 0, together)], {}, results.bodies, meta=results.meta)
    figure = strobe.plot("stress", window=((0, 1.2), (0, 0.3), (0, 0.35)), azimuth=-66, elevation=16)
    figure.axes[0].set_title("the ball, cut open, at " + ", ".join(f"{frame.time:.2f}" for frame in frames) + " s")

    figure.set_size_inches(9.2, 6.4)
    figure.get_layout_engine().set(rect=(0, 0.3, 1, 0.7))  # room below for the force
    panel = figure.add_axes((0.12, 0.08, 0.72, 0.2))
    t, force = floor_force(results.history)
    start = t[force > 0.1 * force.max()][0] - 0.5 * (1 - ABOVE_TENTH) * DURATION
    # Hertz: depth'' = -k depth^(3/2), which begins with the speed of the fall
    hertz = solve_ivp(lambda _, y: (y[1], -PEAK * max(y[0] / DEPTH, 0.0) ** 1.5), (0, DURATION), (0.0, SPEED), max_step=DURATION / 100)
    panel.plot(1e3 * (t - start), force / PEAK, label="of the floor on the ball")
    panel.plot(1e3 * hertz.t, (np.maximum(hertz.y[0], 0) / DEPTH) ** 1.5, "--", color="#22262b", lw=1.2, label="Hertz (1882)")
    panel.set(xlim=(-10, 40), xlabel="time since contact [ms]", ylabel="force / Hertz's peak")
    panel.legend(loc="upper right")
    figure.savefig(path, dpi=110, bbox_inches="tight", pad_inches=0.1)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "sphere_drop")
