"""Text of contact: shared nodes, normals, gaps, and the impulses of a contact algorithm."""

from __future__ import annotations

from mpmkit._core.composing.operators import GridOperator
from mpmkit._core.composing.source import ParticleLoop
from mpmkit._core.composing.sweep import Sweep
from mpmkit._core.composing.writer import each_particle

CONTACT = '''@compiled
def find_shared(A, B, both, found, par):
    """Nodes that both bodies reach, among the blocks of nodes that both have: their numbers in either field."""
    m_small = par[{m_small}]
    count = 0
    for pair in range(both.shape[0]):
        a, b = both[pair, 0], both[pair, 1]
        for r in range({N}):
            i, j = a * {N} + r, b * {N} + r
            if A[U(i * {C} + {m})] > m_small and B[U(j * {C} + {m})] > m_small:
                if count == found.shape[0]:
                    return -1
                found[count, 0], found[count, 1] = i, j
                count += 1
    return count


@compiled
def contact_normals(A, B, found, count, normals, reach_a, reach_b):
    """Candidates for the unit normal from body a to body b: the mean of both outward volume gradients, that of a, that of b."""
    for s in range(count):
        i, j = found[s, 0] * {C}, found[s, 1] * {C}
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
def mark_shared(found, count, slot_a, slot_b, touched_a, touched_b):
    """Set the marks of nodes that were found before."""
    for s in range(count):
        slot_a[found[s, 0]], slot_b[found[s, 1]] = s, s
        touched_a[found[s, 0] // {N}], touched_b[found[s, 1] // {N}] = 1, 1


@compiled
def clear_shared(found, count, slot_a, slot_b, touched_a, touched_b):
    """Take back all marks."""
    for s in range(count):
        slot_a[found[s, 0]], slot_b[found[s, 1]] = -1, -1
        touched_a[found[s, 0] // {N}], touched_b[found[s, 1] // {N}] = 0, 0


@compiled
def near_shared(home, count, around, touched, near):
    """Mark the blocks of particles that reach a block of nodes with shared ones."""
    for block in range(count):
        for q in range(around):
            if touched[home[around * block + q]]:
                near[block] = 1
'''


def contact_functions(sweep: Sweep, channel: str) -> dict[str, str]:
    """Shared nodes, normals, and the impulses of the contact algorithm on a velocity channel, by name."""
    c, layout, dim = sweep.composition, sweep.layout, sweep.dim
    assert c.contact is not None
    small = sweep.parameters.slot("m_small", lambda roles: roles["m_small"])
    o, m = layout.start["outward"], layout.start["m"]
    outward = {
        f"outward_{n.lower()}": ", ".join([f"{n}[U({k} + {o + a})]" for a in range(dim)] + ["zero"] * (3 - dim)) for n, k in ("Ai", "Bj")
    }
    shared = CONTACT.format(C=layout.size, N=sweep.per_block, m=m, m_small=small, **outward)
    at = layout.start[channel]

    def of(body: str, k: str, a: int, first: int = at) -> str:
        return f"{body}[U({k} + {first + a})]"

    def vector(body: str, k: str) -> str:
        return "(" + ", ".join([of(body, k, a) for a in range(dim)] + ["zero"] * (3 - dim)) + ")"

    special = {"m_a": "m_a", "m_b": "m_b", "v_a": "v_a", "v_b": "v_b", "normal": "n", "gap": "reach_b[s, 0] - reach_a[s, 0]"}
    lines = [
        f"i, j = found[s, 0] * {layout.size}, found[s, 1] * {layout.size}",
        f"m_a, m_b = A[U(i + {m})], B[U(j + {m})]",
        f"v_a, v_b = {vector('A', 'i')}, {vector('B', 'j')}",
        "n = (normals[s, 0, 0], normals[s, 0, 1], normals[s, 0, 2])",
        f"impulse = {sweep.call('impulse', c.contact.impulse, 'contact', None, special)}",
    ]
    if channel == "v":
        # What slides is rubbed away. The slip is that of the particles around the node (v_old): a node with little
        # mass may move faster than any of them. The normal part only passes momentum on.
        old = layout.start["v_old"]
        slip = " + ".join(f"(impulse[{a}] + press[s] * n[{a}]) * ({of('A', 'i', a, old)} - {of('B', 'j', a, old)})" for a in range(dim))
        lines += ["press[s] = -(impulse[0] * n[0] + impulse[1] * n[1] + impulse[2] * n[2])", f"rubbed -= {slip}"]
    if channel == "v_map":
        # Where contact has acted in the momentum update the strain must see the bodies move together, else the
        # stress that presses them apart would do work without being relieved.
        lines += [
            "u_n = " + " + ".join(f"(v_a[{a}] - v_b[{a}]) * n[{a}]" for a in range(dim)),
            "if press[s] > zero and u_n < zero:",
            "    J = -u_n * m_a * m_b / (m_a + m_b)",
            "    impulse = (J * n[0], J * n[1], J * n[2])",
        ]
    lines += [f"{of('A', 'i', a)} += impulse[{a}] / m_a" for a in range(dim)]
    lines += [f"{of('B', 'j', a)} -= impulse[{a}] / m_b" for a in range(dim)]
    text = sweep.over_list(
        f"contact_{channel}",
        f"Contact impulses at shared nodes, equal and opposite, on the channel {channel}.",
        "A, B, found, count, normals, reach_a, reach_b, press",
        [*(["rubbed = 0.0"] if channel == "v" else []), "for s in range(count):"],
        lines,
        ["work[3] += rubbed"] if channel == "v" else [],
    )
    return {"contact": shared, f"contact_{channel}": text}


def reach_function(loop: ParticleLoop, operator: GridOperator, name: str) -> str:
    """Farthest reach of a body along the normal at each shared node: max of side (x_p - x_i) . n + half a particle."""
    dim = loop.dim
    loop.field("x"), loop.field("V")
    for a in range(dim):
        loop.along("h", a), loop.along("inv_h", a)
    half = (
        f"half = T(0.5) * V ** T({1.0 / dim!r})"
        if loop.composition.grid.space != "axisymmetric"
        else "half = T(0.5) * sqrt(V / (T(6.283185307179586) * x[0]))"
    )
    operator.helper("node_of", operator.arena.node_of())
    header, pad = operator.nodes_loop(loop.nodes, look_up="place")
    distance = " + ".join(f"r{b} * normals[i, c, {b}]" for b in range(dim))
    lines = [
        half,
        *header,
        f"{pad}if w > zero:",
        f"{pad}    for c in range(3):",
        f"{pad}        d = side * ({distance})  # from particle to node along the normal of this side",
        f"{pad}        reach[i, c] = side * max(side * reach[i, c], half - d)",
    ]
    before = [f"for e in range({operator.arena.size}):", "    place[U(e)] = slot[node_of(home, block, e)]"]
    doc = "How far this body reaches along the contact normals"
    return each_particle(loop, operator, name, doc, lines, "near, slot, normals, reach, side, place", only="near[block]", before=before)
