"""A thick-walled cylinder under internal pressure: the stresses are Lame's, and Hill's once half the wall is plastic.

The same wall, 20 cells thick, is computed as a slice of rings (axisymmetric), as a quarter of its cross-section in plane
strain, and with a perfectly plastic material under a pressure that makes it yield up to the middle of the wall. Damping brings all
of them to rest. The pressure acts at the inner surface itself: TwoPointTraction on the flat face of the slice, and on the curved
face of the quarter InnerPressure, a boundary layer of twenty lines that is defined here. The particles of the quarter lie in rings, so
that this face is not a staircase. Stresses are means over the particles in a ring as wide as a cell.

Runs in half a minute (quick: the quarter with ten cells). Writes docs/images/thick_cylinder.png when started as a script.
"""

import numpy as np
import plotting

import mpmkit as mpm
from mpmkit.boundaries import Symmetry, TwoPointTraction
from mpmkit.effects import Damping
from mpmkit.exact import PlasticCylinder, ThickCylinder
from mpmkit.integrators import APIC, MUSL
from mpmkit.interfaces.boundary import Selection
from mpmkit.materials import LinearElastic, VonMises
from mpmkit.shapes import QuadraticBSpline

A, B, E, NU, P, Y, PLASTIC_TO = 1.0, 2.0, 1000.0, 0.3, 1.0, 1.0, 1.5
LAME = ThickCylinder(a=A, b=B, pressure=P, E=E, nu=NU)
HIGH = PlasticCylinder(a=A, b=B, pressure=0.0, Y=Y, E=E).pressure_at(PLASTIC_TO)
HILL = PlasticCylinder(a=A, b=B, pressure=HIGH, Y=Y, E=E)
CELLS, SIDE = 20, 3  # cells in the wall, particles along the edge of a cell
EXACT = {
    "u(a), axisymmetric": LAME.displacement(A),
    "u(a), quarter": LAME.displacement(A),
    "u(a), plastic": HILL.displacement(A),
    "plastic up to": PLASTIC_TO,
}


@mpm.kernel
def push(pressure, area, normal, F, arm0):
    """Force against the normal, at the material point x_p + F arm0 of the surface."""
    force = (-pressure * area * normal[0], -pressure * area * normal[1], 0.0 * area)
    return force, (F[0] * arm0[0] + F[1] * arm0[1], F[3] * arm0[0] + F[4] * arm0[1], 0.0 * area)


@mpm.define
class InnerPressure(mpm.BoundaryLayer):
    """Pressure on the round inside of a ring whose centre is the origin, of a body whose innermost particles lie on one circle."""

    body: str = mpm.parameter("name of the loaded body", example="wall")
    pressure: float = mpm.parameter("pressure", unit="Pa", example=1.0)
    radius: float = mpm.parameter("inner radius of the ring", unit="m", gt=0.0, example=1.0)
    load = push

    def select(self, points, grid):
        r = np.hypot(*points.x.T)
        inner = np.flatnonzero(r < r.min() * (1 + 1e-9))
        outward = np.zeros((inner.size, 3))
        outward[:, :2] = -points.x[inner] / r[inner, None]  # out of the body, to the axis
        depth = r[inner] - self.radius
        area = points.V0[inner] / (2 * depth) * self.radius / r[inner]  # a particle reaches as far inwards as outwards
        return Selection(inner.astype(np.int64), area, outward, outward * depth[:, None])


def slice_of_rings(material, pressure, damping):
    """Axisymmetric: a slice between two planes of symmetry."""
    h = (B - A) / CELLS
    sim = mpm.Simulation(mpm.Grid((A - 4 * h, 0.0), (B + 4 * h, 2 * h), h, "axisymmetric"), QuadraticBSpline(), MUSL(APIC()))
    sim += mpm.Body(mpm.Box((A, 0.0), (B, 2 * h)), material, name="wall", particles_per_cell=SIDE**2)
    sim += Symmetry(("ymin", "ymax")), Damping(damping), TwoPointTraction(body="wall", traction=pressure, face="xmin")
    return sim


