"""A rubber ball is thrown onto a rough floor, flattens, and bounces off with spin.

The ball falls under gravity while it flies forward, without spin. In the impact its underside slides all the time, so Coulomb's law
ties the two impulses together, whatever the ball is made of: it loses friction times as much forward velocity as
it gains upward. The contact lasts about as long as Hertz's theory of a sphere on a rigid plane says,

    t = 2.868 (m^2 / (R E*^2 v))^(1/5),   E* = E / (1 - nu^2)   (Johnson, Contact Mechanics, 1985, eq 11.24),

and it rises less high than it was dropped from, because it leaves the floor turning and vibrating.

Runs in about a minute (quick: a few seconds). Writes sphere.vtkhdf, and docs/images/sphere_drop.png when started as a script.
"""

from pathlib import Path

import numpy as np

import mpmkit as mpm
from mpmkit.boundaries import Wall
from mpmkit.effects import Gravity
from mpmkit.integrators import MUSL
from mpmkit.materials import NeoHookean
from mpmkit.shapes import QuadraticBSpline

R, DROP, FORWARD, FRICTION, G = 0.1, 0.1, 2.5, 0.2, 9.81
RUBBER = NeoHookean(E=1e6, nu=0.3, rho=1000.0)
LANDING = np.sqrt(2 * G * DROP)  # speed of the fall at the floor
HERTZ = 2.868 * ((4 / 3 * np.pi * R**3 * RUBBER.rho) ** 2 / (R * (RUBBER.E / (1 - RUBBER.nu**2)) ** 2 * LANDING)) ** 0.2


def scene(cells):
    """A ball of so many cells along its radius."""
    grid = mpm.Grid(lower=(0.0, 0.0, 0.0), upper=(1.2, 0.3, 0.4), spacing=R / cells)
    sim = mpm.Simulation(grid, shape=QuadraticBSpline(), integrator=MUSL())
    sim += mpm.Body(mpm.Sphere(center=(0.15, 0.15, R + DROP), radius=R), RUBBER, v=(FORWARD, 0.0, 0.0), name="ball")
    sim += Wall("zmin", friction=FRICTION), Gravity((0.0, 0.0, -G))
    sim += mpm.Record("sphere.vtkhdf", every=0.01, fields=("x", "v", "stress"), overwrite=True)
    return sim


def main(quick=False, picture=None):
    sim = scene(cells=5 if quick else 8)
    results = sim.run(until=0.36, quiet=quick)
    history, mass = results.history, results.history["mass"][0]
    t, up, along = history["t"], history["momentum_z"] / mass, history["momentum_x"] / mass
    force = np.gradient(up, t) + G > 0.02 * LANDING / HERTZ  # the floor's force per mass: in contact or not
    begin, end = np.flatnonzero(force)[[0, -1]]
    after = results.at(t[end] + 0.02)
    height = np.array([frame["x"][:, 2].mean() for frame in results.frames])
    if picture:
        draw(results, picture)
    return {
        "contact begins": t[begin] / np.sqrt(2 * DROP / G),
        "contact time": (t[end] - t[begin]) / HERTZ,
        "landing speed": -up[begin] / LANDING,
        "restitution": up[end] / -up[begin],
        "lost along / gained up": (along[begin] - along[end]) / (up[end] - up[begin] + G * (t[end] - t[begin])),
        "spin": spin(after) * R / (2.5 * (along[begin] - along[end])),
        "rise": (height[results.times > t[end]].max() - R) / DROP,
        "lowest particle": min(frame["x"][:, 2].min() for frame in results.frames),
        "balance": np.abs(history["balance"]).max(),
    }


def spin(frame):
    """Mean rate of rotation about the y axis [rad/s]."""
    x, v = frame["x"] - frame["x"].mean(axis=0), frame["v"] - frame["v"].mean(axis=0)
    return (x[:, 2] * v[:, 0] - x[:, 0] * v[:, 2]).sum() / (x[:, 2] ** 2 + x[:, 0] ** 2).sum()


def check(n):
    print(n)


def draw(results, path):
    results.plot("stress", time=(0.02, 0.15, 0.165, 0.2, 0.32), path=path)


if __name__ == "__main__":
    numbers = main(picture=Path(__file__).parents[1] / "docs/images/sphere_drop.png")
    for name, value in numbers.items():
        print(f"{name:24s} {value:.4g}")
    check(numbers)
