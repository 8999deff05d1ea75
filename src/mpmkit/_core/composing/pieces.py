"""What each verb adds to a loop over particles. One function per verb; the letters are those of the literature.

A piece is called twice: with ``part="before"`` (sums over the nodes, and what must be read before any verb of the loop
changes it) and ``part="compute"`` (what follows, and the terms that are added to the nodes).
"""

from __future__ import annotations

from collections.abc import Callable

from mpmkit._core.composing.sizes import half_size
from mpmkit._core.composing.source import ParticleLoop

LEAST_MOMENT = 0.125
"""Second moment of the weights [h^2] below which the affine motion is held back: stable up to dt c / h = 2 (D / 3)^(1/2) = 0.4 in three
dimensions without any stiffness in shear. Splines have 1/4 or more away from the faces, and no less than 1/8 for the outermost particles
of up to three in a cell."""

SYM_AT = ((0, 3, 5), (3, 1, 4), (5, 4, 2))  # index of sigma_ab among xx yy zz xy yz xz

Piece = Callable[[ParticleLoop, str, dict[str, str]], None]


def _momentum(loop: ParticleLoop, channel: str) -> None:
    """m (v + C (x_i - x_p)) N_i to a channel."""
    for a in range(loop.dim):
        loop.add(channel, a, "w", f"m * v[{a}]")
        if "C" in loop.group.layout.fields:
            loop.add(channel, a, "r", *[f"m * C[{3 * a + b}]" for b in range(loop.dim)])


def p2g(loop: ParticleLoop, part: str, channel: dict[str, str]) -> None:
    if part == "before":
        return
    loop.titles.append("mass and momentum to the nodes: m_i = sum_p m_p N_i, (mv)_i = sum_p m_p v_p N_i")
    for name in ("m", "v", *(["C"] if "C" in loop.group.layout.fields else [])):
        loop.field(name)
    if "size_now" in loop.group.layout.fields:
        loop.line(f"size_now = ({', '.join([half_size(loop, a) for a in range(loop.dim)] + ['zero'] * (3 - loop.dim))})")
        loop.store("size_now")
    loop.add("m", 0, "w", "m")
    _momentum(loop, "v" if loop.composition.merges else "v_old")


def forces(loop: ParticleLoop, part: str, channel: dict[str, str]) -> None:
    if part == "before":
        return
    c, dim = loop.composition, loop.dim
    loop.titles.append(
        "internal forces f_i = -sum_p V_p sigma_p grad N_i" + (", with the viscous pressure q" if "q" in loop.group.layout.fields else "")
    )
    stress = loop.field("stress")
    if "q" in loop.group.layout.fields:
        loop.field("q")
        loop.line("total = add_diagonal(stress, -q)")
        loop.names.of("add_diagonal", _tensor("add_diagonal"))
        stress = "total"
    if c.reference:
        # first Piola-Kirchhoff stress P = J sigma F^-T, gradients with respect to X
        loop.names.of("first_piola", _tensor("first_piola"))
        loop.field("F"), loop.field("V0")
        loop.line(f"piola = first_piola({stress}, F)")
        k_ab = [[f"-V0 * piola[{3 * a + b}]" for b in range(dim)] for a in range(dim)]
    else:
        loop.field("V")
        k_ab = [[f"-V * {stress}[{SYM_AT[a][b]}]" for b in range(dim)] for a in range(dim)]
    least_squares = c.transfer is not None and c.transfer.gradient == "moment"
    if least_squares:
        # grad N_i = N_i (x_i - x_p) / D, the gradient of the moving-least-squares fit
        inverse = inverse_moments(loop)
        k_ab = [[f"{text} * {inverse[b]}" for b, text in enumerate(row)] for row in k_ab]
    if c.merges:
        k_ab = [[f"dt * ({text})" for text in row] for row in k_ab]
    for a in range(dim):
        loop.add("v", a, "r" if least_squares else "g", *k_ab[a])
    if c.grid.space == "axisymmetric":
        loop.field("x")
        loop.add("v", 0, "w", f"-{'dt * ' if c.merges else ''}V * {stress}[2] / x[0]")
    for role, effect in c.effects.items():
        if effect.body_force is not None:
            loop.field("m")
            loop.titles.append(f"body force of {role}")
            loop.line(f"{role}_b = {loop.call('body_force', effect.body_force, role, loop.group, {})}")
            for a in range(dim):
                loop.add("v", a, "w", f"m * {role}_b[{a}]")
                loop.add("f_ext", a, "w", f"m * {role}_b[{a}]")


