"""Update stress last."""

import mpmkit as mpm
from mpmkit_integrators.flip import FLIP


@mpm.define
class USL(mpm.ExplicitIntegrator):
    """Update stress last: strain and stress from the updated nodal velocities, without a second mapping.

    In its plain form a body blows up already in free flight: at a node with little mass f_i / m_i is huge, and so is
    its velocity gradient. Here the strain sees velocities whose change is reduced by m_i / (limit m_p) at nodes
    lighter than ``limit`` particle masses; momenta and positions are not touched. The cheapest order of the three,
    and dissipative. ``limit = 0`` is the plain form, for study.

    The affine matrix of APIC is formed with the limited velocities too, so that angular momentum is not conserved to rounding.
    """

    references = (
        "Bardenhagen (2002), Energy conservation error in the material point method for solid mechanics, doi:10.1006/jcph.2002.7103",
    )
    angular_momentum = False
    transfer: mpm.Transfer = mpm.parameter("how particle velocities follow from the grid", default=FLIP())

    limit: float = mpm.parameter(
        "nodal mass, in particle masses, below which the strain rate is limited", ge=0.0, le=4.0, default=0.5, kw_only=True
    )

    def step(self, s):
        s.p2g()
        s.forces()
        s.momentum()
        s.contact()
        s.boundary()
        if self.limit > 0.0:
            s.limit(self.limit)
        s.g2p()
        s.advect()
        s.strain()
        s.stress()
