"""What each verb adds to a loop over particles. One function per verb; the letters are those of the literature.

A piece is called twice: with ``part="gather"`` (values that are summed over the nodes first) and ``part="compute"``
(what follows, and what is scattered back to the nodes).
"""

from __future__ import annotations

from collections.abc import Callable

from mpmkit._core.composing.layout import NodeLayout
from mpmkit._core.composing.source import ParticleLoop

SYM_AT = ((0, 3, 5), (3, 1, 4), (5, 4, 2))  # index of sigma_ab among xx yy zz xy yz xz

Piece = Callable[[ParticleLoop, NodeLayout, str, dict[str, str]], None]


def node(layout: NodeLayout, channel: str, a: int = 0) -> str:
    offset = layout.start[channel] + a
    return f"G[k + {offset}]" if offset else "G[k]"


def limited(layout: NodeLayout, a: int) -> str:
    """The nodal velocity, its change reduced to ``share``; the change that accelerations make everywhere is left alone."""
    old, new = node(layout, "v_old", a), node(layout, "v", a)
    if "v_given" in layout.start:
        old = f"({old} + {node(layout, 'v_given', a)})"
    return f"({old} + share * ({new} - {old}))"


def _affine_velocity(loop: ParticleLoop, a: int) -> str:
    """v_a + C_ab (x_i - x_p)_b, or v_a without an affine matrix."""
    if "C" not in loop.group.layout.fields:
        return f"v[{a}]"
    loop.needs.add("r")
    return f"(v[{a}] + " + " + ".join(f"C[{3 * a + b}] * r{b}" for b in range(loop.dim)) + ")"


def p2g(loop: ParticleLoop, nodes: NodeLayout, part: str, channel: dict[str, str]) -> None:
    if part == "gather":
        return
    loop.titles.append("mass and momentum to the nodes: m_i = sum_p m_p N_i, (mv)_i = sum_p m_p v_p N_i")
    loop.needs.add("w")
    for name in ("m", "v", *(["C"] if "C" in loop.group.layout.fields else [])):
        loop.field(name)
    if "size_now" in loop.group.layout.fields:
        loop.field("size"), loop.field("F")
        loop.line(f"size_now = ({', '.join([f'size[{a}] * F[{4 * a}]' for a in range(loop.dim)] + ['zero'] * (3 - loop.dim))})")
        loop.store("size_now")
    loop.scatter += ["wm = w * m", f"{node(nodes, 'm')} += wm"]
    loop.scatter += [f"{node(nodes, 'v_old', a)} += wm * {_affine_velocity(loop, a)}" for a in range(loop.dim)]
    if "outward" in nodes.start:
        loop.needs.add("g")
        loop.field("V")
        loop.scatter += [f"{node(nodes, 'outward', a)} += V * g{a}" for a in range(loop.dim)]


def forces(loop: ParticleLoop, nodes: NodeLayout, part: str, channel: dict[str, str]) -> None:
    if part == "gather":
        return
    c, dim = loop.composition, loop.dim
    loop.titles.append(
        "internal forces f_i = -sum_p V_p sigma_p grad N_i" + (", with the viscous pressure q" if "q" in loop.group.layout.fields else "")
    )
    loop.needs |= {"g", "w"} if c.grid.space == "axisymmetric" else {"g"}
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
        k_ab = [[f"V0 * piola[{3 * a + b}]" for b in range(dim)] for a in range(dim)]
    else:
        loop.field("V")
        k_ab = [[f"V * {stress}[{SYM_AT[a][b]}]" for b in range(dim)] for a in range(dim)]
    for a in range(dim):
        for b in range(dim):
            loop.line(f"k{a}{b} = {k_ab[a][b]}")
    force = [" + ".join(f"k{a}{b} * g{b}" for b in range(dim)) for a in range(dim)]
    if c.grid.space == "axisymmetric":
        loop.field("x")
        loop.line(f"hoop = V * {stress}[2] / x[0]")
        force[0] += " + hoop * w"
    loop.scatter += [f"{node(nodes, 'v', a)} -= {force[a]}" for a in range(dim)]
    for role, effect in c.effects.items():
        if effect.body_force is not None:
            loop.needs.add("w")
            loop.field("m")
            loop.titles.append(f"body force of {role}")
            loop.line(f"{role}_b = {loop.call('body_force', effect.body_force, role, loop.group, {})}")
            for a in range(dim):
                loop.scatter.append(f"{role}_f = w * m * {role}_b[{a}]")
                loop.scatter += [f"{node(nodes, 'v', a)} += {role}_f", f"{node(nodes, 'f_ext', a)} += {role}_f"]