def outward(loop: ParticleLoop, part: str, channel: dict[str, str]) -> None:
    """The gradient of the body's volume, for normals of contact."""
    if part == "compute":
        loop.titles.append("outward normals of the body, sum_p V_p grad N_i, near another body")
        loop.field("V")
        for a in range(loop.dim):
            loop.add("outward", a, "g", *["V" if a == b else "zero" for b in range(loop.dim)])


def filter_(loop: ParticleLoop, part: str, channel: dict[str, str]) -> None:
    """One pass of XPIC: u_i <- sum_p m_p N_i(x_p) sum_j N_j(x_p) u_j / m_i (the division follows at the nodes)."""
    u = loop.summed(channel["u"], "w")
    if part == "compute":
        loop.titles.append("one filtering pass of XPIC")
        loop.field("m")
        for a in range(loop.dim):
            loop.add(channel["u_next"], a, "w", f"m * {u[a]}")


def inverse_moments(loop: ParticleLoop) -> list[str]:
    """1 / D_b with D_b = sum_i N_i (x_i - x_p)_b^2; the inverses in units of cells by one division for all axes."""
    dim = loop.dim
    names = [f"inv_D{b}" for b in range(dim)]
    if "inverse moments" not in loop.have:
        second_moments(loop)
        loop.line(f"inv_D = one / ({' * '.join(f'D{b}' for b in range(dim))})")
        for b in range(dim):
            inv_h = loop.along("inv_h", b)
            others = "".join(f" * D{a}" for a in range(dim) if a != b)
            loop.line(f"inv_D{b} = inv_D{others} * {inv_h} * {inv_h}")
        loop.have.add("inverse moments")
    return names


def second_moments(loop: ParticleLoop) -> None:
    """``D0``, ``D1`` ...: sum_i N_i (x_i - x_p)_b^2 / h_b^2, from the weights along one axis."""
    if "second moments" not in loop.have:
        for b in range(loop.dim):
            loop.line(f"D{b} = {loop.second_moment(b)}")
        loop.have.add("second moments")


def g2p(loop: ParticleLoop, part: str, channel: dict[str, str]) -> None:
    c, dim = loop.composition, loop.dim
    transfer = c.transfer
    asks = transfer.velocity.arguments if transfer is not None else ("v_grid",)
    external = "f_ext" in loop.nodes.start and not c.stored_operator
    v_grid = loop.summed("v", "w")
    affine = transfer.affine if transfer is not None else "none"
    source = "v_soft" if affine != "none" and c.softens else "v"
    # with two nodes in a direction the moments N_i (x_i - x_p) / D are the slopes
    by_moment = affine == "moment" and c.shape is not None and c.shape.nodes > 2
    if part == "before":
        loop.titles.append(
            f"particle velocities by {type(transfer).__name__}" if transfer is not None else "particle velocities from the nodes"
        )
        if "dv_grid" in asks:
            loop.summed("v_old", "w")
        if "v_smooth" in asks:
            loop.summed("v_smooth", "w")
        if external:
            loop.field("v"), loop.field("m"), loop.summed("f_ext", "w")
            if affine != "none":
                loop.field("C"), loop.summed("f_ext", "k" if by_moment else "g")
        if by_moment:
            loop.summed(source, "w")
        if affine != "none":
            loop.summed(source, "k" if by_moment else "g")
        return
    if external:
        loop.line("v_before = v")
        if affine != "none":
            loop.line("C_before = C")
    if transfer is None:
        loop.line(f"v = ({', '.join(v_grid + ['zero'] * (3 - dim))})")
    else:
        if "v" in asks:
            loop.field("v")
        parts = []
        for a in range(dim):
            special = {"v": f"v[{a}]", "v_grid": v_grid[a], "dv_grid": f"v_w{a} - v_old_w{a}", "v_smooth": f"v_smooth_w{a}"}
            parts.append(loop.call("velocity", transfer.velocity, "transfer", loop.group, special))
        loop.line(f"v = ({', '.join(parts + ['zero'] * (3 - dim))})")
        if affine != "none":
            C, held = affine_matrix(loop, source, by_moment), held_back(loop)
            loop.line(f"C = ({', '.join(_full([f'{one} * {held[k % dim]}' if held else one for k, one in enumerate(C)], dim))})")
            loop.store("C")
    if external:
        power = " + ".join(f"f_ext_w{a} * (v_before[{a}] + v[{a}])" for a in range(dim))
        if affine != "none":  # and on the affine part of the motion, whose kinetic energy is in the ledger too
            second_moments(loop)
            given, h = affine_matrix(loop, "f_ext", by_moment), [loop.along("h", b) for b in range(dim)]
            for a in range(dim):
                for b in range(dim):
                    power += f" + {given[dim * a + b]} * (C_before[{3 * a + b}] + C[{3 * a + b}]) * (D{b} * {h[b]} * {h[b]})"
        loop.total("external", f"T(0.5) * m * ({power})")
    loop.store("v")


