"""Rigid walls on faces of the domain."""

import mpmkit as mpm
from mpmkit.math import sqrt
from mpmkit_boundaries.faces import FACES, resolve


@mpm.kernel
def clamp(v):
    """v = 0."""
    return (0.0 * v[0], 0.0 * v[1], 0.0 * v[2])


@mpm.kernel
def stick(v, normal):
    """v = 0 while moving into the wall, free otherwise."""
    v_n = v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2]
    if v_n > 0.0:
        return (0.0 * v[0], 0.0 * v[1], 0.0 * v[2])
    return (v[0], v[1], v[2])


@mpm.kernel
def block(v, normal):
    """No velocity into the wall: v - max(v . n, 0) n."""
    v_n = v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2]
    v_n = max(v_n, 0.0 * v_n)
    return (v[0] - v_n * normal[0], v[1] - v_n * normal[1], v[2] - v_n * normal[2])


@mpm.kernel
def hold_normal(v, normal):
    """No normal velocity: v - (v . n) n."""
    v_n = v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2]
    return (v[0] - v_n * normal[0], v[1] - v_n * normal[1], v[2] - v_n * normal[2])


@mpm.kernel
def coulomb(v, normal, dv_n, friction):
    """Coulomb friction: the tangential velocity loses at most friction times the normal velocity taken by the wall."""
    v_n = v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2]
    tx = v[0] - v_n * normal[0]
    ty = v[1] - v_n * normal[1]
    tz = v[2] - v_n * normal[2]
    slip = sqrt(tx * tx + ty * ty + tz * tz)
    loss = 0.0 * slip
    if slip > 0.0:
        loss = min(friction * max(dv_n, 0.0 * dv_n), slip) / slip
    return (v[0] - loss * tx, v[1] - loss * ty, v[2] - loss * tz)


@mpm.define
class Wall(mpm.BoundaryLayer):
    """A rigid wall on faces of the domain; with n out of the domain, bodies cannot move into it (v . n <= 0).

    - "stick" (default): what presses on the wall does not move, v = 0; what moves away is free.
    - "no slip": v = 0 always; the wall clamps what touches it and holds it in tension.
    - "slip": the normal velocity into the wall vanishes, tangential motion is free.
    - "friction": as slip, and Coulomb friction opposes sliding by at most ``friction`` times the normal impulse.

    Whether a node is held is decided once in a step, by the velocity that the forces alone would give it; so the wall
    does no work, and a body bounces off it as off its mirror image. With strains first (USF) that is known only after the
    strain, which is formed with what the wall held in the step before.

    The wall acts on the nodes of its face, so a body feels it from a distance of up to one cell (linear functions)
    as soon as it moves towards it. For a wall that holds the normal direction in tension too use `Symmetry`.
    """

    references = ("Chen and Brannon (2002), SAND2002-0482, section 2, essential boundary conditions",)
    faces: tuple[str, ...] = mpm.parameter("faces of the domain", choices=("all", *FACES), default=("all",), example="all")
    condition: str | None = mpm.parameter(
        "what the wall does; if not given, friction with a coefficient, else stick",
        choices=("stick", "no slip", "slip", "friction"),
        default=None,
    )
    friction: float | None = mpm.parameter("coefficient of Coulomb friction", ge=0.0, default=None, example=0.3)

    def check(self):
        if self.condition not in (None, "friction") and self.friction is not None:
            raise mpm.ParameterError(
                f"Wall.friction = {self.friction:g} would be ignored with condition {self.condition!r}; leave it out, or use "
                "condition='friction'"
            )
        if self.condition == "friction" and self.friction is None:
            raise mpm.ParameterError("Wall.friction is required with condition='friction', for example 0.3")

    @property
    def mode(self):
        return self.condition or ("stick" if self.friction is None else "friction")

    @property
    def bilateral(self):
        return self.mode == "no slip"

    @property
    def constrain(self):
        return {"stick": stick, "no slip": clamp}.get(self.mode, block)

    @property
    def hold(self):
        return None if self.bilateral else clamp if self.mode == "stick" else hold_normal

    @property
    def rub(self):
        return coulomb if self.mode == "friction" else None

    def faces_of(self, grid):
        return resolve(self.faces, grid, "Wall.faces")
