"""Faulty transfers, integrators and discretizations."""

import itertools

import attrs
from mpmkit_fem import FEM
from mpmkit_integrators import MUSL, PIC
from mutants import mutant

import mpmkit as mpm

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
    return v_grid + 0.01 * v_grid * (v + dv_grid - v_grid)


@mutant("is linear", also=("momentum is conserved",))
@mpm.define
class Bent(PIC):
    """Depends on the square of velocities, v = v + v (v - v) / 100."""

    velocity = bent


@mpm.kernel
def less_on_coarse_grids(v_grid, h):
    return (0.999 if h > 0.2 else 1.0) * v_grid


@mutant("free flight", also=("free fall",))
@mpm.define
class LosingOnCoarseGrids(PIC):
    """Loses velocity on coarse grids, v = 0.999 v."""

    velocity = less_on_coarse_grids


@mpm.kernel
def late_on_coarse_grids(v_grid, dv_grid, h):
    return v_grid - (0.01 if h > 0.2 else 0.0) * dv_grid


@mutant("free fall")
@mpm.define
class LateOnCoarseGrids(PIC):
    """A part of gravity comes too late on coarse grids, v = v - dv / 100."""

    velocity = late_on_coarse_grids


@mpm.kernel
def bent_in_short_steps(v, v_grid, dv_grid, dt):
    return v_grid + (0.01 if dt < 9e-4 else 0.0) * v_grid * (v + dv_grid - v_grid)


@mutant("momentum is conserved")
@mpm.define
class BentInShortSteps(PIC):
    """Loses momentum in short steps, v = v + v (v - v) / 100."""

    velocity = bent_in_short_steps


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


@mutant("free flight", also=("free fall",))
@mpm.define
class LosingMUSL(MUSL):
    """Loses velocity on coarse grids."""

    angular_momentum = False
    transfer: mpm.Transfer = mpm.parameter("that loses", default=LosingOnCoarseGrids())


@mutant("free fall")
@mpm.define
class LateMUSL(MUSL):
    """Falls too slowly on coarse grids."""

    angular_momentum = False
    transfer: mpm.Transfer = mpm.parameter("that is late", default=LateOnCoarseGrids())


@mutant("momentum is conserved")
@mpm.define
class BentMUSL(MUSL):
    """Loses momentum in short steps."""

    angular_momentum = False
    transfer: mpm.Transfer = mpm.parameter("that is bent", default=BentInShortSteps())


@mutant(ANGULAR)
@mpm.define
class BoastingMUSL(MUSL):
    """Claims to conserve angular momentum."""

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


@mutant("free fall")
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
