"""The scene of impact_study.toml: two equal bars meet and part."""

import mpmkit as mpm
from mpmkit.contacts import FrictionalContact
from mpmkit.exact import BarImpact, PlasticBarImpact
from mpmkit.integrators import MUSL
from mpmkit.materials import LinearElastic, VonMises

L, E, RHO, GAP = 0.5, 1e4, 1.0, 0.05
BARS = {  # speed of each bar, yield stress, tangent modulus
    "elastic": (1.0, None, None),
    "elastic at a tenth of the speed": (0.1, None, None),
    "hardening": (1.0, 40.0, E / 4),
    "perfectly plastic": (1.0, 40.0, 0.0),
}
COARSEST = 20  # cells along a bar


def solution(bars):
    """Exact impact of these bars; its attribute "restitution" is the relative speed after over before."""
    V0, Y, Et = BARS[bars]
    return BarImpact(V0=V0, L=L, gap=GAP, E=E, rho=RHO) if Y is None else PlasticBarImpact(V0=V0, L=L, E=E, rho=RHO, Y=Y, Et=Et)


def scene(N, bars, contact, shape):
    """N cells along each bar, a particle in each; until the bars ought to be two cells of the coarsest grid apart."""
    V0, Y, Et = BARS[bars]
    h, exact = L / N, solution(bars)
    touching = exact.duration if Y is None else exact.separation_time
    until = GAP / (2 * V0) + touching + 2 * (L / COARSEST) / (2 * V0 * exact.restitution)
    elastic = {"E": E, "nu": 0.0, "rho": RHO}
    material = LinearElastic(**elastic) if Y is None else VonMises(**elastic, yield_stress=Y, tangent_modulus=Et, strain="small")
    around = 4 * L / COARSEST
    grid = mpm.Grid(-around, 2 * L + GAP + around, h, lateral="stress")
    sim = mpm.Simulation(grid, shape=shape, integrator=MUSL(cfl=0.4), until=until)
    sim += mpm.Body(mpm.Box(0.0, L), material, v=+V0, particles_per_cell=1, name="left")
    sim += mpm.Body(mpm.Box(L + GAP, 2 * L + GAP), material, v=-V0, particles_per_cell=1, name="right")
    if contact == "contact":
        sim += FrictionalContact()
    return sim
