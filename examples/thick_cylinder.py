"""A thick tube under pressure inside: elastic as Lame has it, then plastic up to half its wall.

Plane strain, inner radius 1, outer radius 2, von Mises material without hardening. The pressure rises to 0.3 Y and is
held: the tube is elastic. It rises again to 0.72078 Y, where half of the wall is plastic (Hill (1950), chapter V.2; the tube
first yields at 0.433 and collapses at 0.800). The same tube is computed twice:

- as a ring section in axisymmetric coordinates, loaded at its very surface (TwoPointTraction);
- as a quarter in the plane, its particles on circles that do not follow the grid, loaded through the innermost ring of
  particles with a traction that is a function of position (TractionLayer).

Mass-proportional damping makes the motion die out, and APIC leaves no noise in the velocities at rest.

Runs in ten seconds. Writes docs/images/thick_cylinder.png when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.boundaries import Symmetry, TractionLayer, TwoPointTraction
from mpmkit.effects import Damping
from mpmkit.exact import PlasticCylinder, ThickCylinder
from mpmkit.integrators import APIC, MUSL
from mpmkit.materials import VonMises
from mpmkit.shapes import QuadraticBSpline

A, B, Y, E, NU, CELLS = 1.0, 2.0, 1.0, 1000.0, 0.3, 20
LOW, HIGH = 0.3 * Y, 0.72078 * Y
HELD, END = 0.8, 2.0  # times at which the elastic and the plastic state have come to rest
ELASTIC = ThickCylinder(a=A, b=B, pressure=LOW, E=E, nu=NU)
PLASTIC = PlasticCylinder(a=A, b=B, pressure=HIGH, Y=Y, E=E)
METAL = VonMises(E=E, nu=NU, rho=1.0, yield_stress=Y, strain="small")
EXACT = {f"plastic radius, {name}": PLASTIC.plastic_radius for name in ("ring", "quarter")}


def pressure(t):
    """Up to LOW in 0.3 s, on from 0.8 s to HIGH at 1.4 s."""
    return LOW * min(t / 0.3, 1.0) + (HIGH - LOW) * min(max(t - 0.8, 0.0) / 0.6, 1.0)


def outward(X, t):
    """In the ring section the direction outward is x."""
    return (pressure(t), 0.0)


def radial(X, t):
    """In the quarter it turns with the position."""
    R = (X[0] * X[0] + X[1] * X[1]) ** 0.5
    return (pressure(t) * X[0] / R, pressure(t) * X[1] / R)


def ring():
    """The section of a ring, four cells high."""
    h = (B - A) / CELLS
    sim = mpm.Simulation(mpm.Grid((0.5, 0.0), (2.5, 4 * h), h, coordinates="axisymmetric"), shape=QuadraticBSpline(), integrator=MUSL(APIC()))
    sim += mpm.Body(mpm.Box((A, 0.0), (B, 4 * h)), METAL, name="tube"), Symmetry(("ymin", "ymax"))
    sim += TwoPointTraction(body="tube", traction=outward, face="xmin"), Damping(30.0)
    return sim


def quarter():
    """A quarter of the cross section; particles on circles half a cell apart."""
    h = (B - A) / CELLS
    d = h / 2
    circles = [(r, (np.arange(n) + 0.5) / n * np.pi / 2) for r in np.arange(A + d / 2, B, d) for n in [round(np.pi / 2 * r / d)]]
    x = np.concatenate([np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1) for r, angle in circles])
    V = np.concatenate([np.full(angle.size, np.pi / 2 * r * d / angle.size) for r, angle in circles])
    sim = mpm.Simulation(mpm.Grid((0.0, 0.0), (B + 2 * h, B + 2 * h), h), shape=QuadraticBSpline(), integrator=MUSL(APIC()))
    sim += mpm.Body.from_arrays(x, V, METAL, name="tube"), Symmetry(("xmin", "ymin")), Damping(30.0)
    # thickness: area of the innermost circle of particles over the length of the surface that bears the pressure
    sim += TractionLayer(body="tube", traction=radial, region=mpm.Disk((0.0, 0.0), A + d), thickness=d * (A + d / 2) / A)
    return sim


def states(sim):
    """Radius, radial displacement, radial and hoop stress, plastic strain of the particles, at HELD and at END."""
    x, found = sim.particles("tube")["x"], []
    flat = sim.grid.space == "plane strain"
    r = np.hypot(*x.T) if flat else x[:, 0]
    n = x / r[:, None] if flat else np.array([1.0, 0.0]) + 0.0 * x
    for t in (HELD, END):
        sim.run(until=t, quiet=True)
        p = sim.particles("tube")
        xx, yy, zz, xy = p["stress"][:, :4].T
        along = xx * n[:, 0] ** 2 + yy * n[:, 1] ** 2 + 2 * xy * n[:, 0] * n[:, 1]
        around = xx * n[:, 1] ** 2 + yy * n[:, 0] ** 2 - 2 * xy * n[:, 0] * n[:, 1] if flat else zz
        found.append((r, ((p["x"] - x) * n).sum(axis=1), along, around, p["eps_p"]))
    return found


def main(quick=False, picture=None):
    runs = {"ring": states(ring()), "quarter": states(quarter())}
    h, numbers = (B - A) / CELLS, {}
    for name, found in runs.items():
        inner = found[0][0] < A + h / 2
        numbers[f"displacement at a, error, {name}"] = (found[0][1] / ELASTIC.displacement(found[0][0]))[inner].mean() - 1
        for exact, (r, _, along, around, _) in zip((ELASTIC, PLASTIC), found, strict=True):
            inside = (r > A + h) & (r < B - h)
            state = "elastic" if exact is ELASTIC else "plastic"
            numbers[f"radial stress, {state}, error, {name}"] = rms((along - exact.stress_r(r))[inside]) / exact.pressure
            numbers[f"hoop stress, {state}, error, {name}"] = rms((around - exact.stress_theta(r))[inside]) / np.abs(exact.stress_theta(r)).max()
        r, plastic = found[1][0], found[1][4] > 1e-6
        numbers[f"plastic radius, {name}"] = 0.5 * (r[plastic].max() + r[~plastic].min())
    if picture:
        draw(runs, picture)
    return numbers


def rms(values):
    return np.sqrt((values**2).mean())


def check(n):
    for name in ("ring", "quarter"):
        assert abs(n[f"displacement at a, error, {name}"]) < 0.02
        for state in ("elastic", "plastic"):
            assert n[f"radial stress, {state}, error, {name}"] < 0.05 and n[f"hoop stress, {state}, error, {name}"] < 0.05
        assert abs(n[f"plastic radius, {name}"] - PLASTIC.plastic_radius) < 1.5 * (B - A) / CELLS


def draw(runs, path):
    """Where the quarter is plastic; stresses through the wall in both states."""
    figure = plotting.figure(9.4, 3.2)
    plane, *panels = figure.subplots(1, 3, gridspec_kw={"width_ratios": (1.15, 1, 1)})
    r, u, along, around, eps = runs["quarter"][1]
    x = quarter().particles("tube")["x"]
    dots = plane.scatter(*x.T, c=1e3 * eps, s=2.2, cmap="viridis", lw=0)
    bar = figure.colorbar(dots, cax=plane.inset_axes((0.88, 0.52, 0.05, 0.3)))
    bar.outline.set_visible(False)
    bar.ax.set_title("plastic\nstrain [10$^{-3}$]", fontsize=8)
    angle = np.linspace(0, np.pi / 2, 100)
    plane.plot(PLASTIC.plastic_radius * np.cos(angle), PLASTIC.plastic_radius * np.sin(angle), "--", color="#c2455a", lw=1.2)
    plane.set(aspect="equal", title="half of the wall is plastic", xlim=(0, 2.3), ylim=(0, 2.3), xlabel="x", ylabel="y")
    s = np.linspace(A, B, 300)
    for panel, k, exact, title in ((panels[0], 0, ELASTIC, f"p = {LOW:g} Y, elastic"), (panels[1], 1, PLASTIC, f"p = {HIGH:g} Y, half plastic")):
        for stress, solution, label in ((3, exact.stress_theta, "hoop"), (2, exact.stress_r, "radial")):
            panel.plot(runs["quarter"][k][0], runs["quarter"][k][stress], ".", ms=1.2, color="#b9c7d9", label="quarter" if label == "hoop" else None)
            panel.plot(runs["ring"][k][0], runs["ring"][k][stress], ".", ms=4, color="#2f6db3", label="ring" if label == "hoop" else None)
            panel.plot(s, solution(s), color="#22262b", lw=1.1, label="exact" if label == "hoop" else None)
            panel.annotate(label, (1.75, solution(1.75)), xytext=(0, 7 if label == "hoop" else -14), textcoords="offset points", ha="center")
        panel.set(title=title, xlabel="r", ylabel="stress / Y", xlim=(A, B))
    panels[1].legend(loc="center right", bbox_to_anchor=(1.0, 0.58), markerscale=2)
    plotting.save(figure, path)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "thick_cylinder")