def held_back(loop: ParticleLoop) -> list[str]:
    """Factors of the columns of C, min(1, D_b / `LEAST_MOMENT`); none for kinked shape functions, with which light nodes are softened.

    A particle that its own forces set in affine motion is an oscillator of frequency c / (h sqrt(D)): a node at a distance of a cell that
    has the share D of its mass takes all of the force. On an interpolating node, as on a face of the domain, D is zero, and no step
    would be stable. FLIP does not feel it, because v_p is a mean over the nodes; C is a difference.
    """
    shape = loop.composition.shape
    if shape is None or not shape.smooth:
        return []
    second_moments(loop)
    if "held" not in loop.have:
        for b in range(loop.dim):
            loop.line(f"held{b} = min(one, D{b} * T({1.0 / LEAST_MOMENT!r}))")
        loop.have.add("held")
    return [f"held{b}" for b in range(loop.dim)]


def affine_matrix(loop: ParticleLoop, source: str, by_moment: bool) -> list[str]:
    """C_ab at [dim a + b]: B D^-1 with B = sum_i v_i N_i (x_i - x_p), or sum_i v_i grad N_i."""
    if not by_moment:
        return loop.summed(source, "g")
    mean, first, inverse = loop.summed(source, "w"), loop.summed(source, "k"), inverse_moments(loop)
    return [
        f"({first[loop.dim * a + b]} - {loop.place(b)} * {mean[a]}) * ({loop.along('h', b)} * {inverse[b]})"
        for a in range(loop.dim)
        for b in range(loop.dim)
    ]


def _full(matrix: list[str], dim: int, corner: str = "zero") -> list[str]:
    """A matrix of the plane as one of space."""
    full = [matrix[dim * a + b] if a < dim and b < dim else "zero" for a in range(3) for b in range(3)]
    if dim < 3:
        full[8] = corner
    return full


def remap(loop: ParticleLoop, part: str, channel: dict[str, str]) -> None:
    if part == "before":
        return
    loop.titles.append("second mapping: (mv)_i = sum_p m_p v_p N_i with the updated velocities")
    for name in ("m", "v", *(["C"] if "C" in loop.group.layout.fields else [])):
        loop.field(name)
    _momentum(loop, "v_map")


def advect(loop: ParticleLoop, part: str, channel: dict[str, str]) -> None:
    dim = loop.dim
    v_grid = loop.summed("v", "w")
    if part == "before":
        loop.titles.append("positions: x_p += dt sum_i v_i N_i")
        loop.field("x")
        return
    new = [f"x[{a}] + dt * {v_grid[a]}" for a in range(dim)]
    loop.line(f"x = ({', '.join(new + ['zero'] * (3 - dim))})")
    kept = []
    for a in range(dim):
        low, high, slack = (loop.along(name, a) for name in ("lower", "upper", "slack"))
        # What rounding has put outside is on the face; a wall lets particles come as near as that.
        loop.line(f"room{a} = min(x[{a}] - {low}, {high} - x[{a}])")
        loop.watch("inside", f"room{a} + {slack}", ">=")
        loop.maximum("moved", f"abs(dt * {v_grid[a]}) * {loop.along('inv_h', a)}")
        kept.append(f"min(max(x[{a}], {low}), {high}) if room{a} >= -{slack} else x[{a}]")
    loop.line(f"x = ({', '.join(kept + ['zero'] * (3 - dim))})")
    loop.store("x")
    if loop.composition.strains_first:
        loop.line(f"motion = {motion(loop)}")
        loop.maximum("motion", "motion")


def motion(loop: ParticleLoop) -> str:
    """The largest speed that a particle gives to nodes: |v|, with affine transfers |v| + |C| h, since they get v + C (x_i - x_p)."""
    v = loop.field("v")
    squares = " + ".join(f"{v}[{a}] * {v}[{a}]" for a in range(loop.dim))
    fastest = f"sqrt({squares})"
    if "C" in loop.group.layout.fields:
        C = loop.field("C")
        edges = [f"({C}[{3 * a + b}] * {loop.along('h', b)})" for a in range(loop.dim) for b in range(loop.dim)]
        fastest += f" + sqrt({' + '.join(f'{one} * {one}' for one in edges)})"
    return fastest


