"""Text of the loops over nodes: momentum, boundary conditions, second mapping, contact, loads of particle layers."""

from __future__ import annotations

from typing import Any

from mpmkit._core.composing.composition import Composition
from mpmkit._core.composing.layout import NodeLayout
from mpmkit._core.composing.operators import GridOperator
from mpmkit._core.composing.pieces import limited, node
from mpmkit._core.composing.source import Names, Parameters, ParticleLoop, Text

# Slots of the ledger array `work` that the loops over nodes add to.
WORK = (
    "external",
    "effect_dissipation",
    "boundary",
    "friction",
    "impulse_x",
    "impulse_y",
    "impulse_z",
    "force_x",
    "force_y",
    "force_z",
)
IMPULSE, FORCE = WORK.index("impulse_x"), WORK.index("force_x")


def vector(layout: NodeLayout, channel: str, dim: int) -> str:
    """A nodal vector as a tuple of three."""
    return "(" + ", ".join([node(layout, channel, a) for a in range(dim)] + ["zero"] * (3 - dim)) + ")"


def assign(layout: NodeLayout, channel: str, dim: int, name: str) -> list[str]:
    return [f"{node(layout, channel, a)} = {name}[{a}]" for a in range(dim)]


class Sweep(Text):
    """One loop over a range of nodes, or over a list of nodes."""

    def __init__(self, composition: Composition, parameters: Parameters, names: Names, layout: NodeLayout) -> None:
        super().__init__(composition, parameters, names)
        self.layout = layout
        self.dim = composition.dim

    def position(self, index: str) -> str:
        """Text of a node's position as a tuple of three, from its number."""
        if self.composition.stored_operator:
            return "(" + ", ".join([f"X_nodes[{index}, {a}]" for a in range(self.dim)] + ["zero"] * (3 - self.dim)) + ")"
        parts, rest = [], index
        for a in range(self.dim):
            lower = self.along("lower", a)
            h = self.along("h", a)
            ghosts = self.parameter("ghosts", lambda roles: roles["ghosts"])
            parts.append(f"{lower} + (T(({rest}) // lat[{3 + a}]) - {ghosts}) * {h}")
            rest = f"({rest}) % lat[{3 + a}]"
        return f"({', '.join(parts + ['zero'] * (3 - self.dim))})"

    def body(self, name: str, doc: str, arguments: str, header: list[str], lines: list[str], tail: list[str] = []) -> str:  # noqa: B006
        text = ["@compiled", f"def {name}({arguments}, par, lat, work, t, dt):", f'    """{doc}"""', *self.parameter_lines()]
        return (
            "\n".join(
                [*text, *(f"    {line}" for line in header), *(f"        {line}" for line in lines), *(f"    {line}" for line in tail)]
            )
            + "\n"
        )

    def smallest_mass(self) -> str:
        return self.parameter("m_small", lambda roles: roles["m_small"])


def momentum(sweep: Sweep, has_velocity: bool, name: str) -> str:
    """v_i^old = (mv)_i / m_i and v_i = v_i^old + dt (f_i / m_i + accelerations)."""
    c, layout, dim = sweep.composition, sweep.layout, sweep.dim
    small = sweep.smallest_mass()
    lines = [f"k = i * {layout.size}", f"m = {node(layout, 'm')}", f"if m > {small}:"]
    inner = []
    if not has_velocity:
        inner += [f"{node(layout, 'v_old', a)} /= m" for a in range(dim)]
    inner.append(f"v_old = {vector(layout, 'v_old', dim)}")
    acceleration = [f"{node(layout, 'v', a)} / m" for a in range(dim)]
    accounts = []
    for role, effect in c.effects.items():
        if effect.acceleration is None:
            continue
        special = {"v": "v_old"}
        if "x" in effect.acceleration.arguments or any("x" in _value_arguments(effect, n, c.dim) for n in effect.acceleration.arguments):
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
    lines += [f"    {node(layout, channel, a)} = zero" for channel in ("v_old", "v") for a in range(dim)]
    header = [
        "external, effects = 0.0, 0.0",
        *([f"push{a} = 0.0" for a in range(dim)] if pushes else []),
        "for i in range(span[0], span[1]):",
    ]
    tail = ["work[0] += external", "work[1] += effects", *([f"work[{FORCE + a}] += push{a}" for a in range(dim)])] if pushes else []
    if not pushes:
        header = header[-1:]
    return sweep.body(name, "Nodes: v_i = (mv)_i / m_i, v_i += dt (f_i / m_i + accelerations).", _grid_arguments(c), header, lines, tail)


