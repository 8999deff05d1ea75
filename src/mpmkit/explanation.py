"""`Simulation.explain()`: the step as it will run, and what its parts cost, printed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from mpmkit._core.running.loop import Run

Table = tuple[str, tuple[str, ...], list[tuple[str, ...]], list[str]]
"""Title, headings, rows, and lines below."""


class Explanation:
    """Text of a composition: phases and loops, fields with bytes and reasons, effects that are off, time-step rule, generated file.

    ``str(explanation)`` is the text; `data` the same as plain data. After `measure` both also say what each part costs.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.measured: dict[str, Any] | None = None

    def measure(self, steps: int | None = None, *, threads: int | None = None, say: Callable[[str], None] | None = None) -> Explanation:
        """Time every phase, and compare with the same simulation without each effect, contact and boundary layer.

        Copies of the simulation step from its present state; it is not changed itself. Each copy without a component is another
        composition that has to be compiled the first time.

        Parameters
        ----------
        steps : int, optional
            Steps in which phases are timed; if not given, as many as take a second.
        threads : int, optional
            How many threads step, as for `Simulation.run`.
        say : callable, optional
            Told what is being done, one line at a time.

        Returns
        -------
        Explanation
            Itself; the numbers are in ``data["measured"]``.

        Raises
        ------
        ParameterError
            If `steps` is not a number above zero.
        """
        from mpmkit._core.running.measuring import measure

        self.run.use(threads)
        self.measured = measure(self.run, steps, say or (lambda text: None))
        return self

    @property
    def data(self) -> dict[str, Any]:
        from mpmkit._core.composing import cautions, limits, loops

        run, plan = self.run, self.run.plan
        c = plan.composition
        itemsize = 4 if run.sim.precision == "float32" else 8
        fields = {
            g.name: {
                name: {
                    "components": len(g.layout.stored(name)),
                    "bytes": itemsize * len(g.layout.stored(name)),
                    "for": g.layout.reasons[name],
                }
                for name in g.layout.fields
            }
            for g in c.groups
        }
        return {
            "space": c.grid.space,
            "precision": run.sim.precision,
            "cells": list(c.grid.cells),
            "particles": {s.name: s.n for s in run._stores},
            "phases": [
                {"over": p.kind, "name": p.name, "verbs": list(p.verbs), "by": list(p.who), "functions": loops.functions(plan, p)}
                for p in plan.schedule.phases
            ],
            "loops": loops.sizes(plan),
            "threads": run.engine.team.size,
            "memory": run.engine.bytes(),
            "particle fields": fields,
            "node fields": {
                n: {"bytes": itemsize * (1 if n == "m" else c.dim), "for": plan.node_layout.reasons[n]} for n in plan.node_layout.start
            },
            "off": self.off(),
            "guards": self.guards(),
            "warnings": list(run.warnings),
            "notes": cautions.notes(c) + limits.notes(c),
            "file": str(self.path),
        } | ({"measured": self.measured} if self.measured is not None else {})

    @property
    def path(self) -> Any:
        from mpmkit._core.composing.cache import home

        return home(self.run.plan.digest) / "step.py"

    def off(self) -> list[str]:
        """Registered effects and contact algorithms that this scene does not use."""
        from mpmkit._core.registry import registry

        c = self.run.plan.composition
        used = {type(x).__name__ for x in [*c.effects.values(), c.contact]}
        return sorted(n for n in registry().of("effect", "contact") if n not in used)

    def guards(self) -> dict[str, str]:
        """What happens when a step fails or a particle leaves the domain."""
        from mpmkit._core.running import snapshot

        sim, c = self.run.sim, self.run.plan.composition
        if getattr(c.integrator or c.discretization, "dt", None) is not None:
            failed = "the run stops: dt is fixed"
        elif not sim.retries:
            failed = "the run stops (retries = 0)"
        elif not snapshot.small(self.run.engine):
            failed = f"the run stops: of a state of more than {snapshot.IN_MEMORY >> 20} MiB no copy is kept"
        else:
            failed = f"repeated with half the Courant number, {sim.retries} times in a row at most"
        leaving = {
            "stop": "the run stops",
            "remove": "taken out and booked in the history",
            "clamp": "held at the face, impulse and energy booked",
        }
        return {"failed steps": failed, "particles that leave the domain": leaving[sim.leaving]}

    def __str__(self) -> str:
        from mpmkit._core.composing import cautions, limits, loops
        from mpmkit._core.running.memory import text as size

        run, plan, data = self.run, self.run.plan, self.data
        c, sim = plan.composition, run.sim
        method = [x for x in (sim.shape, sim.integrator, sim.discretization) if x is not None]
        cells = " x ".join(map(str, c.grid.cells))
        lines = [f"{' · '.join(map(str, method))} in {c.grid.space}, {cells} cells, {run.n_particles:,} particles, {sim.precision}"]
        if c.grid.space == "1D":
            lines.append(
                f"lateral {c.grid.lateral} is zero ({'a slender bar' if c.grid.lateral == 'stress' else 'a column that cannot widen'})"
            )
        lines += ["", "one step"]
        for k, phase in enumerate(plan.schedule.phases, 1):
            what = ", ".join(phase.verbs) if phase.verbs else phase.name.replace("_", " ")
            clock = self._share(phase.name)
            lines.append(f"{k:3} {phase.kind:<10} {what:<34} {', '.join(dict.fromkeys(phase.who)):<40}{clock}".rstrip())
            if phase.kind == "particles":
                lines += [f"        {loops.sentence(loop)}" for loop in data["phases"][k - 1]["functions"]]
        lines += ["", f"loops: {loops.summary(data['loops'])}"]
        memory = data["memory"]
        lines.append(
            f"memory: {size(memory['particles'])} for particles, {size(memory['nodes'])} for {memory['stored nodes']:,} stored nodes in "
            f"{memory['blocks']:,} blocks, {size(memory['scratch'])} of scratch for {data['threads']} thread{'s' * (data['threads'] > 1)}"
        )
        for group, fields in data["particle fields"].items():
            total = sum(f["bytes"] for f in fields.values())
            count = sum(s.n for s in run._stores if s.group.name == group)
            lines += ["", f"particle fields of {group}: {total} bytes each, {count:,} particles, {total * count / 1e6:.3g} MB"]
            lines += [f"    {name:<8}{f['bytes']:>4} B   {', '.join(f['for'])}" for name, f in fields.items()]
            derived = next(g for g in c.groups if g.name == group).layout.derived
            lines += [f"    {name:<8}   0 B   computed where it is asked for" for name in derived]
        node_bytes = sum(f["bytes"] for f in data["node fields"].values())
        n_fields = len(run._stores) if c.contact is not None else 1
        lines += ["", f"node fields: {node_bytes} bytes per node{f', one set for each of {n_fields} bodies' if n_fields > 1 else ''}"]
        lines += [f"    {name:<8}{f['bytes']:>4} B   {f['for']}" for name, f in data["node fields"].items()]
        lines += ["", f"off (no field, no line, no time): {', '.join(data['off']) or 'nothing'}"]
        lines.append(f"time step: {self._step_rule()}")
        lines += [f"{what}: {how}" for what, how in data["guards"].items()]
        for text in run.warnings:
            lines.append(f"warning: {text}")
        for text in cautions.notes(c) + limits.notes(c):
            lines.append(f"note: {text}")
        lines.append(f"generated step: {self.path}")
        if self.measured is not None:
            for title, headings, rows, notes in costs(self.measured):
                lines += ["", title, *_columns(headings, rows), *notes]
        return "\n".join(lines)

    def _share(self, name: str) -> str:
        engine = self.run._engine
        if engine is None or engine.step_number == 0 or name not in engine.clocks:
            return ""
        total = sum(engine.clocks.values())
        return f"{engine.clocks[name] / total:6.1%}"

    def _step_rule(self) -> str:
        from mpmkit._core.running.timestep import next_step

        limit = self.run.limit
        if limit is None:
            limit = next_step(self.run.engine)
        return f"dt = {limit.dt:.4g} s, {limit.rule}"

    def _repr_html_(self) -> str:
        import html

        return f"<pre>{html.escape(str(self))}</pre>"


