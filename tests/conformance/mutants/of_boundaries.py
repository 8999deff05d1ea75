"""Faulty boundary layers."""

import attrs
from mpmkit_boundaries import PrescribedVelocity, Symmetry, TractionLayer
from mpmkit_boundaries.wall import stick

import mpmkit as mpm
from mutants import mutant

SCENES = ("impulses are booked", "a wall at rest does no work")


@mutant("supplies a hook", also=SCENES)
@mpm.define
class LetsGo(Symmetry):
    """Lets nodes go and does not say what holds them, v . n <= 0."""

    constrain = stick

    @property
    def bilateral(self):
        return False


@mpm.kernel
def half_the_slip(v, normal):
    v_n = v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2]
    return (0.5 * (v[0] - v_n * normal[0]), 0.5 * (v[1] - v_n * normal[1]), 0.5 * (v[2] - v_n * normal[2]))


@mutant("applying twice is applying once")
@mpm.define
class HalfSlip(Symmetry):
    """Takes half of the slip each time, v_t = v_t / 2."""

    constrain = half_the_slip


@mpm.kernel
def nothing(v, normal):
    return (v[0], v[1], v[2])


@mutant("nothing passes a wall at rest")
@mpm.define
class Open(Symmetry):
    """Lets everything pass, v = v."""

    constrain = nothing


@mpm.kernel
def thrust(v, dv_n):
    return (v[0] + dv_n, v[1], v[2])


@mutant("friction gains no energy", also=SCENES)
@mpm.define
class Thrust(Symmetry):
    """Pushes where it should rub, v = v + dv."""

    rub = thrust


@mpm.kernel
def squared_force(traction, area):
    f = (area * traction[0] * traction[0], area * traction[1], area * traction[2])
    return f, (0.0 * area, 0.0 * area, 0.0 * area)


@mutant("load follows the traction")
@mpm.define
class Squared(TractionLayer):
    """A force that grows with the square of the traction, f = t^2."""

    load = squared_force


@mutant("acts on nodes that exist")
@mpm.define
class Meddler(Symmetry):
    """Moves the nodes that it is asked about, v . n = 0."""

    def faces_of(self, grid):
        return ()

    def nodes_in(self, x, t):
        x += 1e-9
        return x[:, 0] < 1e-3


@mutant("selects particles of its body")
@mpm.define
class LongNormals(TractionLayer):
    """Normals of length two, f = t A."""

    def select(self, points, grid):
        found = super().select(points, grid)
        return attrs.evolve(found, normals=2.0 * found.normals)


@mutant("loads the whole face")
@mpm.define
class HalfTheFace(TractionLayer):
    """Loads half of the face, f = t A / 2."""

    def select(self, points, grid):
        found = super().select(points, grid)
        return attrs.evolve(found, area=0.5 * found.area)


@mutant("speed bounds what it prescribes")
@mpm.define
class Understated(PrescribedVelocity):
    """Says a tenth of the speed it prescribes, v = V."""

    def speed(self):
        return 0.1 * super().speed()


@mpm.kernel
def endless_at_the_wall(v, normal, x):
    k = 1e300 if x[0] == 0.0 else 0.0
    v_n = v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2]
    return (v[0] - v_n * normal[0] + k, v[1] - v_n * normal[1], v[2] - v_n * normal[2])


@mutant(SCENES[0], also=SCENES)
@mpm.define
class EndlessAtTheWall(Symmetry):
    """A velocity without end at x = 0, v = 1e300."""

    constrain = endless_at_the_wall


@mpm.kernel
def kick(v, normal, x):
    k = 0.1 if x[0] == 0.0 else 0.0
    v_n = v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2] - k
    return (v[0] - v_n * normal[0], v[1] - v_n * normal[1], v[2] - v_n * normal[2])


@mutant(SCENES[1])
@mpm.define
class Kicks(Symmetry):
    """Kicks the body at x = 0, v . n = 0.1."""

    constrain = kick
