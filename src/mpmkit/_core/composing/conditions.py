"""Text of boundary layers: conditions on lists of nodes, loads of layers of particles."""

from __future__ import annotations

from typing import Any

from mpmkit._core.composing.layout import LANES
from mpmkit._core.composing.operators import StoredOperator
from mpmkit._core.composing.source import ParticleLoop
from mpmkit._core.composing.sweep import IMPULSE, Sweep, assign, needs_of, node, vector


def boundary(sweep: Sweep, role: str, channel: str, on_old: bool, name: str) -> str:
    """One boundary layer on its list of nodes: constrain (and rub) the velocities of `channel`.

    Work and impulses are accounted for on ``v`` and ``v_old``, impulses also on the filtered ``u`` and ``v_smooth``; ``v_map``, which only
    the strain sees, has no account. ``held`` is what the layer remembers of its nodes (`Composition.remembers`).
    """
    c, layout, dim = sweep.composition, sweep.layout, sweep.dim
    layer = c.layers[role]
    assert layer.constrain is not None
    small = sweep.smallest_mass()
    lines = ["i = nodes[j]", f"k = i * {layout.size}", f"m = {node(layout, 'm')}", f"if m > {small}:"]
    special = {"normal": "(normals[j, 0], normals[j, 1], normals[j, 2])"}
    inner = []
    remembers, filtered = c.remembers(layer) and channel in ("v", "v_old"), channel in ("u", "v_smooth")
    hooks = [kernel for kernel in (layer.constrain, layer.hold, layer.rub) if kernel is not None]
    accelerations = [effect for effect in c.effects.values() if effect.acceleration is not None and channel == "v"]
    if any("x" in needs_of(layer, k, dim) for k in hooks) or any("x" in needs_of(e, e.acceleration, dim) for e in accelerations):
        inner.append(f"x = {sweep.position('i')}")
        special["x"] = "x"

    def constrained(source: str) -> str:
        assert layer.constrain is not None
        return sweep.call("constrain", layer.constrain, role, None, special | {"v": source})

    def held(source: str) -> str:
        assert layer.hold is not None
        return sweep.call("hold", layer.hold, role, None, special | {"v": source})

    def rubbed(before: str, pressed: list[str]) -> list[str]:
        """Friction on ``new``, by the change of velocity with which the layer presses on the particles."""
        if layer.rub is None:
            return []
        text = ["n = " + special["normal"], "dv_n = -(" + " + ".join(f"({pressed[a]}) * n[{a}]" for a in range(dim)) + ")"]
        text.append(f"rubbed = {sweep.call('rub', layer.rub, role, None, special | {'v': 'new', 'dv_n': 'dv_n'})}")
        text += [f"drag{a} = m * (rubbed[{a}] - new[{a}])" for a in range(dim)]
        # The slip is that of the particles around the node, not the node's own, which may creep while they rest.
        text.append("friction -= " + " + ".join(f"drag{a} * T(2) * {before}[{a}]" for a in range(dim)))
        return text + [f"reaction{a} += drag{a}" for a in range(dim)] + ["new = rubbed"]

    def work_taken_back(changes: dict[str, str]) -> list[str]:
        """The momentum update took the work of accelerations with velocities that this layer has just changed (from: to)."""
        text = []
        for effect_role, effect in c.effects.items():
            if effect in accelerations and effect.acceleration is not None:
                given = {"v": next(iter(changes))} | {k: v for k, v in special.items() if k == "x"}
                text.append(f"{effect_role}_a = {sweep.call('acceleration', effect.acceleration, effect_role, None, given)}")
                lost = [" + ".join(f"{was}[{a}] - {now}[{a}]" for was, now in changes.items()) for a in range(dim)]
                change = " + ".join(f"{effect_role}_a[{a}] * ({lost[a]})" for a in range(dim))
                sign, account_of = ("+", "effects") if effect.work == "dissipated" else ("-", "external")
                text.append(f"{account_of} {sign}= m * dt * ({change})")
        return text

    if channel == "v" and c.merges:
        # What nodes press on is all that the particles take up: there is no velocity before the update.
        inner += [f"trial = {vector(layout, 'v', dim)}", f"new = {constrained('trial')}"]
        if layer.hold is not None:
            inner += ["if new != trial:", f"    new = {held('trial')}"]
        inner += [f"reaction{a} = m * (new[{a}] - trial[{a}])" for a in range(dim)]
        inner.append("boundary += T(2) * (" + " + ".join(f"reaction{a} * new[{a}]" for a in range(dim)) + ")")
        # Of the mean of the velocities before and after, only the latter: those before add up to the particles' momentum with
        # the internal forces of all nodes, the held ones too, and of no part of them.
        inner += work_taken_back({"trial": "new"})
        inner += [f"impulse{a} += reaction{a}" for a in range(dim)]
        inner += assign(layout, "v", dim, "new")
    elif channel == "v":
        inner += [f"raw = {vector(layout, 'v_old', dim)}"]
        if on_old and layer.hold is None:
            inner += [f"old = {constrained('raw')}", *assign(layout, "v_old", dim, "old")]
        else:
            inner += ["old = raw"]
        inner += [f"trial = {vector(layout, 'v', dim)}", f"new = {constrained('trial')}"]
        if remembers:
            inner.append("held[j] = new != trial")
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
        # with FLIP, what the condition took from v_old presses on nothing; with XPIC most of it comes back in the filter
        press = sweep.parameter("press_share", lambda roles: press_share(roles.get("transfer"))) if layer.rub is not None else ""
        inner += rubbed("old", [f"new[{a}] - trial[{a}] - {press} * (old[{a}] - raw[{a}])" for a in range(dim)])
        inner += work_taken_back({"raw": "old", "trial": "new"})
        inner += [f"impulse{a} += reaction{a}" for a in range(dim)]
        inner += assign(layout, "v", dim, "new")
    elif channel == "v_old":
        # Before the strain. The particles feel it as far as their new velocities contain the old ones of the grid.
        inner.append(f"raw = {vector(layout, 'v_old', dim)}")
        if remembers:
            inner += ["new = raw", "if held[j]:", f"    new = {held('raw')}"]
        else:
            inner.append(f"new = {constrained('raw')}")
        felt = sweep.parameter("grid_share", lambda roles: grid_share(roles.get("transfer")))
        inner += [f"reaction{a} = {felt} * m * (new[{a}] - raw[{a}])" for a in range(dim)]
        # A layer does work with the velocity it prescribes; what the particles' mean loses beside that is lost by the transfer.
        inner.append("boundary += T(2) * (" + " + ".join(f"reaction{a} * new[{a}]" for a in range(dim)) + ")")
        inner += rubbed("raw", [f"{felt} * (new[{a}] - raw[{a}])" for a in range(dim)])
        inner += [f"impulse{a} += reaction{a}" for a in range(dim)]
        inner += assign(layout, "v_old", dim, "new")
    else:
        given = vector(layout, channel, dim)
        # what is filtered is the velocity before the update, which a layer that has let go does not touch
        inner.append(f"new = {given if filtered and layer.hold is not None else constrained(given)}")
        if layer.hold is not None:
            inner += [f"now = {vector(layout, 'v', dim)}", f"if {held('now')} == now:", f"    new = {held(given)}"]
        if filtered:
            inner += [f"impulse{a} += weight * m * (new[{a}] - {node(layout, channel, a)})" for a in range(dim)]
        inner += assign(layout, channel, dim, "new")
    lines += [f"    {line}" for line in inner]
    if remembers and channel == "v":
        lines += ["else:", "    held[j] = False"]
    account = channel in ("v", "v_old")
    header = ["boundary, friction = 0.0, 0.0"] if account else []
    tail = ["work[2] += 0.5 * boundary", "work[3] += 0.5 * friction"] if account else []
    if accelerations:
        header.append("external, effects = 0.0, 0.0")
        tail += ["work[0] += 0.5 * external", "work[1] += 0.5 * effects"]
    if account or filtered:
        header += [f"impulse{a} = 0.0" for a in range(dim)]
        tail += [f"work[{IMPULSE + a}] += impulse{a}" for a in range(dim)]
    doc = f"Nodes: {layer.summary()} ({channel})"
    arguments = "G, nodes, normals" + ", held" * remembers + ", weight" * filtered
    return sweep.over_list(name, doc.replace('"', "'"), arguments, [*header, "for j in range(nodes.size):"], lines, tail)