def costs(measured: dict[str, Any]) -> list[Table]:
    """What was measured, as tables: the parts of a step, and what it would cost without each optional component."""
    m = measured
    title = (
        f"measured in {m['steps']} steps from t = {m['t']:.6g} s, {m['threads']} thread{'s' * (m['threads'] > 1)}: "
        f"{m['ns']:.4g} ns per particle-step"
    )
    rows: list[tuple[str, ...]] = [(row["name"], f"{row['share']:.1%}", f"{row['ns']:.3g}") for row in m["phases"]]
    stopped = [f"stopped early: {m['stopped']}"] if m["stopped"] else []
    tables: list[Table] = [(title, ("part of a step", "share", "ns per particle-step"), rows, stopped)]
    if not m["components"]:
        return tables
    rows = []
    for row in m["components"]:
        if "refused" in row:
            rows.append((row["name"], "", f"cannot be measured, there is no step without it: {row['refused']}"))
            continue
        share, spread = row["share"], row["spread"]
        rows.append((row["name"], f"{share:+.1%} ± {spread:.1%}", "not above the noise" if abs(share) <= spread else ""))
    headings = ("component", "share", "")
    return [*tables, ("share of a step, 1 - t(without it) / t(with it), from copies that take turns", headings, rows, [])]


def _columns(headings: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    """Rows under headings in plain text, numbers to the right."""
    widths = [max(len(row[k]) for row in (headings, *rows)) for k in range(len(headings))]
    right = (False, *(len(headings[k]) > 0 for k in range(1, len(headings))))
    return [
        "    " + "   ".join(cell.rjust(w) if r else cell.ljust(w) for cell, w, r in zip(row, widths, right, strict=True)).rstrip()
        for row in (headings, *rows)
    ]