def divide(sweep: Sweep, channel: str, name: str, doc: str) -> str:
    """Momentum to velocity in one channel."""
    layout, dim = sweep.layout, sweep.dim
    small = sweep.smallest_mass()
    lines = [f"k = i * {layout.size}", f"m = {node(layout, 'm')}", f"if m > {small}:"]
    lines += [f"    {node(layout, channel, a)} /= m" for a in range(dim)]
    lines += ["else:"] + [f"    {node(layout, channel, a)} = zero" for a in range(dim)]
    return sweep.body(name, doc, _grid_arguments(sweep.composition), ["for i in range(span[0], span[1]):"], lines)


def limit(sweep: Sweep, name: str) -> str:
    """Velocities for the strain, with the change limited where the nodal mass is below a fraction of a particle's."""
    layout, dim = sweep.layout, sweep.dim
    m_limit = sweep.parameter("m_limit", lambda roles: roles["m_limit"])
    lines = [f"k = i * {layout.size}", f"share = min(one, {node(layout, 'm')} / {m_limit})"]
    lines += [f"{node(layout, 'v_map', a)} = {limited(layout, a)}" for a in range(dim)]
    doc = "Nodes: velocities for the strain, limited where there is little mass."
    return sweep.body(name, doc, _grid_arguments(sweep.composition), ["for i in range(span[0], span[1]):"], lines)


def carry(sweep: Sweep, name: str) -> str:
    """Nodes keep their velocity: v_old = v, f = 0."""
    layout, dim = sweep.layout, sweep.dim
    lines = [f"k = i * {layout.size}"]
    for a in range(dim):
        lines += [f"{node(layout, 'v_old', a)} = {node(layout, 'v', a)}", f"{node(layout, 'v', a)} = zero"]
        if "f_ext" in layout.start:
            lines.append(f"{node(layout, 'f_ext', a)} = zero")
    return sweep.body(
        name,
        "Nodes carry their velocity: v_old = v, f = 0.",
        _grid_arguments(sweep.composition),
        ["for i in range(span[0], span[1]):"],
        lines,
    )


