"""Update stress first, the scheme of Guilkey's introduction."""

import mpmkit as mpm
from mpmkit_integrators.flip import FLIP


@mpm.define
class USF(mpm.ExplicitIntegrator):
    """Update stress first: strain and stress from the nodal velocities at the start of the step (Guilkey eqs 2-10).

    This is the algorithm of "An introduction to the material point method": velocity gradient from v_g (5), stress,
    internal force (6), momentum (7), particles (9), (10). Energy is well kept, with a slight tendency to gain.
    """

    references = (
        "Guilkey, An introduction to the material point method, eqs 2-10",
        "Bardenhagen (2002), Energy conservation error in the material point method for solid mechanics, doi:10.1006/jcph.2002.7103",
    )
    transfer: mpm.Transfer = mpm.parameter("how particle velocities follow from the grid", default=FLIP())

    def step(self, s):
        s.p2g()  # (2), (3)
        s.velocity()
        s.contact()
        s.boundary()
        s.strain()  # (5), (13), (14)
        s.stress()  # (12)
        s.forces()  # (4), (6)
        s.momentum()  # (1), (7)
        s.contact()
        s.boundary()
        s.g2p()  # (9)
        s.advect()  # (10)