def strain(loop: ParticleLoop, part: str, channel: dict[str, str]) -> None:
    c, dim = loop.composition, loop.dim
    source = channel["strain"]
    affine = c.transfer is not None and c.transfer.gradient == "moment"
    hoop = c.grid.space == "axisymmetric"
    if part == "before":
        loop.titles.append("L_p = sum_i v_i grad N_i, and the update of F or J")
        if affine:
            loop.summed(source, "w"), loop.summed(source, "k")
        else:
            loop.summed(source, "g")
        if hoop:
            loop.summed(source, "w")
            loop.field("x")
            # the hoop strain belongs to the position at which L was formed, before the particle is moved
            loop.line("r_p = x[0]")
        return
    corner = f"{loop.summed(source, 'w')[0]} / r_p" if hoop else "zero"
    loop.line(f"L = ({', '.join(_full(affine_matrix(loop, source, affine), dim, corner))})")
    kind = getattr(c.integrator, "strain", "exponential").replace("-", "_")
    if kind == "centred":
        # L of a recipe that strains first belongs to the displacement that has led to x, of others to that which follows
        way = "-dt" if c.strains_first else "dt"
        loop.line(f"L = {loop.names.of('centred', _tensor('centred'))}(L, {way})")
        kind = "midpoint"
    if c.reference:
        loop.names.of("reference_step", _tensor("reference_step"))
        loop.field("F")
        loop.line("F, L = reference_step(F, L, dt)  # L so far is grad_X v")
        loop.store("F")
    elif "F" in loop.group.layout.fields:
        increment = loop.names.of(f"{kind}_increment", _tensor(f"{kind}_increment"))
        loop.names.of("matmul", _tensor("matmul"))
        loop.field("F")
        loop.line(f"F = matmul({increment}(L, dt), F)")
        loop.store("F")
    else:
        ratio = loop.names.of(f"{kind}_volume_ratio", _tensor(f"{kind}_volume_ratio"))
        loop.field("J")
        loop.line(f"J = J * {ratio}(L, dt)")
        loop.store("J")
        loop.have.add("J")
    loop.forget("V", "rho", *loop.group.layout.derived, *(["J"] if "F" in loop.group.layout.fields else []))
    loop.have.add("L")
    loop.watch("inverted", str(loop.field("J")))
    if c.shape is not None and c.shape.particle_size == "current":
        for a in range(dim):
            loop.watch("stretched", f"T({c.shape.max_half!r}) - {half_size(loop, a)} * {loop.along('inv_h', a)}", ">=")


def stress(loop: ParticleLoop, part: str, channel: dict[str, str]) -> None:
    if part == "before":
        return
    group, c, law = loop.group, loop.composition, type(loop.group.material).__name__
    if group.keeps_stress:
        loop.titles.append(f"stress by {law}, its wave speed for the next time step")
        loop.line(f"{', '.join(['stress', *(loop.local(f.name) for f in group.state)])} = {loop.material('stress')}")
        for name in ("stress", *(f.name for f in group.state)):
            loop.store(name)
    else:
        loop.titles.append(f"wave speed of {law} for the next time step")
    loop.line(f"c = {loop.material('wave_speed')}")
    loop.have.add("c")
    speed = "c"
    for role, effect in c.effects.items():
        if effect.viscous_pressure is not None:
            loop.titles.append(f"viscous pressure of {role}")
            loop.line(f"q = {loop.call('viscous_pressure', effect.viscous_pressure, role, group, {})}")
            loop.field("V")
            loop.total("viscous", "-q * (L[0] + L[4] + L[8]) * V * dt")
            loop.store("q")
        if effect.signal_speed is not None:
            loop.line(f"signal = {loop.call('signal_speed', effect.signal_speed, role, group, {'c': speed})}")
            speed = "signal"
    # strains first: velocities are those of before the update; `advect` has those of after it
    fastest = speed if c.strains_first else f"{speed} + {motion(loop)}"
    loop.line(f"signal_speed = {fastest}")
    loop.maximum("speed", "signal_speed")
    if "diffusivity" in group.hooks:
        loop.line(f"diffusivity = {loop.material('diffusivity')}")
        loop.maximum("diffusion", "diffusivity")


def _tensor(name: str) -> Callable[..., object]:
    import mpmkit._core.composing.increments as increments
    import mpmkit.tensor as tensor

    return getattr(increments, name, None) or getattr(tensor, name)  # type: ignore[no-any-return]


PIECES: dict[str, Piece] = {
    "p2g": p2g,
    "forces": forces,
    "outward": outward,
    "filter": filter_,
    "g2p": g2p,
    "remap": remap,
    "advect": advect,
    "strain": strain,
    "stress": stress,
}
