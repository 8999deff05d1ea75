"""Coulomb friction between bodies that have a velocity field each."""

import mpmkit as mpm
from mpmkit.math import sqrt


@mpm.kernel
def coulomb_impulse(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    """p = -m (u_n - gap/dt)+ n - min(friction |p_n|, m |u_t|) u_t / |u_t|, u = v_a - v_b, m = m_a m_b / (m_a + m_b)."""
    reduced = m_a * m_b / (m_a + m_b)
    ux = v_a[0] - v_b[0]
    uy = v_a[1] - v_b[1]
    uz = v_a[2] - v_b[2]
    u_n = ux * normal[0] + uy * normal[1] + uz * normal[2]
    # an open gap may close in this step, but no more than that
    closing = u_n - max(gap, 0.0 * gap) / dt
    if closing <= 0.0:
        return (0.0 * u_n, 0.0 * u_n, 0.0 * u_n)
    press = reduced * closing
    tx = ux - u_n * normal[0]
    ty = uy - u_n * normal[1]
    tz = uz - u_n * normal[2]
    slip = sqrt(tx * tx + ty * ty + tz * tz)
    rub = 0.0 * slip
    if slip > 0.0:
        rub = min(friction * press, reduced * slip) / slip
    return (-press * normal[0] - rub * tx, -press * normal[1] - rub * ty, -press * normal[2] - rub * tz)


@mpm.define
class FrictionalContact(mpm.ContactAlgorithm):
    """Contact with Coulomb friction at nodes shared by bodies with a velocity field each.

    The impulse acts only if the bodies approach each other by more than their gap would allow in the step, so that
    contact does not begin a cell too early and a slow rebound does not stick; a tangential impulse of at most
    friction times the normal one opposes sliding. Momentum is conserved exactly. The normal is that of one of the two
    surfaces, or their mean, along which the bodies are farthest apart, and the gap is measured between the particles'
    faces along it: good to a fraction of a cell on curved bodies; where two corners meet, contact may begin up to half a
    cell early.
    """

    references = (
        "Bardenhagen, Brackbill and Sulsky (2000), doi:10.1016/S0045-7825(99)00338-2",
        "Bardenhagen, Guilkey, Roessig, Brackbill, Witzel and Foster (2001), CMES 2(4), 509-522",
        "Nairn (2013), Modeling imperfect interfaces in the material point method using multimaterial methods, CMES 92(3), 271-299",
    )
    friction: float = mpm.parameter("coefficient of Coulomb friction", ge=0.0, default=0.0, example=0.3)
    impulse = coulomb_impulse