def quarter(cells):
    """Plane strain: a quarter of the cross-section, filled with rings of particles."""
    h = (B - A) / cells
    width, places, volumes = h / SIDE, [], []
    for r in A + width * (np.arange(SIDE * cells) + 0.5):
        count = round(0.5 * np.pi * r / width)
        angle = 0.5 * np.pi * (np.arange(count) + 0.5) / count
        places.append(r * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        volumes.append(np.full(count, 0.5 * np.pi * r * width / count))
    sim = mpm.Simulation(mpm.Grid((0.0, 0.0), (B + 4 * h, B + 4 * h), h), QuadraticBSpline(), MUSL(APIC()))
    sim += mpm.Body.from_arrays(np.concatenate(places), np.concatenate(volumes), LinearElastic(E=E, nu=NU, rho=1.0), name="wall")
    sim += Symmetry(("xmin", "ymin")), Damping(40.0), InnerPressure(body="wall", pressure=P, radius=A)
    return sim


def at_rest(sim, until, cells=CELLS):
    """Run until all is at rest; means over rings of a cell's width: radius, displacement, radial, hoop and axial stress, and extras."""
    X = sim.particles("wall")["x"]
    sim.run(until=until, quiet=True)
    now, radial = sim.particles("wall"), np.zeros_like(X)
    flat = sim.grid.space == "plane strain"
    r = np.hypot(*X.T) if flat else X[:, 0]
    radial[:] = X / r[:, None] if flat else (1.0, 0.0)
    (ex, ey), (xx, yy, zz, xy, _, _) = radial.T, now["stress"].T
    along = xx * ex**2 + yy * ey**2 + 2 * xy * ex * ey
    hoop, axial = (xx + yy - along, zz) if flat else (zz, yy)
    values = {"r": r, "u": ((now["x"] - X) * radial).sum(axis=1), "radial": along, "hoop": hoop, "axial": axial}
    ring = np.floor((r - A) / (B - A) * cells).astype(int)
    means = {name: np.bincount(ring, value) / np.bincount(ring) for name, value in values.items()}
    history = sim.history
    means |= {"x": now["x"], "hoop of particles": hoop, "inner": inner_displacement(r, values["u"])}
    means["moving"] = history["kinetic"][-1] / history["stored"][-1]
    return means | ({"yielded": r[now["eps_p"] > 0].max()} if "eps_p" in now else {})


def inner_displacement(r, u):
    """Displacement of the inner surface, on the straight line through the two innermost rings of particles."""
    first = r < r.min() * (1 + 1e-9)
    second = ~first & (r < r[~first].min() * (1 + 1e-9))
    slope = (u[second].mean() - u[first].mean()) / (r[second].mean() - r[first].mean())
    return u[first].mean() - slope * (r[first].mean() - A)


def growing(t):
    """Pressure on the plastic wall: grows for two seconds, then stays."""
    return (HIGH * min(0.5 * t, 1.0), 0.0)


def main(quick=False, picture=None):
    elastic = LinearElastic(E=E, nu=NU, rho=1.0)
    nearly_incompressible = VonMises(E=E, nu=0.495, rho=1.0, yield_stress=Y, strain="small")  # Hill's solution has nu = 1/2
    cells = 10 if quick else CELLS
    runs = {
        "axisymmetric": at_rest(slice_of_rings(elastic, (P, 0.0), 40.0), 0.6),
        "quarter": at_rest(quarter(cells), 0.6, cells),
        "plastic": at_rest(slice_of_rings(nearly_incompressible, growing, 40.0), 3.0),
    }
    numbers = {}
    for name, run in runs.items():
        exact = HILL if name == "plastic" else LAME
        axial = exact.stress_z(run["r"]) if name == "plastic" else exact.stress_z
        numbers[f"u(a), {name}"] = run["inner"]
        numbers[f"error of the radial stress, {name}"] = np.abs(run["radial"] - exact.stress_r(run["r"])).max() / exact.pressure
        numbers[f"error of the hoop stress, {name}"] = np.abs(run["hoop"] - exact.stress_theta(run["r"])).max() / exact.pressure
        numbers[f"error of the axial stress, {name}"] = np.abs(run["axial"] - axial).max() / exact.pressure
        numbers[f"kinetic over stored energy, {name}"] = run["moving"]
    numbers["plastic up to"] = runs["plastic"]["yielded"]
    if picture:
        draw(runs, picture)
    return numbers


def check(n):
    for name in ("axisymmetric", "quarter", "plastic"):
        assert abs(n[f"u(a), {name}"] / EXACT[f"u(a), {name}"] - 1) < 0.02
        for stress in ("radial", "hoop", "axial"):
            assert n[f"error of the {stress} stress, {name}"] < 0.05
        assert n[f"kinetic over stored energy, {name}"] < 1e-6
    assert abs(n["plastic up to"] - PLASTIC_TO) < (B - A) / CELLS


def draw(runs, path):
    """The quarter with its hoop stress, and the stresses across the wall beside the exact ones: elastic and plastic."""
    figure = plotting.figure(9.2, 3.6)
    left, middle, right = figure.subplots(1, 3, width_ratios=(1.1, 1, 1))
    x, hoop = runs["quarter"]["x"], runs["quarter"]["hoop of particles"]
    dots = left.scatter(*x.T, c=hoop, s=2.5, lw=0, cmap="viridis", vmin=0.6, vmax=1.7)
    left.set(xlim=(0, 2.1), ylim=(0, 2.1), aspect="equal", xlabel="x [m]", ylabel="y [m]", title="hoop stress [Pa], elastic")
    figure.colorbar(dots, ax=left, shrink=0.8)

    r = np.linspace(A, B, 401)
    marks = {"axisymmetric": ("o", "#2f6db3"), "quarter": ("x", "#d9772b"), "plastic": ("o", "#2f6db3")}
    for panel, names, exact, title in (
        (middle, ("axisymmetric", "quarter"), LAME, f"elastic, p = {P:g} Pa"),
        (right, ("plastic",), HILL, f"plastic up to c, p = {HILL.pressure:.3f} Pa"),
    ):
        for stress in (exact.stress_theta(r), exact.stress_r(r)):
            panel.plot(r, stress, color="#22262b", lw=1, label=None if panel.get_legend_handles_labels()[1] else "exact")
        for name in names:
            mark, color = marks[name]
            for stress, label in (("hoop", name), ("radial", None)):
                panel.plot(runs[name]["r"], runs[name][stress], mark, color=color, mfc="none", ms=4, label=label)
        panel.set(xlabel="r [m]", title=title, xlim=(A, B + 0.02), xticks=(1, 1.5, 2), ylim=(None, 1.25 * exact.stress_theta(r).max()))
        panel.text(1.5, (1.25 if exact is LAME else 1.1) * exact.stress_theta(1.5), "hoop", ha="center")
        panel.text(1.55, exact.stress_r(1.55) - 0.07 * exact.pressure, "radial", va="top")
        panel.legend(loc="center", bbox_to_anchor=(0.5, 0.52))
    middle.set_ylabel("stress [Pa]")
    right.axvline(PLASTIC_TO, color="#9aa1a9", lw=0.8, ls=":")
    right.text(PLASTIC_TO + 0.02, -0.75, "c")
    plotting.save(figure, path)


if __name__ == "__main__":
    plotting.start(main, check, EXACT, "thick_cylinder")
