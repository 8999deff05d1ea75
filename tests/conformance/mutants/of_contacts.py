"""Faulty contact algorithms: variations of p = m (u_n - gap/dt)+ with a fault each."""

from mpmkit_contacts import FrictionalContact
from mpmkit_contacts.frictional import coulomb_impulse

import mpmkit as mpm
from mutants import EVERYTHING, mutant

SCENES = ("a collision conserves momentum", "bodies in another order", "the kernel sees unit normals and finite gaps")


def times(k, p):
    return (k * p[0], k * p[1], k * p[2])


def approach(v_a, v_b, normal):
    return (v_a[0] - v_b[0]) * normal[0] + (v_a[1] - v_b[1]) * normal[1] + (v_a[2] - v_b[2]) * normal[2]


@mpm.kernel
def sticky(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    u = approach(v_a, v_b, normal)
    if u < 0.0 and gap < 0.0:
        return times(-m_a * m_b / (m_a + m_b) * u, normal)
    return coulomb_impulse.function(m_a, v_a, m_b, v_b, normal, gap, dt, friction)


@mutant("no pull")
@mpm.define
class Sticky(FrictionalContact):
    """Bodies that overlap never let go, p = -m u."""

    impulse = sticky


@mpm.kernel
def hasty(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    return coulomb_impulse.function(m_a, v_a, m_b, v_b, normal, 0.0 * gap, dt, friction)


@mutant("no effect at a distance")
@mpm.define
class Hasty(FrictionalContact):
    """Does not look at the gap, p = m u."""

    impulse = hasty


@mpm.kernel
def idle(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    return times(0.0 * m_a, normal)


@mutant("acts on overlapping bodies that approach")
@mpm.define
class Idle(FrictionalContact):
    """Never acts, p = 0."""

    impulse = idle


@mpm.kernel
def biased(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    p = coulomb_impulse.function(m_a, v_a, m_b, v_b, normal, gap, dt, friction)
    return times(1.0 - 0.1 * m_a / (m_a + m_b), p)


@mutant("equal under swap", also=("bodies in another order",))
@mpm.define
class Biased(FrictionalContact):
    """Depends on which body is called a, p = (1 - m_a / 10 M) p."""

    impulse = biased


@mpm.kernel
def absolute(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    p = coulomb_impulse.function(m_a, v_a, m_b, v_b, normal, gap, dt, friction)
    return times(1.0 - 0.1 * min(1.0, v_a[0] * v_a[0] + v_b[0] * v_b[0]), p)


@mutant("seen alike by a moving observer")
@mpm.define
class Absolute(FrictionalContact):
    """Depends on the velocity over ground, p = (1 - v^2 / 10) p."""

    impulse = absolute


@mpm.kernel
def rough(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    return coulomb_impulse.function(m_a, v_a, m_b, v_b, normal, gap, dt, 1.5 * friction)


@mutant("friction is bounded")
@mpm.define
class Rough(FrictionalContact):
    """Half as much friction again as declared, p_t = 1.5 mu p_n."""

    impulse = rough


@mpm.kernel
def bouncy(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    return times(2.5, coulomb_impulse.function(m_a, v_a, m_b, v_b, normal, gap, dt, 0.0 * friction))


@mutant("no energy from friction and impact")
@mpm.define
class Bouncy(FrictionalContact):
    """Throws bodies back faster than they came, p = 2.5 m u."""

    impulse = bouncy


@mpm.kernel
def endless_in_scenes(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    p = coulomb_impulse.function(m_a, v_a, m_b, v_b, normal, gap, dt, friction)
    return times(1e300 * 1e300 if dt < 9e-4 else 1.0, p)


@mutant(SCENES[0], SCENES[2], also=SCENES)
@mpm.define
class Endless(FrictionalContact):
    """No finite impulse in short steps, p = 1 / 0."""

    impulse = endless_in_scenes


@mpm.kernel
def partial_to_the_right(m_a, v_a, m_b, v_b, normal, gap, dt, friction):
    p = coulomb_impulse.function(m_a, v_a, m_b, v_b, normal, gap, dt, friction)
    return times(0.9 if normal[0] > 0.0 and dt < 9e-4 else 1.0, p)


@mutant(SCENES[1])
@mpm.define
class Partial(FrictionalContact):
    """Weaker to the right, in short steps, p = 0.9 p."""

    impulse = partial_to_the_right


@mpm.kernel
def flat_impulse(m_a, v_a, m_b, v_b, normal):
    return (0.0 * m_a, 0.0 * m_a)


@mutant("results have the form of the hook", also=EVERYTHING)
@mpm.define
class Flat(FrictionalContact):
    """Forgets a component, p = (0, 0)."""

    impulse = flat_impulse
