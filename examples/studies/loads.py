"""The scene of loads_study.toml: a bar whose end is pulled by a smooth pulse, in four ways."""

import mpmkit as mpm
from mpmkit.boundaries import TractionLayer, TwoPointTraction, Wall
from mpmkit.exact import ForcedBar, SmoothPulse
from mpmkit.integrators import MUSL
from mpmkit.materials import LinearElastic

L, E, RHO, LOAD, LASTS, PER_CELL = 1.0, 1e4, 1.0, 1.0, 0.01, 4
PULL = f"{LOAD}*sin(pi*t/{LASTS})**2"
LAYERS = {"a cell": 1.0, "half a cell": 0.5, "a quarter": 0.25}


def solution():
    """The pulse runs into the bar; until it reaches the other end at 0.01 s."""
    return ForcedBar(L=L, E=E, rho=RHO, right=SmoothPulse(magnitude=LOAD, duration=LASTS))


def scene(N, load, shape):
    """N cells along the bar, four particles in each; the load is "two points" or the thickness of a layer, a key of LAYERS."""
    h = L / N
    sim = mpm.Simulation(mpm.Grid(0.0, L + 3 * h, h, lateral="stress"), shape=shape, integrator=MUSL(cfl=0.2), until=LASTS)
    sim += mpm.Body(mpm.Box(0.0, L), LinearElastic(E=E, nu=0.0, rho=RHO), particles_per_cell=PER_CELL, name="bar")
    sim += Wall("xmin", "no slip")
    if load == "two points":
        sim += TwoPointTraction(body="bar", traction=(PULL,), face="xmax")
    else:
        sim += TractionLayer(body="bar", traction=(PULL,), face="xmax", thickness=LAYERS[load] * h)
    return sim


def share_in_the_last_cell(facts):
    """Mean stress of the last cell over the exact one, when the load is largest."""
    sample = min(facts.samples, key=lambda s: abs(s.t - LASTS / 2))
    X, stress = facts.samples[0].bodies["bar"]["x"][:, 0], sample.bodies["bar"]["stress"][:, 0]
    last = X.argsort()[-PER_CELL:]
    return stress[last].mean() / solution().stress(X[last], sample.t).mean()
