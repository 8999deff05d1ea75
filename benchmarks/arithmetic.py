"""What a step has to do, counted: floating-point operations of the kernels and of the sums over nodes, bytes of the fields.

The counts are those of the method written out plainly, without common subexpressions saved between particles or nodes. They say how much
dearer one composition should be than another, and what the machine could reach.
"""

from __future__ import annotations

import dis
import types
from collections.abc import Callable
from functools import cache
from typing import Any

from benchmarks.inside import Stepper

DEAR = {"exp": 20, "log": 20, "pow": 40, "sqrt": 8, "sin": 20, "cos": 20}
"""Operations that a call counts for."""

READ = {
    "p2g": ("x", "v", "m", "C"),
    "forces": ("x", "m", "V0", "J", "F", "stress", "q"),
    "g2p": ("x", "v"),
    "filter": ("x", "m"),
    "remap": ("x", "v", "m", "C"),
    "advect": ("x",),
    "strain": ("x", "F", "J"),
    "stress": ("F", "J", "m", "V0", "stress", "q"),
}
WRITTEN = {
    "p2g": (),
    "forces": (),
    "g2p": ("v", "C"),
    "filter": (),
    "remap": (),
    "advect": ("x",),
    "strain": ("F", "J", "size_now"),
    "stress": ("stress", "q"),
}
"""Standard fields that each verb reads and writes; a law's own state is read and written with its stress."""


@cache
def operations(function: Callable[..., Any]) -> int:
    """Arithmetic operations in the text of a kernel and of all it calls; of branches all are counted, of loops one round.

    >>> operations(lambda a, b: a * b + 1.0)
    2
    """
    plain: Any = getattr(function, "function", function)
    plain = getattr(plain, "py_func", plain)
    if not isinstance(plain, types.FunctionType):
        return 0
    total, instructions = 0, list(dis.get_instructions(plain.__code__))
    for instruction in instructions:
        if instruction.opname == "BINARY_OP" or instruction.opname.startswith("UNARY_NEG"):
            total += 1
        elif instruction.opname in ("LOAD_GLOBAL", "LOAD_DEREF"):
            name = str(instruction.argval)
            called = plain.__globals__.get(name)
            if name in DEAR:
                total += DEAR[name]
            elif callable(called) and not isinstance(called, type):
                total += operations(called)
    return total


def merged(transfer: Any) -> bool:
    """Whether forces and strains go through the affine matrix, as in moving least squares, and cost nothing of their own at the nodes."""
    return getattr(transfer, "gradient", "slopes") == "moment"


def node_sums(verb: str, dim: int, transfer: Any) -> int:
    """Numbers that a verb adds up at each node of a particle (a multiplication and an addition each, tensors times vectors in full)."""
    affine = getattr(transfer, "affine", "none") != "none"
    wanted = transfer.velocity.arguments if transfer is not None else ()
    own = 0 if merged(transfer) else dim * dim  # gradients: of the force, of the velocity
    channels = len({"v_grid", "dv_grid", "v_smooth"} & {*wanted, "v_grid"})  # v_grid moves the particle in any case
    return {
        "p2g": 1 + dim + (dim * dim if affine else 0),
        "forces": own,
        "g2p": dim * channels + (dim * dim if affine else 0),
        "filter": 2 * dim,
        "remap": dim + (dim * dim if affine else 0),
        "advect": 0,
        "strain": own,
        "stress": 0,
    }[verb]


def flops(stepper: Stepper, shape: Any, transfer: Any, material: Any, effects: tuple[Any, ...] = ()) -> float:
    """Operations per particle-step."""
    dim = len(stepper.run.sim.grid.cells)
    nodes = shape.nodes**dim
    total = 0.0
    for verbs in stepper.passes():
        slopes = {"forces", "strain"} & set(verbs) and not merged(transfer)
        total += dim * operations(shape.weights) + nodes * (1 + (dim if slopes else 0))  # weights, their products, gradients
        total += sum(2 * nodes * node_sums(verb, dim, transfer) for verb in verbs)
        total += 4 * dim if "advect" in verbs else 0
        total += 4 * dim**3 if "strain" in verbs else 0  # the update of F: two products of matrices
        if "stress" in verbs:
            total += operations(material.stress) + operations(material.wave_speed)
            total += sum(operations(e.viscous_pressure) for e in effects if e.viscous_pressure is not None)
        if "forces" in verbs:
            total += sum(operations(e.body_force) + 2 * nodes * dim for e in effects if e.body_force is not None)
    near = stepper.near_contact()
    if near:  # outward: gradients of the volume; reach: distance from three candidates for the normal
        both = 2 * (dim * operations(shape.weights) + nodes * (1 + dim)) + nodes * (2 * dim + 3 * (2 * dim + 2))
        total += near * both
    return total


def traffic(stepper: Stepper, itemsize: int, particles_per_cell: int) -> dict[str, float]:
    """Bytes per particle-step that come from memory and go there: declared fields once per loop that reads or writes them, and nodes.

    The nodes count as if each were cleared, filled, updated and read once: five times its numbers, shared by the particles of a cell.
    """
    sizes = stepper.field_numbers()
    standard = {name for names in (*READ.values(), *WRITTEN.values()) for name in names} | {"X", "size"}
    state = tuple(name for name in sizes if name not in standard)
    numbers = 0
    for verbs in stepper.passes():
        read = {name for verb in verbs for name in READ[verb]} | (set(state) if "stress" in verbs else set())
        written = {name for verb in verbs for name in WRITTEN[verb]} | (set(state) if "stress" in verbs else set())
        read |= {"size"} if "size" in sizes else set()
        numbers += sum(sizes.get(name, 0) for name in read) + sum(sizes.get(name, 0) for name in written)
    return {"particles": itemsize * numbers, "nodes": 5.0 * itemsize * stepper.node_numbers() / particles_per_cell}
