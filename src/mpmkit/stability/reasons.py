"""What a step does to a wave, by theory: the sentences and numbers that expected outcomes share.

Take many particles and quadratic splines. S interpolates from nodes to particles, S+ maps from particles to nodes; a wave of wave number k
comes out of either multiplied by f = 1 - (k h)^2 / 8, since the spline's variance is h^2 / 4. With velocities V and stresses s of the
particles, forces and strains take another S+ and S:

    FLIP   V <- V + dt f^2 s'          MUSL, USF: s <- s + dt E f^2 V', a leapfrog that neither makes nor loses energy
    PIC    V <- f^2 V + ...            loses (k h)^2 / 4 of the velocity in a step
    XPIC   V <- (1 - (1 - f^2)^m) V    loses ((k h)^2 / 4)^m
    APIC   the first moment restores the terms of second order; (k h)^4 / 40 is left, with C = grad v 7 (k h)^4 / 240
    USL    the strain sees f v + dt a and not f (V + dt f a): s <- (1 - (k c dt)^2 f^2 (1 - f^2)) s

`lost` has what a standing wave loses by this.
"""

from __future__ import annotations

import math

FILTER = (
    "each step maps velocities to the nodes and back and keeps nothing else, which multiplies a wave by 1 - (k h)^2 / 4: a viscosity of "
    "h^2 / (4 dt), the larger the smaller the step, by which fronts are sqrt(n) / 2 cells wide after n steps"
)
FILTERED = "FLIP, APIC or another transfer that keeps what the grid cannot see"
PASSES = (
    "m passes keep more of a wave than PIC, 1 - ((k h)^2 / 4)^m in a step, but it is a filter in every step: motion from particle to "
    "particle is lost, and in bodies few cells wide all motion is near to that"
)
AFFINE = (
    "of the motion within a cell the affine part is kept; the rest is lost in each mapping, (k h)^4 / 40 of a wave in a step (7 / 240 "
    "with C = grad v): little of long waves, some per cent in each step of fronts and of bodies few cells wide. The loss of a run goes "
    "down with the cells"
)
UNMAPPED = (
    "strains see the change of the nodal velocities in full, particles what S+ S leaves of it: stress is damped by "
    "(k c dt)^2 (k h)^2 / 4 in a step, so that energy is lost in proportion to the time step (Bardenhagen 2002)"
)
CROSSING = (
    "where slopes jump, a particle that crosses a cell face takes its whole force to another node, so that uniform stress leaves up to "
    "0.9 of it as a force (case cell-crossing), an error that does not fall with the cells (Steffen et al. 2008)"
)
SEEN_BY_THE_GRID = (
    "dissipative transfers and USL lose 10 to 30 % of the energy of this impact with 20 cells, and half of it with cells of half the size; "
    "how much depends on where particles lie between the nodes, so an offset of the grid or a flight through it changes it"
)
HELD = (
    "of a difference of velocities across a strip of thickness t a mapping to the nodes and back keeps (t / h)^2 / 3, a twelfth for half a "
    "cell; the rest is filtered away in every step, and the strip is held at its thickness: its waves are those of plane strain without "
    "lateral motion, and the period is up to 9.7 % shorter"
)
RIM = (
    "at the rim S+ sees particles on one side only, so that nodes there turn too slowly unless the velocities of the particles make up "
    "for it with a part that the grid cannot see; this part is filtered away in every step, the rim shears against the body, and angular "
    "momentum is lost: a third as much with cells of half the size, less with more passes, more with smaller steps"
)
ARMS = (
    "mapping to the nodes and back takes the angular momentum that a patch of the size of a cell has around each particle, h^2 / R^2 of a "
    "disk's in a step: all of it in a turn of 3000 steps, and with it the centrifugal stress"
)

UNLOADING = (
    "; the law is concave, so unloading from J = 3 is a shock, across which the jump conditions take 8.1 % of the energy (`unloaded`): "
    "what damps ringing loses that much, what keeps the energy has it as ringing"
)


def unloaded(J: float, t: float) -> float:
    """Share of its energy that a bar with P = (M / 2) (J - 1 / J) loses to the shock of its unloading from J to 1.

    The shock runs at rho U^2 = P / (J - 1). Of the strain energy W it meets, what is above P (J - 1) / 2 becomes neither motion nor
    strain, by the jump conditions of mass, momentum and energy.

    Parameters
    ----------
    J : float
        Stretch at the start.
    t : float
        Time, over the length of the stretched bar divided by (M / rho)^(1/2).
    """
    P, W = 0.5 * (J - 1.0 / J), 0.5 * (0.5 * (J * J - 1.0) - math.log(J))  # over M
    way = t * J * math.sqrt(P / (J - 1.0))  # of the shock, over the length of the bar at rest
    return (1.0 - 0.5 * P * (J - 1.0) / W) * min(1.0, way)


def lost(rule: str, kh: float, courant: float, steps: int) -> float:
    """Share of the energy that a standing wave loses in so many steps; half of it is motion, half strain.

    Parameters
    ----------
    rule : str
        "PIC", "XPIC" (two passes), "APIC" or "USL".
    kh : float
        Wave number times cell.
    courant : float
        Wave speed times time step over cell.
    steps : int
        How many.
    """
    amplitude = {"PIC": kh**2 / 4.0, "XPIC": kh**4 / 16.0, "APIC": kh**4 / 40.0, "USL": (courant * kh) ** 2 * kh**2 / 4.0}[rule]
    return -math.expm1(-amplitude * steps)