def boundary(sweep: Sweep, role: str, channel: str, on_old: bool, name: str) -> str:
    """One boundary layer on its list of nodes: constrain (and rub) the velocities of `channel`; keep its account if it is ``v``."""
    c, layout, dim = sweep.composition, sweep.layout, sweep.dim
    layer = c.layers[role]
    assert layer.constrain is not None
    small = sweep.smallest_mass()
    lines = ["i = nodes[j]", f"k = i * {layout.size}", f"m = {node(layout, 'm')}", f"if m > {small}:"]
    special = {"normal": "(normals[j, 0], normals[j, 1], normals[j, 2])"}
    inner = []
    hooks = [kernel for kernel in (layer.constrain, layer.hold, layer.rub) if kernel is not None]
    accelerations = [effect for effect in c.effects.values() if effect.acceleration is not None and channel == "v"]
    if any("x" in _needs(layer, k, dim) for k in hooks) or any("x" in _needs(e, e.acceleration, dim) for e in accelerations):
        inner.append(f"x = {sweep.position('i')}")
        special["x"] = "x"

    def constrained(source: str) -> str:
        assert layer.constrain is not None
        return sweep.call("constrain", layer.constrain, role, None, special | {"v": source})

    def held(source: str) -> str:
        assert layer.hold is not None
        return sweep.call("hold", layer.hold, role, None, special | {"v": source})

    def rubbed(before: str) -> list[str]:
        """Friction on ``new``, by the normal impulse that the particles feel."""
        if layer.rub is None:
            return []
        # with FLIP, what the condition took from v_old presses on nothing
        text = ["n = " + special["normal"], "dv_n = -(" + " + ".join(f"reaction{a} * n[{a}]" for a in range(dim)) + ") / m"]
        text.append(f"rubbed = {sweep.call('rub', layer.rub, role, None, special | {'v': 'new', 'dv_n': 'dv_n'})}")
        text += [f"drag{a} = m * (rubbed[{a}] - new[{a}])" for a in range(dim)]
        # The slip is that of the particles around the node, not the node's own, which may creep while they rest.
        text.append("friction -= " + " + ".join(f"drag{a} * T(2) * {before}[{a}]" for a in range(dim)))
        return text + [f"reaction{a} += drag{a}" for a in range(dim)] + ["new = rubbed"]

    if channel == "v":
        inner += [f"raw = {vector(layout, 'v_old', dim)}"]
        if on_old and layer.hold is None:
            inner += [f"old = {constrained('raw')}", *assign(layout, "v_old", dim, "old")]
        else:
            inner += ["old = raw"]
        inner += [f"trial = {vector(layout, 'v', dim)}", f"new = {constrained('trial')}"]
        if layer.hold is not None:
            # Decided once, by the trial velocity: a wall that stops a node after letting it go before would do work on it.
            inner += [
                "if new != trial:",
                f"    old, new = {held('raw')}, {held('trial')}",
                *assign(layout, "v_old", dim, "old"),
            ]
        # Reaction: what the particles gain beyond the forces. FLIP takes up v - v_old, PIC all of v, so the part of the
        # momentum that the condition on v_old removed counts for the share of PIC only.
        share = sweep.parameter("flip_share", lambda roles: flip_share(roles.get("transfer")))
        inner += [f"reaction{a} = m * (new[{a}] - trial[{a}] - {share} * (old[{a}] - raw[{a}]))" for a in range(dim)]
        inner.append("boundary += " + " + ".join(f"reaction{a} * (new[{a}] + old[{a}])" for a in range(dim)))
        inner += rubbed("old")
        # the momentum update took the work of accelerations with velocities that this layer has just changed
        for effect_role, effect in c.effects.items():
            if effect in accelerations and effect.acceleration is not None:
                call = sweep.call(
                    "acceleration", effect.acceleration, effect_role, None, {"v": "raw"} | {k: v for k, v in special.items() if k == "x"}
                )
                inner.append(f"{effect_role}_a = {call}")
                change = " + ".join(f"{effect_role}_a[{a}] * (trial[{a}] - new[{a}] + raw[{a}] - old[{a}])" for a in range(dim))
                sign, account_of = ("+", "effects") if effect.work == "dissipated" else ("-", "external")
                inner.append(f"{account_of} {sign}= m * dt * ({change})")
        inner += [f"impulse{a} += reaction{a}" for a in range(dim)]
        inner += assign(layout, "v", dim, "new")
    elif channel == "v_old":
        # Before the strain. The particles feel it as far as their new velocities contain the old ones of the grid.
        inner += [f"raw = {vector(layout, 'v_old', dim)}", f"new = {constrained('raw')}"]
        if layer.hold is not None:
            inner += ["if new != raw:", f"    new = {held('raw')}"]
        felt = sweep.parameter("grid_share", lambda roles: grid_share(roles.get("transfer")))
        inner += [f"reaction{a} = {felt} * m * (new[{a}] - raw[{a}])" for a in range(dim)]
        inner.append("boundary += " + " + ".join(f"reaction{a} * (new[{a}] + raw[{a}])" for a in range(dim)))
        inner += rubbed("raw")
        inner += [f"impulse{a} += reaction{a}" for a in range(dim)]
        inner += assign(layout, "v_old", dim, "new")
    else:
        inner.append(f"new = {constrained(vector(layout, channel, dim))}")
        if layer.hold is not None:
            inner += [f"now = {vector(layout, 'v', dim)}", f"if {held('now')} == now:", f"    new = {held(vector(layout, channel, dim))}"]
        if channel == "v_smooth":
            inner += [f"impulse{a} += m * (new[{a}] - {node(layout, channel, a)})" for a in range(dim)]
        inner += assign(layout, channel, dim, "new")
    lines += [f"    {line}" for line in inner]
    account = channel in ("v", "v_old")
    header = ["boundary, friction = 0.0, 0.0"] if account else []
    tail = ["work[2] += 0.5 * boundary", "work[3] += 0.5 * friction"] if account else []
    if accelerations:
        header.append("external, effects = 0.0, 0.0")
        tail += ["work[0] += 0.5 * external", "work[1] += 0.5 * effects"]
    if account or channel == "v_smooth":
        header += [f"impulse{a} = 0.0" for a in range(dim)]
        tail += [f"work[{IMPULSE + a}] += impulse{a}" for a in range(dim)]
    doc = f"Nodes: {layer.summary()} ({channel})"
    return sweep.body(name, doc.replace('"', "'"), _list_arguments(c), [*header, "for j in range(nodes.size):"], lines, tail)


