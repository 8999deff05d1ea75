"""Modified update stress last, the scheme of SAND2002-0482 section 3."""

import mpmkit as mpm
from mpmkit_integrators.flip import FLIP


@mpm.define
class MUSL(mpm.ExplicitIntegrator):
    """Modified update stress last: strains come from a second mapping of the updated particle momenta.

    The second mapping, (mv)_i = sum_p m_p v_p N_i (eq 3-11), keeps the velocity gradient bounded where the nodal mass
    is small; without it (USL) a body blows up already in free flight. Energy is well kept, momentum to rounding.
    """

    references = (
        "Sulsky, Zhou and Schreyer (1995), Application of a particle-in-cell method to solid mechanics, doi:10.1016/0010-4655(94)00170-7",
        "Chen and Brannon (2002), SAND2002-0482, section 3",
    )
    transfer: mpm.Transfer = mpm.parameter("how particle velocities follow from the grid", default=FLIP())

    def step(self, s):
        s.p2g()  # step 1: mass (3-1) and momentum (3-2) to the nodes
        s.forces()  # internal (3-3) and external forces, (3-4)
        s.momentum()  # step 3: (3-5)
        s.contact()
        s.boundary()  # step 2: essential conditions
        s.g2p()  # step 4: particle velocities (3-6), (3-8)
        s.remap()  # steps 5, 6: updated momenta back to the nodes (3-11), (3-12)
        s.contact()
        s.boundary()  # step 7: essential conditions again
        s.advect()  # positions with the grid velocity of (3-7): (3-9)
        s.strain()  # step 8: (3-13)
        s.stress()  # step 9: (3-14)