def grid_share(transfer: object) -> float:
    """How much of the particle velocity comes from the velocity of the grid before the update (0 for FLIP, 1 for PIC, APIC and XPIC)."""
    return _response(transfer, {"v": 0.0, "v_grid": 1.0, "dv_grid": 0.0, "v_smooth": 1.0}) if transfer is not None else 0.0


def flip_share(transfer: object) -> float:
    """How much of the velocity of the grid before the update the particle velocity does not contain (1 for FLIP, 0 for PIC, APIC, XPIC)."""
    if transfer is None:
        return 0.0
    return -_response(transfer, {"v": 0.0, "v_grid": 0.0, "dv_grid": -1.0, "v_smooth": 1.0})


def press_share(transfer: object) -> float:
    """How much of the particle velocity comes from the change of the grid velocity (1 for FLIP and XPIC, 0 for PIC and APIC)."""
    return 1.0 - _response(transfer, {"v": 0.0, "v_grid": 1.0, "dv_grid": 0.0, "v_smooth": 0.0}) if transfer is not None else 0.0


def _response(transfer: Any, given: dict[str, float]) -> float:
    """What the transfer makes of these velocities; it is linear in them."""
    return float(transfer.velocity(*(given[n] if n in given else float(getattr(transfer, n)) for n in transfer.velocity.arguments)))


