"""Update stress last."""

import mpmkit as mpm
from mpmkit_integrators.flip import FLIP


@mpm.define
class USL(mpm.ExplicitIntegrator):
    """Update stress last: strain and stress from the updated nodal velocities, without a second mapping.

    The cheapest order of the three, and dissipative.
    """

    references = ("Bardenhagen (2002), Energy conservation error in the material point method for solid mechanics, doi:10.1006/jcph.2002.7103",)
    transfer: mpm.Transfer = mpm.parameter("how particle velocities follow from the grid", default=FLIP())

    def step(self, s):
        s.p2g()
        s.forces()
        s.momentum()
        s.contact()
        s.boundary()
        s.g2p()
        s.advect()
        s.strain()
        s.stress()
