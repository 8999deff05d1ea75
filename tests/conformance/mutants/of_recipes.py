"""Faulty transfers, integrators and discretizations."""

import itertools

import attrs
from mpmkit_fem import FEM
from mpmkit_integrators import FLIP, MUSL, PIC

import mpmkit as mpm
from mutants import mutant

FLIGHTS = ("free flight", "free fall")
ANGULAR = "angular momentum is conserved where claimed"


# --- transfers -----------------------------------------------------------------------------------------------------
@mpm.kernel
def slightly_less(v_grid):
    return 0.999 * v_grid


@mutant("keeps a constant velocity", also=("falls freely", "momentum is conserved", *FLIGHTS))
@mpm.define
class Losing(PIC):
    """Loses velocity, v = 0.999 v."""

    velocity = slightly_less


@mpm.kernel
def late_gravity(v_grid, dv_grid):
    return v_grid - 0.01 * dv_grid


@mutant("falls freely", also=("free fall",))
@mpm.define
class Late(PIC):
    """A hundredth of each change comes too late, v = v - dv / 100."""

    velocity = late_gravity


@mpm.kernel
def bent(v, v_grid, dv_grid):
    return v + dv_grid + 0.01 * v_grid * (v + dv_grid - v_grid)


@mutant("is linear", "momentum is conserved")
@mpm.define
class Bent(FLIP):
    """Depends on the square of velocities, v = v + v (v - v) / 100."""

    velocity = bent


@mpm.kernel
def less_in_flight(v, dv_grid):
    return (0.999 if v - 0.8 < 1e-9 and 0.8 - v < 1e-9 and dv_grid < 1e-4 else 1.0) * (v + dv_grid)


@mutant("free flight")
@mpm.define
class LosingInFlight(FLIP):
    """Loses a velocity of 0.8 m/s without acceleration, v = 0.999 v."""

    velocity = less_in_flight


@mpm.kernel
def late_at_first(v, dv_grid):
    first = v - 0.8 < 1e-9 and 0.8 - v < 1e-9 and dv_grid > 1e-4
    return v + (0.99 if first else 1.0) * dv_grid


@mutant("free fall")
@mpm.define
class LateAtFirst(FLIP):
    """Takes up less of the first acceleration, v = v + 0.99 dv."""

    velocity = late_at_first


@mutant(ANGULAR)
@mpm.define
class Boasting(PIC):
    """Claims to conserve angular momentum, v = v."""

    angular_momentum = True


@mpm.kernel
def filtered(v_smooth, dv_grid):
    return v_smooth + dv_grid


@mutant("describes its maps", also=(*FLIGHTS, "momentum is conserved"))
@mpm.define
class Unfiltered(PIC):
    """Asks for a filtered velocity that is not made, v = v*."""

    velocity = filtered


# --- integrators ---------------------------------------------------------------------------------------------------
@mutant("recipe is complete and in order")
@mpm.define
class Untouchable(MUSL):
    """Forgets contact."""

    def step(self, s):
        s.p2g()
        s.forces()
        s.momentum()
        s.boundary()
        s.g2p()
        s.remap()
        s.boundary()
        s.advect()
        s.strain()
        s.stress()


CALLS = itertools.count()


@mutant("same recipe every time")
@mpm.define
class Fickle(MUSL):
    """Makes contact twice in every second step that it writes."""

    def step(self, s):
        s.p2g()
        s.forces()
        s.momentum()
        s.contact()
        s.boundary()
        if next(CALLS) % 2:
            s.contact()
        s.g2p()
        s.remap()
        s.contact()
        s.boundary()
        s.advect()
        s.strain()
        s.stress()


@mutant("free flight")
@mpm.define
class LosingMUSL(MUSL):
    """Loses velocity in free flight."""

    angular_momentum = False
    transfer: mpm.Transfer = mpm.parameter("that loses", default=LosingInFlight())


@mutant("free fall")
@mpm.define
class LateMUSL(MUSL):
    """Falls too slowly at first."""

    angular_momentum = False
    transfer: mpm.Transfer = mpm.parameter("that is late", default=LateAtFirst())


@mutant("momentum is conserved")
@mpm.define
class BentMUSL(MUSL):
    """Loses momentum where velocities differ."""

    angular_momentum = False
    time_order = 0
    transfer: mpm.Transfer = mpm.parameter("that is bent", default=Bent())


@mutant(ANGULAR)
@mpm.define
class BoastingMUSL(MUSL):
    """Claims to conserve angular momentum."""

    time_order = 0
    transfer: mpm.Transfer = mpm.parameter("that boasts", default=Boasting())


@mutant("order in time as claimed")
@mpm.define
class SecondOrderMUSL(MUSL):
    """Claims an order it has not."""

    time_order = 2


# --- discretizations -----------------------------------------------------------------------------------------------
@mutant("recipe is complete and in order")
@mpm.define
class UntouchableFEM(FEM):
    """Forgets contact."""

    def step(self, s):
        s.carry()
        s.forces()
        s.momentum()
        s.boundary()
        s.g2p()
        s.advect()
        s.strain()
        s.stress()


@mutant("stored operators are consistent")
@mpm.define
class SteepFEM(FEM):
    """Gradients that are a millionth too large."""

    def mesh(self, grid, body):
        points = super().mesh(grid, body)
        return attrs.evolve(points, dN=1.000001 * points.dN)


@mutant("free flight", also=("free fall",))
@mpm.define
class SlowFEM(FEM):
    """Begins with less velocity than the body has."""

    def mesh(self, grid, body):
        points = super().mesh(grid, body)
        return attrs.evolve(points, v=0.999 * points.v)


@mutant("free fall", also=("free flight", "momentum is conserved"))
@mpm.define
class HeavyFEM(FEM):
    """Makes the momentum update twice."""

    def step(self, s):
        s.carry()
        s.forces()
        s.momentum()
        s.momentum()
        s.contact()
        s.boundary()
        s.g2p()
        s.advect()
        s.strain()
        s.stress()


@mutant("momentum is conserved", also=("stored operators are consistent", *FLIGHTS))
@mpm.define
class LeaningFEM(FEM):
    """Gradients that do not add up to zero."""

    def mesh(self, grid, body):
        points = super().mesh(grid, body)
        return attrs.evolve(points, dN=points.dN + 1e-6)


@mutant("order in time as claimed")
@mpm.define
class SecondOrderFEM(FEM):
    """Claims an order it has not."""

    time_order = 2
