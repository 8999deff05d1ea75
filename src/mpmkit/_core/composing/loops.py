"""What is told about the loops of a composition: which functions run in a phase, what they sum over nodes and add to them, sizes."""

from __future__ import annotations

from typing import Any

from mpmkit._core.composing.plan import Plan
from mpmkit._core.composing.schedule import Phase


def functions(plan: Plan, phase: Phase) -> list[dict[str, Any]]:
    """The generated functions of a phase; those over particles with the channels they sum over nodes and add to them."""
    groups = [g.name for g in plan.composition.groups]
    if phase.kind == "particles":
        names = [f"{phase.name}_{g}" for g in groups]
        return [{"function": n, "sums": list(plan.traffic[n][0]), "adds": list(plan.traffic[n][1])} for n in names]
    if phase.kind == "loads":
        return [{"function": f"{phase.name}_{g}"} for g in groups]
    if phase.kind == "solve":
        return [{"function": f"mass_matrix_{g}"} for g in groups]
    if phase.kind == "contact":
        first = next(p for p in plan.schedule.phases if p.kind == "contact")
        finding = ["find_shared", "contact_normals", *(f"reach_{g}" for g in groups), "choose_normals"] if phase is first else []
        return [{"function": name} for name in (*finding, phase.name)]
    return [{"function": phase.name}]


def sentence(loop: dict[str, Any]) -> str:
    """One loop over particles in words."""
    parts = [f"{what} {', '.join(loop[key])}" for key, what in (("sums", "sums"), ("adds", "adds to")) if loop[key]]
    return f"{loop['function']}: {'; '.join(parts) or 'no nodes'}"


def sizes(plan: Plan) -> dict[str, Any]:
    """Loops over the particles in a step, nodes of a particle, and the nodes along the axes of blocks and arenas."""
    c = plan.composition
    passes = sum(phase.kind == "particles" for phase in plan.schedule.phases)
    if c.stored_operator:
        return {"passes": passes, "nodes per particle": plan.operator.per_point, "operator": "stored"}
    arena = plan.operator.arena
    joined = plan.schedule.cycle is not None
    return {
        "passes": passes,
        "joined in large bodies": joined,
        "nodes per particle": plan.operator.nodes**c.dim,
        "operator": "rebuilt",
        "block": [arena.block] * c.dim,
        "arena": [arena.side] * c.dim,
    }


def summary(found: dict[str, Any]) -> str:
    """The sizes in words."""
    count, nodes = found["passes"], found["nodes per particle"]
    text = f"{count} over the particles, {nodes} node{'s' if nodes > 1 else ''} each"
    if found.get("joined in large bodies"):
        text += ", the last and the next step's first in one pass if bodies are large"
    if found["operator"] == "stored":
        return f"{text}, from lists with weights that are made once"
    block, arena = (" x ".join(map(str, found[name])) for name in ("block", "arena"))
    return f"{text}; particles sorted by cell, blocks of {block} nodes, arenas of {arena}"