def filter_(loop: ParticleLoop, nodes: NodeLayout, part: str, channel: dict[str, str]) -> None:
    """One pass of XPIC: u_i <- sum_p m_p N_i(x_p) sum_j N_j(x_p) u_j / m_i (the division follows at the nodes)."""
    loop.needs.add("w")
    if part == "gather":
        loop.titles.append("one filtering pass of XPIC")
        for a in range(loop.dim):
            loop.gather_zero.append(f"u{a} = zero")
            loop.gather.append(f"u{a} += w * {node(nodes, channel['u'], a)}")
        return
    loop.field("m")
    loop.scatter += [f"{node(nodes, channel['u_next'], a)} += w * m * u{a}" for a in range(loop.dim)]


def g2p(loop: ParticleLoop, nodes: NodeLayout, part: str, channel: dict[str, str]) -> None:
    c, dim = loop.composition, loop.dim
    transfer = c.transfer
    asks = transfer.velocity.arguments if transfer is not None else ("v_grid",)
    external = "f_ext" in nodes.start and not c.stored_operator
    if part == "gather":
        loop.titles.append(
            f"particle velocities by {type(transfer).__name__}" if transfer is not None else "particle velocities from the nodes"
        )
        loop.needs.add("w")
        for a in range(dim):
            _gather_once(loop, f"vg{a}", f"w * {node(nodes, 'v', a)}")
            if "dv_grid" in asks:
                _gather_once(loop, f"dv{a}", f"w * ({node(nodes, 'v', a)} - {node(nodes, 'v_old', a)})")
            if "v_smooth" in asks:
                _gather_once(loop, f"vs{a}", f"w * {node(nodes, 'v_smooth', a)}")
        if external:
            loop.field("v"), loop.field("m")
            for a in range(dim):
                _gather_once(loop, f"dv_ext{a}", f"w * {node(nodes, 'f_ext', a)}")
        if transfer is not None and transfer.affine != "none":
            loop.needs.add("moment" if transfer.affine == "moment" else "g")
            slope = "e_" if transfer.affine == "moment" else "g"
            sharp = c.shape is not None and not c.shape.smooth
            if sharp:
                # a kinked shape function has a full slope at nodes with hardly any mass, whose velocities are wild
                light = loop.parameter("m_light", lambda roles: roles["m_light"])
                loop.gather.append(f"share = min(one, {node(nodes, 'm')} / {light})")
            for a in range(dim):
                v = limited(nodes, a) if sharp else node(nodes, "v", a)
                for b in range(dim):
                    _gather_once(loop, f"C{a}{b}", f"{v} * {slope}{b}")
        return
    if external:
        loop.line("v_before = v")
    if transfer is None:
        loop.line(f"v = ({', '.join([f'vg{a}' for a in range(dim)] + ['zero'] * (3 - dim))})")
    else:
        if "v" in asks:
            loop.field("v")
        parts = []
        for a in range(dim):
            special = {"v": f"v[{a}]", "v_grid": f"vg{a}", "dv_grid": f"dv{a}", "v_smooth": f"vs{a}"}
            parts.append(loop.call("velocity", transfer.velocity, "transfer", loop.group, special))
        loop.line(f"v = ({', '.join(parts + ['zero'] * (3 - dim))})")
        if transfer.affine != "none":
            full = [f"C{a}{b}" if a < dim and b < dim else "zero" for a in range(3) for b in range(3)]
            loop.line(f"C = ({', '.join(full)})")
            loop.store("C")
    if external:
        power = " + ".join(f"dv_ext{a} * (v_before[{a}] + v[{a}])" for a in range(dim))
        loop.line(f"external += T(0.5) * m * ({power})")
    loop.store("v")


def remap(loop: ParticleLoop, nodes: NodeLayout, part: str, channel: dict[str, str]) -> None:
    if part == "gather":
        return
    loop.titles.append("second mapping: (mv)_i = sum_p m_p v_p N_i with the updated velocities")
    loop.needs.add("w")
    for name in ("m", "v", *(["C"] if "C" in loop.group.layout.fields else [])):
        loop.field(name)
    loop.scatter += [f"{node(nodes, 'v_map', a)} += w * m * {_affine_velocity(loop, a)}" for a in range(loop.dim)]


def advect(loop: ParticleLoop, nodes: NodeLayout, part: str, channel: dict[str, str]) -> None:
    dim = loop.dim
    if part == "gather":
        loop.titles.append("positions: x_p += dt sum_i v_i N_i")
        loop.needs.add("w")
        loop.field("x")
        for a in range(dim):
            _gather_once(loop, f"vg{a}", f"w * {node(nodes, 'v', a)}")
        return
    new = [f"x[{a}] + dt * vg{a}" for a in range(dim)]
    loop.line(f"x = ({', '.join(new + ['zero'] * (3 - dim))})")
    inside = []
    for a in range(dim):
        low = loop.along("lower", a)
        high = loop.along("upper", a)
        inside.append(f"x[{a}] >= {low} and x[{a}] <= {high}")
    loop.line(f"if not ({' and '.join(inside)}):  # outside, or not a number")
    loop.line("    flag[1] = p")
    loop.line("x_low = min(x_low, x[0])")
    loop.line("x_high = max(x_high, x[0])")
    loop.store("x")


