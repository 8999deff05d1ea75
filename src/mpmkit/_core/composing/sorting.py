"""Text of the functions that sort the particles of a body by block and cell; one set serves all bodies of a module.

The order is found with a counting sort that is stable: particles of one cell keep the order they had. Then the packed
buffer is reordered in place, in one sweep from the first to the last place. The particle that lies in a place is copied
aside first if a later place still wants it. In a set that was sorted some steps ago only a few percent wait at a time,
so the reordering needs a few percent of the particles' memory beside the buffer, and reads and writes it once.
"""

from __future__ import annotations

import textwrap

from mpmkit._core.composing.layout import LANES

_TILE = LANES.bit_length() - 1
_AHEAD = 8  # tiles: positions of successive tiles are so far apart that the processor does not foresee what is read next


def sort_functions(dim: int, B: int) -> str:
    """Text of `find_blocks`, `order_particles`, `assign_slots` and `move_particles`.

    None of them allocates; everything they write is an argument. Integer arrays over particles may be int32 or int64.
    They need `compiled`, `floor` and the `prefetch` of `mpmkit._core.composing.simd` in their module.

    Parameters
    ----------
    dim : int
        Number of space dimensions.
    B : int
        Nodes along each edge of a block.
    """
    return "\n\n\n".join([_find_blocks(dim, B), _order_particles(B**dim), _ASSIGN_SLOTS, _MOVE_PARTICLES]) + "\n"


def _quotient(value: str, B: int) -> str:
    return f"{value} >> {B.bit_length() - 1}" if B & (B - 1) == 0 else f"{value} // {B}"


def _remainder(value: str, B: int) -> str:
    return f"{value} & {B - 1}" if B & (B - 1) == 0 else f"{value} % {B}"


def _find_blocks(dim: int, B: int) -> str:
    axes = range(dim)
    base = [
        f"i{a} = min(int(floor((P[b{f' + {LANES * a}' if a else ''}] - lower{a}) * inv_h{a} - offset)), last{a}) + ghosts" for a in axes
    ]
    outside = " or ".join(f"i{a} < 0" for a in axes)
    number, cell = f"({_quotient('i0', B)}) + 1", _remainder("i0", B)
    for a in axes[1:]:
        number = f"({number}) * shape[{a}] + ({_quotient(f'i{a}', B)}) + 1"
        cell = f"({cell}) * {B} + ({_remainder(f'i{a}', B)})"
    inner = textwrap.indent("\n".join(base), " " * 8)
    ahead = "\n".join(f"            prefetch(P, b + {LANES} * ({_AHEAD} * R + {a}))" for a in axes)
    hoisted = "\n".join(f"    lower{a}, inv_h{a}, last{a} = lower[{a}], inv_h[{a}], cells[{a}] - 1" for a in axes)
    return f'''@compiled
def find_blocks(P, n, R, first_x, lower, inv_h, offset, cells, ghosts, shape, table, key, found):
    """Which block, and which cell inside it, each particle belongs to: key = block * {B**dim} + cell.

    Blocks are counted in the order they are met, found[block] is their number in the whole domain. Returns how many there are,
    -1 if `found` is too short, or -2 - p if particle p is below the domain or its position is not a number; one above it counts to the
    last cell, which the guards tell. The table is all zero before and after.
    """
{hoisted}
    count, known, status = 0, -1, 0
    here = 0
    for p in range(n):
        b = (p >> {_TILE}) * ({LANES} * R) + (p & {LANES - 1}) + {LANES} * first_x
        if p & 7 == 0:
{ahead}
{inner}
        if {outside}:
            status = -2 - p
            break
        v = {number}
        if v != known:
            here = int(table[v])
            if here == 0:
                if count == found.size:
                    status = -1
                    break
                found[count] = v
                count += 1
                table[v] = count
                here = count
            known = v
        key[p] = (here - 1) * {B**dim} + ({cell})
    for j in range(count):
        table[found[j]] = 0
    return count if status == 0 else status'''


def _order_particles(cells: int) -> str:
    return f'''@compiled
def order_particles(n, by, key, first, starts, source, place, changed):
    """Stable counting sort: source[q] is the old place of the particle that goes to q, place the inverse.

    by[r] is the block that comes at rank r, and starts[r] the place of its first particle. Only places changed[0] <= q < changed[1]
    change. first: room for {cells} counts for each block.
    """
    for j in range(by.size * {cells}):
        first[j] = 0
    for p in range(n):
        first[key[p]] += 1
    total = 0
    for r in range(by.size):
        starts[r] = total
        for j in range(by[r] * {cells}, (by[r] + 1) * {cells}):
            here = int(first[j])
            first[j] = total
            total += here
    starts[by.size] = total
    low, high = n, 0
    for p in range(n):
        j = key[p]
        q = int(first[j])
        first[j] = q + 1
        source[q] = p
        place[p] = q
        if q != p:
            low, high = min(low, q), max(high, q + 1)
    changed[0], changed[1] = low, high'''


_ASSIGN_SLOTS = '''@compiled
def assign_slots(source, slot, free, low, high):
    """Where each particle waits while the buffer is reordered: a slot aside, or -1 if it need not. Returns how many there are.

    slot: on entry the new place of each particle. free: room for a stack of slots that are no longer in use.
    """
    waiting, slots = 0, 0
    for q in range(low, high):
        p = int(source[q])
        taken = -1
        if slot[q] > q:
            if waiting > 0:
                waiting -= 1
                taken = int(free[waiting])
            else:
                taken = slots
                slots += 1
        slot[q] = taken
        if p < q:
            free[waiting] = slot[p]
            waiting += 1
    return slots'''


_MOVE_PARTICLES = f'''@compiled
def move_particles(P, R, source, slot, spare, k0, k1, low, high):
    """Components k0 <= k < k1 of all particles move to their new places. spare: k1 - k0 numbers for each slot."""
    width = k1 - k0
    for q in range(low, high):
        p = int(source[q])
        if p != q:
            a = (q >> {_TILE}) * ({LANES} * R) + (q & {LANES - 1}) + {LANES} * k0
            if slot[q] >= 0:
                c = int(slot[q]) * width
                for k in range(width):
                    spare[c + k] = P[a + {LANES} * k]
            if p > q:
                b = (p >> {_TILE}) * ({LANES} * R) + (p & {LANES - 1}) + {LANES} * k0
                for k in range(width):
                    P[a + {LANES} * k] = P[b + {LANES} * k]
            else:
                c = int(slot[p]) * width
                for k in range(width):
                    P[a + {LANES} * k] = spare[c + k]'''
