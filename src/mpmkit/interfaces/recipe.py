"""The verbs of one step: what an integrator's or a discretization's recipe is written in."""

from __future__ import annotations


class Recipe:
    """Records the order of one step. Each verb is one line of the recipe; the scheduler turns it into loops.

    Neighbouring verbs over particles are fused into one loop where no node value has to be complete in between, and a
    verb to which no component contributes (``contact`` without contact, ``boundary`` without boundary layers)
    disappears.
    """

    def __init__(self) -> None:
        self.verbs: list[str] = []
        self.fraction = 0.0

    def p2g(self) -> None:
        """Particles to grid: m_i = sum_p m_p N_i(x_p) and (mv)_i = sum_p m_p v_p N_i(x_p) (with C (x_i - x_p) if affine)."""
        self.verbs.append("p2g")

    def forces(self) -> None:
        """f_i = -sum_p V_p sigma_p grad N_i(x_p), plus body forces and the loads of boundary layers."""
        self.verbs.append("forces")

    def velocity(self) -> None:
        """v_i = (mv)_i / m_i, before the momentum update (for an integrator that strains first)."""
        self.verbs.append("velocity")

    def momentum(self) -> None:
        """v_i <- v_i + dt (f_i / m_i + accelerations of effects)."""
        self.verbs.append("momentum")

    def contact(self) -> None:
        """Contact impulses on the nodal velocities at nodes that bodies share."""
        self.verbs.append("contact")

    def boundary(self) -> None:
        """Essential conditions on the nodal velocities."""
        self.verbs.append("boundary")

    def g2p(self) -> None:
        """Grid to particles: v_p from the updated nodal velocities, as the transfer says (and its matrix C)."""
        self.verbs.append("g2p")

    def remap(self) -> None:
        """The second mapping of MUSL: v_i = sum_p m_p v_p N_i(x_p) / m_i from the updated particle velocities."""
        self.verbs.append("remap")

    def limit(self, fraction: float) -> None:
        """Velocities for the strain, v_i = v_old + min(1, m_i / (fraction m_p)) (v - v_old): bounded where a node has little mass.

        m_p is the mean particle mass. Only L_p sees them, and the affine matrix of a transfer sees velocities limited at light nodes too:
        momenta and positions keep the full update, so momentum is conserved.
        """
        self.verbs.append("limit")
        self.fraction = fraction

    def advect(self) -> None:
        """x_p <- x_p + dt sum_i v_i N_i(x_p), with the nodal velocities of the momentum update.

        No later loop of the step may visit nodes; neighbouring verbs, as in ``advect``, ``strain``, ``stress``, are one loop and see one
        set of weights.
        """
        self.verbs.append("advect")

    def strain(self) -> None:
        """L_p = sum_i v_i grad N_i(x_p) from the latest nodal velocities, and F_p, V_p from L_p."""
        self.verbs.append("strain")

    def stress(self) -> None:
        """The constitutive models: sigma_p and state from F_p, L_p."""
        self.verbs.append("stress")

    def carry(self) -> None:
        """Nodes keep their velocity from step to step (discretizations with stored operators): v_old = v, f = 0."""
        self.verbs.append("carry")
