"""From a recipe of verbs to phases: neighbouring verbs over particles are fused, absent components leave no phase."""

from __future__ import annotations

from math import comb

import attrs

from mpmkit._core.composing.composition import Composition
from mpmkit.errors import CompositionError

PARTICLE_VERBS = ("p2g", "forces", "g2p", "remap", "advect", "strain", "stress")


@attrs.frozen
class Phase:
    """One phase of a step, as `explain` prints it and the engine runs it.

    ``kind`` says over what it runs: "particles" (verbs fused into one loop per body), "loads" (a layer of particles),
    "nodes" (a sweep over all stored nodes), "boundary" (a list of nodes), "contact" (shared nodes) or "solve". ``role`` is that
    of the component whose phase it is, ``channel`` the nodal velocity it works on, ``number`` the weight of a term of
    XPIC, ``who`` the contributors for `explain`.
    """

    kind: str
    name: str
    verbs: tuple[str, ...] = ()
    role: str = ""
    channel: str = ""
    number: float = 0.0
    who: tuple[str, ...] = ()


@attrs.define
class Schedule:
    """Phases of one step, the channel whose gradient is the strain rate, and whether nodes have velocities before the momentum update.

    ``cycle``: the last loop over particles and the first, if one pass may do the one and then the other of the next step.
    """

    phases: list[Phase] = attrs.field(factory=list)
    cycle: tuple[Phase, Phase] | None = None
    strain_channel: str = "v"
    has_velocity: bool = False


def _ends(c: Composition, phases: list[Phase]) -> tuple[Phase, Phase] | None:
    """The last and the first loop over particles of a step, if one pass may do the one and then the other of the next step.

    Between them nothing happens at the nodes, and the first starts from particles alone. They must be the only loops over particles, and
    nodes have to hold little (`Composition.merges`), since there are those of two steps: elsewhere one pass saves one to three percent of
    the time and takes a tenth to a fifth more memory; where sums are merged it saves a tenth of the time.
    """
    first, last = phases[0], phases[-1]
    two = first.kind == last.kind == "particles" and sum(p.kind == "particles" for p in phases) == 2
    if not c.merges or not two or first.verbs != ("p2g", "forces") or not {"advect", "stress"} <= set(last.verbs):
        return None
    return last, first


def schedule(c: Composition, verbs: list[str]) -> Schedule:
    """Walk through the verbs of a recipe."""
    out = Schedule()
    pending: list[str] = []
    channel, unfiltered = "v_old", False
    loaded = {role: layer for role, layer in c.layers.items() if layer.load is not None}
    noded = {role: layer for role, layer in c.layers.items() if layer.constrain is not None}

    def flush() -> None:
        if pending:
            out.phases.append(Phase("particles", "_".join(pending), tuple(pending), who=tuple(_who(c, pending))))
            if "forces" in pending:
                for role in loaded:
                    out.phases.append(Phase("loads", f"load_{role}", role=role, who=(role,)))
            pending.clear()

    def nodes(name: str, **more: object) -> None:
        out.phases.append(Phase("nodes", name, **more))  # type: ignore[arg-type]

    for verb in verbs:
        if verb in PARTICLE_VERBS:
            if verb == "g2p" and unfiltered:
                flush()
                out.phases += _passes(c, list(noded))
                unfiltered = False
            if verb == "g2p" and c.softens:
                flush()
                nodes("soft_velocity", channel="v_soft", who=(_name(c.transfer), _name(c.shape)))
            if verb == "strain":
                if c.stored_operator:
                    channel = "v"
                out.strain_channel = channel
            if verb == "remap":
                pending.append(verb)
                flush()
                nodes("mapped_velocity", channel="v_map", who=(_name(c.integrator),))
                channel = "v_map"
            else:
                pending.append(verb)
            continue
        flush()
        if verb == "velocity":
            nodes("velocity", channel="v_old", who=(_name(c.integrator),))
            out.has_velocity = True
            channel = "v_old"
        elif verb == "limit":
            nodes("limited_velocity", channel="v_map", who=(_name(c.integrator),))
            channel = "v_map"
        elif verb == "carry":
            nodes("carry", who=(_name(c.discretization),))
            out.has_velocity = True
        elif verb == "momentum":
            consistent = getattr(c.integrator, "mass", "lumped") == "consistent"
            if consistent:
                out.phases.append(Phase("solve", "consistent_momentum", who=(_name(c.integrator),)))
            else:
                movers = [role for role, e in c.effects.items() if e.acceleration is not None]
                # nodes of stored operators get their velocities once, from the particles; then they carry them
                name = "start_momentum" if c.stored_operator and not out.has_velocity else "momentum"
                nodes(name, who=(_name(c.integrator or c.discretization), *movers))
            unfiltered = c.transfer is not None and c.transfer.passes > 1
            channel = "v"
        elif verb == "contact":
            if c.contact is not None:
                out.phases.append(Phase("contact", f"contact_{channel}", channel=channel, who=(_name(c.contact),)))
        elif verb == "boundary":
            for role in noded:
                out.phases.append(Phase("boundary", f"{role}_{channel}", role=role, channel=channel, who=(role,)))
        else:
            raise CompositionError(f"the recipe of {_name(c.integrator)} has an unknown verb {verb!r}")
    flush()
    out.cycle = _ends(c, out.phases) if out.phases else None
    return out


def _passes(c: Composition, layers: list[str]) -> list[Phase]:
    """v_smooth = sum_r (-1)^(r+1) binom(m, r) (S+ S)^(r-1) v_old, the filtered velocity of XPIC(m).

    Layers act on what comes out of every pass, so that a body at a plane of symmetry is filtered as one half of a whole; ``number`` of
    such a phase is the share of it in v_smooth, and that is the sum of the weights of the passes still to come.
    """
    m, who = c.transfer.passes, (_name(c.transfer),)
    weights = [float((-1) ** (r + 1) * comb(m, r)) for r in range(1, m + 1)]

    def constrain(channel: str, number: float) -> list[Phase]:
        return [Phase("boundary", f"{role}_{channel}", role=role, channel=channel, number=number, who=(role,)) for role in layers]

    phases = [Phase("nodes", "filter_start", number=weights[0], who=who)]
    for r in range(1, m):
        phases.append(Phase("particles", "filter", ("filter",), who=who))
        phases.append(Phase("nodes", "filter_add", number=weights[r], who=who))
        phases += constrain("u", sum(weights[r + 1 :])) if r + 1 < m else []
    return phases + constrain("v_smooth", 1.0)


def _name(component: object) -> str:
    return type(component).__name__


def _who(c: Composition, verbs: list[str]) -> list[str]:
    """Components that contribute to a loop, for `explain`."""
    who: list[str] = []
    if not c.stored_operator:
        who.append(_name(c.shape))
    if {"p2g", "g2p", "remap"} & set(verbs) and c.transfer is not None:
        who.append(_name(c.transfer))
    if "forces" in verbs:
        who += [role for role, e in c.effects.items() if e.body_force is not None]
    if "stress" in verbs:
        who += [g.name for g in c.groups]
        who += [role for role, e in c.effects.items() if e.viscous_pressure is not None]
    return who