def load(loop: ParticleLoop, operator: Any, role: str, name: str) -> str:
    """Scatter the loads of a layer of particles: f_i += force (N_i + arm . grad N_i), one particle after the other."""
    c, dim, layout = loop.composition, loop.dim, loop.nodes
    layer = c.layers[role]
    assert layer.load is not None
    special = {
        "area": "area[j]",
        "normal": "(normals[j, 0], normals[j, 1], normals[j, 2])",
        "arm0": "(arms[j, 0], arms[j, 1], arms[j, 2])",
    }
    call = loop.call("load", layer.load, role, loop.group, special)
    visit = ["f_" + "xyz"[a] + f" = force[{a}]" for a in range(dim)]
    factor = "w" + "".join(f" + arm[{b}] * g{b}" for b in range(dim))
    if isinstance(operator, StoredOperator):
        header, pad = operator.points({"w", "g"}, layout), "    "
        arguments, scratch = "chosen, P, nodes, N, dN, G, par", ""
        weights: list[str] = []
    else:
        for a in range(dim):
            loop.along("h", a), loop.along("inv_h", a)
        loop.asks_slopes = True
        header, pad = operator.nodes_loop(layout)
        header.append(f"{pad}k = i * {layout.size}")
        arguments, scratch = "chosen, P, blocks, corner, home, edge, G, par", ", sc, ib"
        weights = ["block = blocks[j]", *(line.replace("l0, l1", "l, l + 1") for line in operator.prepare(loop))]
    add = [f"s = {factor}"]
    for a, one in enumerate("xyz"[:dim]):
        add += [f"{node(layout, 'v', a)} += s * f_{one}", f"{node(layout, 'f_ext', a)} += s * f_{one}"]
    lines = ["p = chosen[j]", "tile, l = p >> 4, p & 15", f"b = tile * {loop.group.layout.size * LANES}", *weights, *loop.lines]
    lines += [f"force, arm = {call}", *visit, *header, *(f"{pad}{line}" for line in add)]
    doc = f"Loads of {layer.summary()}".replace('"', "'")
    text = ["@compiled", f"def {name}({arguments}, area, normals, arms{scratch}, t, dt):", f'    """{doc}."""', *loop.parameter_lines()]
    return "\n".join([*text, "    for j in range(chosen.size):", *(f"        {line}" for line in lines)]) + "\n"
