"""Text of the loops over all nodes: momentum update, velocities, filtering."""

from __future__ import annotations

from mpmkit._core.composing.sweep import FORCE, Sweep, limited, node, value_arguments, vector


def momentum(sweep: Sweep, has_velocity: bool, name: str) -> str:
    """v_i^old = (mv)_i / m_i and v_i = v_i^old + dt (f_i / m_i + accelerations)."""
    c, layout, dim = sweep.composition, sweep.layout, sweep.dim
    small = sweep.smallest_mass()
    lines = [f"m = {node(layout, 'm')}", f"if m > {small}:"]
    inner, old = [], "v" if c.merges else "v_old"
    if not has_velocity:
        inner += [f"{node(layout, old, a)} /= m" for a in range(dim)]
    inner.append(f"v_old = {vector(layout, old, dim)}{'  # with the internal forces' if c.merges else ''}")
    acceleration = ["zero" if c.merges else f"{node(layout, 'v', a)} / m" for a in range(dim)]
    accounts = []
    for role, effect in c.effects.items():
        if effect.acceleration is None:
            continue
        special = {"v": "v_old"}
        if "x" in effect.acceleration.arguments or any("x" in value_arguments(effect, n, c.dim) for n in effect.acceleration.arguments):
            special["x"] = "x"
            if "x = " not in " ".join(inner):
                inner.append(f"x = {sweep.position('i')}")
        inner.append(f"{role}_a = {sweep.call('acceleration', effect.acceleration, role, None, special)}")
        acceleration = [f"{text} + {role}_a[{a}]" for a, text in enumerate(acceleration)]
        accounts.append((f"m * {role}_a[{{a}}]", effect.work))
    inner += [f"a{a} = {acceleration[a]}" for a in range(dim)]
    inner += [f"{node(layout, 'v', a)} = v_old[{a}] + dt * a{a}" for a in range(dim)]
    if "f_ext" in layout.start and c.stored_operator:
        accounts.append((f"G[k + {layout.start['f_ext']} + {{a}}]", "external"))
    for k, (force, column) in enumerate(accounts):
        for a in range(dim):
            inner.append(f"p{k}_{a} = {force.format(a=a)} * dt")
        power = " + ".join(f"p{k}_{a} * (v_old[{a}] + dt / T(2) * a{a})" for a in range(dim))
        sign = "-" if column == "dissipated" else "+"
        inner.append(f"{'effects' if column == 'dissipated' else 'external'} {sign}= {power}")
        inner += [f"push{a} += p{k}_{a}" for a in range(dim)]
    if "f_ext" in layout.start and not c.stored_operator:
        # the velocity that external forces give; its work is summed over the particles, which move with the grid's mean
        # velocity: a node with little mass may be far from any particle's velocity
        for a in range(dim):
            inner += [f"push{a} += {node(layout, 'f_ext', a)} * dt", f"{node(layout, 'f_ext', a)} *= dt / m"]
    if "v_given" in layout.start:
        # what acts on all mass alike is not a matter of little mass; loads of particle layers are, and come in the same channel
        for a in range(dim):
            parts = [f"dt * {role}_a[{a}]" for role, effect in c.effects.items() if effect.acceleration is not None]
            parts += [node(layout, "f_ext", a)] if "f_ext" in layout.start and not c.loaded else []
            inner.append(f"{node(layout, 'v_given', a)} = {' + '.join(parts)}")
    pushes = bool(accounts) or "f_ext" in layout.start
    lines += [f"    {line}" for line in inner]
    lines += ["else:  # no particle within reach"]
    lines += [f"    {node(layout, channel, a)} = zero" for channel in dict.fromkeys((old, "v")) for a in range(dim)]
    names = {"external": 0, "effects": 1} | {f"push{a}": FORCE + a for a in range(dim)} if pushes else {}
    return sweep.over_nodes(name, "Nodes: v_i = (mv)_i / m_i, v_i += dt (f_i / m_i + accelerations).", lines, names)


def divide(sweep: Sweep, channel: str, name: str, doc: str) -> str:
    """Momentum to velocity in one channel."""
    layout, dim = sweep.layout, sweep.dim
    small = sweep.smallest_mass()
    lines = [f"m = {node(layout, 'm')}", f"if m > {small}:"]
    lines += [f"    {node(layout, channel, a)} /= m" for a in range(dim)]
    lines += ["else:"] + [f"    {node(layout, channel, a)} = zero" for a in range(dim)]
    return sweep.over_nodes(name, doc, lines, {})


def limit(sweep: Sweep, name: str, channel: str, mass: str) -> str:
    """Velocities with the change limited at nodes lighter than `mass`, the name of a parameter."""
    layout, dim = sweep.layout, sweep.dim
    least = sweep.parameter(mass, lambda roles: roles[mass])
    lines = [f"share = min(one, {node(layout, 'm')} / {least})"]
    shape = sweep.composition.shape
    for a in range(dim):
        lines += [*limited(layout, a, shape is not None and shape.smooth), f"{node(layout, channel, a)} = u{a}"]
    return sweep.over_nodes(name, f"Nodes: velocities {channel}, limited where there is little mass.", lines, {})


def carry(sweep: Sweep, name: str) -> str:
    """Nodes keep their velocity: v_old = v, f = 0."""
    layout, dim = sweep.layout, sweep.dim
    lines = []
    for a in range(dim):
        lines += [f"{node(layout, 'v_old', a)} = {node(layout, 'v', a)}", f"{node(layout, 'v', a)} = zero"]
        if "f_ext" in layout.start:
            lines.append(f"{node(layout, 'f_ext', a)} = zero")
    return sweep.over_nodes(name, "Nodes carry their velocity: v_old = v, f = 0.", lines, {})


def filter_start(sweep: Sweep) -> str:
    """XPIC: the filtered velocity starts as order times v_old."""
    layout, dim = sweep.layout, sweep.dim
    lines = []
    for a in range(dim):
        old = node(layout, "v_old", a)
        lines += [
            f"{node(layout, 'u', a)} = {old}",
            f"{node(layout, 'v_smooth', a)} = weight * {old}",
            f"{node(layout, 'u_next', a)} = zero",
        ]
    return sweep.over_nodes("filter_start", "Nodes: start of the filtered velocity of XPIC.", lines, {}, "weight, ")


def filter_add(sweep: Sweep) -> str:
    """XPIC: u_i = (sum_p m_p N_i u_p) / m_i and v_smooth += weight u."""
    layout, dim = sweep.layout, sweep.dim
    small = sweep.smallest_mass()
    lines = [f"m = {node(layout, 'm')}", f"if m > {small}:"]
    for a in range(dim):
        u, u_next = node(layout, "u", a), node(layout, "u_next", a)
        lines += [f"    {u} = {u_next} / m", f"    {node(layout, 'v_smooth', a)} += weight * {u}", f"    {u_next} = zero"]
    return sweep.over_nodes("filter_add", "Nodes: one term of the filtered velocity of XPIC.", lines, {}, "weight, ")
