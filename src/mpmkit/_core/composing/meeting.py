"""Text of contact: shared nodes, normals, gaps, and the impulses of a contact algorithm."""

from __future__ import annotations

from mpmkit._core.composing.layout import NodeLayout
from mpmkit._core.composing.operators import GridOperator
from mpmkit._core.composing.source import ParticleLoop
from mpmkit._core.composing.sweep import Sweep
from mpmkit._core.composing.writer import particle_function

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

    return particle_function(
        loop, layout, operator, name, "How far this body reaches along the contact normals.", extra="slot, normals, reach, side, "
    )