def strain(loop: ParticleLoop, nodes: NodeLayout, part: str, channel: dict[str, str]) -> None:
    c, dim = loop.composition, loop.dim
    if part == "gather":
        loop.titles.append("L_p = sum_i v_i grad N_i, and the update of F or J")
        loop.needs.add("g")
        for a in range(dim):
            for b in range(dim):
                _gather_once(loop, f"L{a}{b}", f"{node(nodes, channel['strain'], a)} * g{b}")
        if c.grid.space == "axisymmetric":
            loop.needs.add("w")
            _gather_once(loop, "v_r", f"w * {node(nodes, channel['strain'], 0)}")
            loop.field("x")
            # the hoop strain belongs to the position at which L was formed, before the particle is moved
            loop.load.append("r_p = x[0]")
        return
    full = [f"L{a}{b}" if a < dim and b < dim else "zero" for a in range(3) for b in range(3)]
    if c.grid.space == "axisymmetric":
        full[8] = "v_r / r_p"
    loop.line(f"L = ({', '.join(full)})")
    if c.reference:
        loop.names.of("reference_step", _tensor("reference_step"))
        loop.field("F")
        loop.line("F, L = reference_step(F, L, dt)  # L so far is grad_X v")
        loop.store("F")
        loop.forget("J", "V", "rho")
    elif "F" in loop.group.layout.fields:
        kind = getattr(c.integrator, "strain", "exponential").replace("-", "_")
        increment = loop.names.of(f"{kind}_increment", _tensor(f"{kind}_increment"))
        loop.names.of("matmul", _tensor("matmul"))
        loop.field("F")
        loop.line(f"F = matmul({increment}(L, dt), F)")
        loop.store("F")
        loop.forget("J", "V", "rho")
    else:
        kind = getattr(c.integrator, "strain", "exponential").replace("-", "_")
        ratio = loop.names.of(f"{kind}_volume_ratio", _tensor(f"{kind}_volume_ratio"))
        loop.field("J")
        loop.line(f"J = J * {ratio}(L, dt)")
        loop.store("J")
        loop.forget("V", "rho")
    loop.have.add("L")
    loop.line(f"if not ({loop.field('J')} > zero):  # inverted, or not a number")
    loop.line("    flag[0] = p")
    if c.shape is not None and c.shape.particle_size == "current":
        for a in range(dim):
            loop.line(f"if {loop.field('size')}[{a}] * F[{4 * a}] * {loop.along('inv_h', a)} > T({c.shape.max_half!r}):")
            loop.line("    flag[2] = p")


def stress(loop: ParticleLoop, nodes: NodeLayout, part: str, channel: dict[str, str]) -> None:
    if part == "gather":
        return
    group, c = loop.group, loop.composition
    loop.titles.append(f"stress by {type(group.material).__name__}, its wave speed for the next time step")
    call = loop.material("stress")
    if group.state:
        loop.line(f"stress, {', '.join(loop.local(f.name) for f in group.state)} = {call}")
        for field in group.state:
            loop.store(field.name)
    else:
        loop.line(f"stress = {call}")
    loop.store("stress")
    loop.line(f"c = {loop.material('wave_speed')}")
    loop.have.add("c")
    speed = "c"
    for role, effect in c.effects.items():
        if effect.viscous_pressure is not None:
            loop.titles.append(f"viscous pressure of {role}")
            loop.line(f"q = {loop.call('viscous_pressure', effect.viscous_pressure, role, group, {})}")
            loop.field("V")
            loop.line("viscous -= q * (L[0] + L[4] + L[8]) * V * dt")
            loop.store("q")
        if effect.signal_speed is not None:
            loop.line(f"signal = {loop.call('signal_speed', effect.signal_speed, role, group, {'c': speed})}")
            speed = "signal"
    v = loop.field("v")
    squares = " + ".join(f"{v}[{a}] * {v}[{a}]" for a in range(loop.dim))
    loop.line(f"speed = max(speed, {speed} + sqrt({squares}))")
    if "diffusivity" in group.hooks:
        loop.line(f"diffusion = max(diffusion, {loop.material('diffusivity')})")


def _gather_once(loop: ParticleLoop, name: str, term: str) -> None:
    """Sum `term` over the nodes into the local `name`; a sum that another verb already asked for is shared."""
    if f"{name} = zero" not in loop.gather_zero:
        loop.gather_zero.append(f"{name} = zero")
        loop.gather.append(f"{name} += {term}")


def _tensor(name: str) -> Callable[..., object]:
    import mpmkit._core.composing.increments as increments
    import mpmkit.tensor as tensor

    return getattr(increments, name, None) or getattr(tensor, name)  # type: ignore[no-any-return]


PIECES: dict[str, Piece] = {
    "p2g": p2g,
    "forces": forces,
    "filter": filter_,
    "g2p": g2p,
    "remap": remap,
    "advect": advect,
    "strain": strain,
    "stress": stress,
}