def grid_share(transfer: object) -> float:
    """How much of the particle velocity comes from the velocity of the grid before the update (0 for FLIP, 1 for PIC, APIC and XPIC)."""
    return _response(transfer, {"v": 0.0, "v_grid": 1.0, "dv_grid": 0.0, "v_smooth": 1.0}) if transfer is not None else 0.0


def flip_share(transfer: object) -> float:
    """How much of the particle velocity comes from the change of the grid velocity (1 for FLIP and XPIC, 0 for PIC and APIC)."""
    if transfer is None:
        return 0.0
    return 1.0 - _response(transfer, {"v": 0.0, "v_grid": 1.0, "dv_grid": 0.0, "v_smooth": 0.0})


def _response(transfer: Any, given: dict[str, float]) -> float:
    """What the transfer makes of these velocities; it is linear in them."""
    return float(transfer.velocity(*(given[n] if n in given else float(getattr(transfer, n)) for n in transfer.velocity.arguments)))


def load(loop: ParticleLoop, layout: NodeLayout, operator: object, role: str, name: str) -> str:
    """Scatter the loads of a layer of particles: f_i += force (N_i + arm . grad N_i)."""
    c, dim = loop.composition, loop.dim
    layer = c.layers[role]
    assert layer.load is not None
    loop.needs |= {"w", "g"}
    for field in ("x", "size", "size_now", "F"):
        if field == "x" or (c.shape is not None and field in loop.group.layout.fields):
            loop.field(field)
    special = {
        "area": "area[j]",
        "normal": "(normals[j, 0], normals[j, 1], normals[j, 2])",
        "arm0": "(arms[j, 0], arms[j, 1], arms[j, 2])",
    }
    call = loop.call("load", layer.load, role, loop.group, special)
    loop.line(f"force, arm = {call}")
    factor = "w" + "".join(f" + arm[{b}] * g{b}" for b in range(dim))
    loop.scatter.append(f"s = {factor}")
    for a in range(dim):
        loop.scatter += [f"{node(layout, 'v', a)} += s * force[{a}]", f"{node(layout, 'f_ext', a)} += s * force[{a}]"]
    from mpmkit._core.composing.writer import particle_function

    return particle_function(loop, layout, operator, name, f"Loads of {layer.summary()}", chosen=True)


