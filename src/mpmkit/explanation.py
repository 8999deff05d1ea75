"""`Simulation.explain()`: the step as it will run, printed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mpmkit._core.running.loop import Run


class Explanation:
    """Text of a composition: phases, fields with bytes and reasons, effects that are off, time-step rule, generated file.

    ``str(explanation)`` is the text; `data` the same as plain data.
    """

    def __init__(self, run: Run) -> None:
        self.run = run

    @property
    def data(self) -> dict[str, Any]:
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
            "phases": [{"over": p.kind, "name": p.name, "verbs": list(p.verbs), "by": list(p.who)} for p in plan.schedule.phases],
            "particle fields": fields,
            "node fields": {
                n: {"bytes": itemsize * (1 if n == "m" else c.dim), "for": plan.node_layout.reasons[n]} for n in plan.node_layout.start
            },
            "off": self.off(),
            "file": str(self.path),
        }

    @property
    def path(self) -> Any:
        from mpmkit._core.composing.cache import folder

        return folder() / self.run.plan.digest / "step.py"

    def off(self) -> list[str]:
        """Registered effects and contact algorithms that this scene does not use."""
        from mpmkit._core.registry import registry

        c = self.run.plan.composition
        used = {type(x).__name__ for x in [*c.effects.values(), c.contact]}
        return sorted(n for n in registry().of("effect", "contact") if n not in used)

    def __str__(self) -> str:
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
        for group, fields in data["particle fields"].items():
            total = sum(f["bytes"] for f in fields.values())
            count = sum(s.n for s in run._stores if s.group.name == group)
            lines += ["", f"particle fields of {group}: {total} bytes each, {count:,} particles, {total * count / 1e6:.3g} MB"]
            lines += [f"    {name:<8}{f['bytes']:>4} B   {', '.join(f['for'])}" for name, f in fields.items()]
        node_bytes = sum(f["bytes"] for f in data["node fields"].values())
        n_fields = len(run._stores) if c.contact is not None else 1
        lines += ["", f"node fields: {node_bytes} bytes per node{f', one set for each of {n_fields} bodies' if n_fields > 1 else ''}"]
        lines += [f"    {name:<8}{f['bytes']:>4} B   {f['for']}" for name, f in data["node fields"].items()]
        lines += ["", f"off (no field, no line, no time): {', '.join(data['off']) or 'nothing'}"]
        lines.append(f"time step: {self._step_rule()}")
        for text in run.warnings:
            lines.append(f"warning: {text}")
        lines.append(f"generated step: {self.path}")
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
