"""A block on an incline obeys Coulomb's law: it slides with g (sin theta - mu cos theta), or stays if tan theta <= mu.

The plane is the lower face of the domain, a wall with friction 0.3, and gravity is tilted: by 30 degrees the block slides; by 10, 15 and 16
degrees it stays (the limit is 16.7). A rigid block either slides or stays at once. An elastic one does so if it is laid down gently:
it first settles under damping, with as much force along the plane as friction can bear, and is let go then. Under gravity that is
switched on all at once it rings, with nothing to damp it, and the picture shows that it then creeps down at 15 degrees: at each rebound
its foot rises a little, and a wall stops what moves towards it anywhere within the first cell, so that the block is soon some
millimetres above the plane.

Runs in a few seconds. Writes docs/images/incline.png when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.boundaries import Wall
from mpmkit.effects import Damping, Gravity
from mpmkit.exact import BlockOnIncline
from mpmkit.integrators import APIC, MUSL
from mpmkit.materials import NeoHookean
from mpmkit.shapes import GIMP

G, MU, WIDTH, HEIGHT, H, START = 9.81, 0.3, 0.4, 0.2, 0.05, 0.2  # H: edge of a cell; START: where the block lies on the plane [m]
BLOCK = NeoHookean(E=1e6, nu=0.3, rho=1000.0)
RINGING = 0.5 * np.pi / HEIGHT * np.sqrt(BLOCK.E / BLOCK.rho)  # slowest vibration of the block [rad/s]
SLIDES, STAYS = 30, (10, 15, 16)  # degrees
EXACT = {"acceleration": BlockOnIncline(theta=np.radians(SLIDES), mu=MU, g=G).acceleration, "friction over normal force": MU}


def scene(body, along, degrees, *effects):
    """A body on the plane, with its weight across the plane, and some acceleration along it."""
    sim = mpm.Simulation(mpm.Grid((0.0, 0.0), (2.0, 0.3), H), GIMP(), MUSL(APIC()))
    sim += body, Wall("ymin", friction=MU), Gravity((along, -G * np.cos(np.radians(degrees)))), *effects
    return sim


def block(degrees, settled=True):
    """A block at rest: undeformed, or in equilibrium with its weight and as much of the slope as friction bears."""
    fresh = mpm.Body(mpm.Box((START, 0.0), (START + WIDTH, HEIGHT)), BLOCK, name="block")
    if not settled:
        return fresh
    angle = np.radians(degrees)
    sim = scene(fresh, G * min(np.sin(angle), MU * np.cos(angle)), degrees, Damping(0.8 * RINGING))
    sim.run(until=0.1, quiet=True)
    now = sim.particles("block")
    return mpm.Body.from_arrays(now["x"], now["V0"], BLOCK, name="block", F=now["F"].reshape(-1, 3, 3))


def slide(degrees, settled=True, until=1.0):
    """Let a block go: times, how far its centre has gone, its particles at the times of the picture, and its history."""
    sim = scene(block(degrees, settled), G * np.sin(np.radians(degrees)), degrees)
    times, places, frames = np.linspace(0.0, until, 41), [], {}
    for t in times:
        if t > 0.0:
            sim.run(until=t, quiet=True)
        now = sim.particles("block")
        places.append(now["x"][:, 0].mean())
        if np.isclose(2 * t, round(2 * t)):
            frames[round(t, 1)] = now["x"], -now["stress"][:, 1]
    return times, np.array(places) - places[0], frames, sim.history


def main(quick=False, picture=None):
    t, s, frames, history = slide(SLIDES)
    exact = BlockOnIncline(theta=np.radians(SLIDES), mu=MU, g=G)
    late = t >= 0.3  # before, the way is short and its relative error says little
    numbers = {
        "acceleration": 2 * s[-1] / t[-1] ** 2,
        "largest error of the way": np.abs(s[late] / exact.distance(t[late]) - 1).max(),
        "friction over normal force": -history["impulse_x"][-1] / history["impulse_y"][-1],
        "normal force over weight": history["impulse_y"][-1] / (history["mass"][0] * G * np.cos(np.radians(SLIDES)) * t[-1]),
    }
    stays = {degrees: slide(degrees) for degrees in (STAYS[1:] if quick else STAYS)}
    for degrees, (times, way, _, _) in stays.items():
        numbers[f"drift at {degrees} degrees, cells per second"] = np.abs(way).max() / H / times[-1]
    if picture:
        draw((t, s, frames), stays[15], {degrees: slide(degrees, settled=False)[:2] for degrees in (SLIDES, 15)}, picture)
    return numbers


def check(n):
    assert abs(n["acceleration"] / EXACT["acceleration"] - 1) < 0.01 and n["largest error of the way"] < 0.01
    assert abs(n["friction over normal force"] / MU - 1) < 0.01 and abs(n["normal force over weight"] - 1) < 0.01
    drifts = [value for name, value in n.items() if name.startswith("drift")]
    assert len(drifts) >= 2 and max(drifts) < 1e-3


def draw(sliding, staying, sudden, path):
    """The block on its way down, its way over time, and that of a block which stays; dashed: gravity switched on at once."""
    t, s, frames = sliding
    figure = plotting.figure(9.2, 3.4)
    left, middle, right = figure.subplots(1, 3, width_ratios=(1.35, 1, 1))
    angle = np.radians(SLIDES)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])  # plane to level: (x, y) @ turn
    left.fill_between(*(np.array([[0.0, 0.0], [2.0, 0.0]]) @ turn).T, -1.05, color="#e4e6e9", lw=0)
    for time, (x, pressure) in frames.items():
        dots = left.scatter(*(x @ turn).T, c=pressure / 1000, s=9, lw=0, cmap="viridis", vmin=0, vmax=3)
        left.annotate(f"{time:.1f} s", (x.mean(axis=0) + np.array([0.0, 0.16])) @ turn, ha="left", va="bottom")
    left.set(xlim=(0, 1.75), ylim=(-1.05, 0.35), aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"friction {MU}: it slides")
    figure.colorbar(dots, ax=left, shrink=0.7, label="normal stress on the plane [kPa]")

    exact = BlockOnIncline(theta=angle, mu=MU, g=G)
    middle.plot(t, exact.distance(t), color="#22262b", lw=1, label="exact")
    middle.plot(t[::4], s[::4], "o", mfc="none", label="settled")
    middle.plot(*sudden[SLIDES], "--", lw=1.2, label="sudden gravity")
    middle.set(xlabel="t [s]", ylabel="way down the plane [m]", title=f"{SLIDES} degrees")
    middle.legend(loc="upper left")
    right.plot(t, 0 * t, color="#22262b", lw=1, label="exact")
    right.plot(staying[0][::4], staying[1][::4] * 1000, "o", mfc="none", label="settled")
    right.plot(sudden[15][0], sudden[15][1] * 1000, "--", lw=1.2, label="sudden gravity")
    right.set(xlabel="t [s]", ylabel="way down the plane [mm]", ylim=(-5, 115), title="it stays: 15 degrees")
    right.legend(loc="upper left")
    plotting.save(figure, path)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "incline")