CONTACT = '''@compiled
def find_shared(A, B, span_a, span_b, found, slot, par):
    """Nodes that both bodies reach; their number, the list in `found`, the place in the list in `slot`."""
    m_small = par[{m_small}]
    count = 0
    for i in range(max(span_a[0], span_b[0]), min(span_a[1], span_b[1])):
        k = i * {C}
        if A[k] > m_small and B[k] > m_small:
            if count == found.size:
                return -1
            found[count] = i
            slot[i] = count
            count += 1
    return count


@compiled
def contact_normals(A, B, found, count, normals, reach_a, reach_b):
    """Candidates for the unit normal from body a to body b: the mean of both outward volume gradients, that of a, that of b."""
    for s in range(count):
        k = found[s] * {C}
        a0, a1, a2 = {outward_a}
        b0, b1, b2 = {outward_b}
        candidates = ((a0 - b0, a1 - b1, a2 - b2), (a0, a1, a2), (-b0, -b1, -b2))
        for c in range(3):
            n = candidates[c]
            size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
            inverse_size = one / size if size > zero else zero
            normals[s, c, 0], normals[s, c, 1], normals[s, c, 2] = n[0] * inverse_size, n[1] * inverse_size, n[2] * inverse_size
            reach_a[s, c], reach_b[s, c] = T(-1e30), T(1e30)


@compiled
def choose_normals(count, normals, reach_a, reach_b, margin):
    """The candidate along which the bodies are farthest apart, if that is more than `margin` better than the mean.

    Convex bodies are as far apart as along the best of all directions. At the edge of a body on a flat face the mean
    is oblique, and along it the face overlaps the body; the normal of the face itself is the better one.
    """
    for s in range(count):
        best = 0
        for c in range(1, 3):
            if reach_b[s, c] - reach_a[s, c] > reach_b[s, best] - reach_a[s, best] + margin:
                best = c
        for a in range(3):
            normals[s, 0, a] = normals[s, best, a]
        reach_a[s, 0], reach_b[s, 0] = reach_a[s, best], reach_b[s, best]


@compiled
def clear_shared(found, count, slot):
    for s in range(count):
        slot[found[s]] = -1
'''


def contact_functions(sweep: Sweep, channels: list[str]) -> str:
    """Shared nodes, normals and the impulses of the contact algorithm on each velocity channel."""
    c, layout, dim = sweep.composition, sweep.layout, sweep.dim
    assert c.contact is not None
    small = sweep.parameters.slot("m_small", lambda roles: roles["m_small"])
    o = layout.start["outward"]
    outward = {f"outward_{n.lower()}": ", ".join([f"{n}[k + {o + a}]" for a in range(dim)] + ["zero"] * (3 - dim)) for n in "AB"}
    texts = [CONTACT.format(C=layout.size, m_small=small, **outward)]
    for channel in channels:
        text = Sweep(c, sweep.parameters, sweep.names, layout)
        at = layout.start[channel]

        def both(body: str, at: int = at) -> str:
            return "(" + ", ".join([f"{body}[k + {at + a}]" for a in range(dim)] + ["zero"] * (3 - dim)) + ")"

        special = {"m_a": "A[k]", "m_b": "B[k]", "v_a": "v_a", "v_b": "v_b", "normal": "n", "gap": "reach_b[s, 0] - reach_a[s, 0]"}
        call = text.call("impulse", c.contact.impulse, "contact", None, special)
        lines = [
            f"k = found[s] * {layout.size}",
            f"v_a, v_b = {both('A')}, {both('B')}",
            "n = (normals[s, 0, 0], normals[s, 0, 1], normals[s, 0, 2])",
            f"impulse = {call}",
        ]
        if channel == "v":
            # What slides is rubbed away. The slip is that of the particles around the node (v_old): a node with little
            # mass may move faster than any of them. The normal part only passes momentum on.
            old = layout.start["v_old"]
            slip = " + ".join(f"(impulse[{a}] + press[s] * n[{a}]) * (A[k + {old + a}] - B[k + {old + a}])" for a in range(dim))
            lines += ["press[s] = -(impulse[0] * n[0] + impulse[1] * n[1] + impulse[2] * n[2])", f"rubbed -= {slip}"]
        if channel == "v_map":
            # Where contact has acted in the momentum update the strain must see the bodies move together, else the
            # stress that presses them apart would do work without being relieved.
            lines += [
                "u_n = " + " + ".join(f"(v_a[{a}] - v_b[{a}]) * n[{a}]" for a in range(dim)),
                "if press[s] > zero and u_n < zero:",
                "    J = -u_n * A[k] * B[k] / (A[k] + B[k])",
                "    impulse = (J * n[0], J * n[1], J * n[2])",
            ]
        lines += [f"A[k + {at + a}] += impulse[{a}] / A[k]" for a in range(dim)]
        lines += [f"B[k + {at + a}] -= impulse[{a}] / B[k]" for a in range(dim)]
        texts.append(
            text.body(
                f"contact_{channel}",
                f"Contact impulses at shared nodes, equal and opposite, on the channel {channel}.",
                "A, B, found, count, normals, reach_a, reach_b, press",
                [*(["rubbed = 0.0"] if channel == "v" else []), "for s in range(count):"],
                lines,
                ["work[3] += rubbed"] if channel == "v" else [],
            )
        )
    return "\n\n".join(texts)


def reach_function(loop: ParticleLoop, layout: NodeLayout, operator: GridOperator, name: str) -> str:
    """Farthest reach of a body along the normal at each shared node: max of side (x_p - x_i) . n + half a particle."""
    dim = loop.dim
    loop.needs |= {"w", "r"}
    for field in ("x", "V", "size", "size_now", "F"):
        if field in ("x", "V") or field in loop.group.layout.fields:
            loop.field(field)
    loop.line(
        f"half = T(0.5) * V ** T({1.0 / dim!r})"
        if loop.composition.grid.space != "axisymmetric"
        else "half = T(0.5) * sqrt(V / (T(6.283185307179586) * x[0]))"
    )
    distance = " + ".join(f"r{b} * normals[s, c, {b}]" for b in range(dim))
    loop.scatter += [
        f"s = slot[k // {layout.size}]",
        "if s >= 0 and w > zero:",
        "    for c in range(3):",
        f"        d = side * ({distance})  # from particle to node along the normal of this side",
        "        reach[s, c] = side * max(side * reach[s, c], half - d)",
    ]
    from mpmkit._core.composing.writer import particle_function

    return particle_function(
        loop, layout, operator, name, "How far this body reaches along the contact normals.", extra="slot, normals, reach, side, "
    )


def _grid_arguments(c: Composition) -> str:
    return "G, span, X_nodes" if c.stored_operator else "G, span"


def _list_arguments(c: Composition) -> str:
    return "G, nodes, normals, X_nodes" if c.stored_operator else "G, nodes, normals"


def _needs(component: object, kernel: object, dim: int) -> set[str]:
    arguments = set(kernel.arguments)  # type: ignore[attr-defined]
    for name in list(arguments):
        arguments |= set(_value_arguments(component, name, dim))
    return arguments


def _value_arguments(component: object, name: str, dim: int) -> tuple[str, ...]:
    """Arguments of the user's function behind a `Value` parameter; empty if it is a constant or no such parameter."""
    if name not in getattr(component, "values", ()):
        return ()
    from mpmkit.expression import as_function

    made = as_function(getattr(component, name), dim)
    return made.__code__.co_varnames[: made.__code__.co_argcount] if callable(made) else ()


def filter_start(sweep: Sweep) -> str:
    """XPIC: the filtered velocity starts as order times v_old."""
    layout, dim = sweep.layout, sweep.dim
    lines = [f"k = i * {layout.size}"]
    for a in range(dim):
        old = node(layout, "v_old", a)
        lines += [
            f"{node(layout, 'u', a)} = {old}",
            f"{node(layout, 'v_smooth', a)} = weight * {old}",
            f"{node(layout, 'u_next', a)} = zero",
        ]
    header = ["for i in range(span[0], span[1]):"]
    return sweep.body(
        "filter_start", "Nodes: start of the filtered velocity of XPIC.", _grid_arguments(sweep.composition) + ", weight", header, lines
    )


def filter_add(sweep: Sweep) -> str:
    """XPIC: u_i = (sum_p m_p N_i u_p) / m_i and v_smooth += weight u."""
    layout, dim = sweep.layout, sweep.dim
    small = sweep.smallest_mass()
    lines = [f"k = i * {layout.size}", f"m = {node(layout, 'm')}", f"if m > {small}:"]
    for a in range(dim):
        u, u_next = node(layout, "u", a), node(layout, "u_next", a)
        lines += [f"    {u} = {u_next} / m", f"    {node(layout, 'v_smooth', a)} += weight * {u}", f"    {u_next} = zero"]
    header = ["for i in range(span[0], span[1]):"]
    return sweep.body(
        "filter_add", "Nodes: one term of the filtered velocity of XPIC.", _grid_arguments(sweep.composition) + ", weight", header, lines
    )
