"""Momentum update with the consistent mass matrix, m_ij = sum_p m_p N_i N_j (SAND2002-0482 eq 1-14).

Dense and for small problems: M a = f for the accelerations and M v = (mv) for the velocities, solved in the least
squares sense, because with few particles the matrix is singular. Prescribed components enter as constraints.

Known to fail where a moving body meets a held plane, most of all with splines: the nodes next to the plane take velocities far beyond those
of the particles, so that these fit in spite of the constraint, forces do work with them, strains come from the second mapping and do not,
and a quarter of the motion and more is made as energy in the impact, whatever the step. Such a start is refused (`contract.check_state`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.composing.sweep import FORCE, IMPULSE, WORK
from mpmkit._core.running.bindings import face_nodes
from mpmkit.errors import CompositionError

if TYPE_CHECKING:
    from mpmkit._core.running.engine import Engine

LARGEST = 3000
KEPT = 1e-3
"""Smallest singular value, relative to the largest, that is solved for. Combinations of nodal velocities below are nearly unseen by the
particles, but forces, which come from gradients, act on them: dividing by such a value makes energy out of nothing, the more so the wider
the shape functions are."""
EXTERNAL, BOUNDARY = WORK.index("external"), WORK.index("boundary")


class ConsistentMomentum:
    """v_i^old and v_i after the update, written where the lumped update would write them."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        e = engine
        self.number = np.full(e.fields[0].n_nodes, -1, dtype=np.int64)
        per_particle = e.plan.operator.nodes**e.c.dim
        self.rows, self.ws = np.zeros(per_particle, dtype=np.int64), np.zeros(per_particle, dtype=e.dtype)

    def __call__(self, t: Any, dt: Any) -> None:
        e, dim = self.engine, self.engine.c.dim
        layout, field = e.plan.node_layout, e.fields[0]
        G = field.G[: field.n_nodes * e.channels].reshape(-1, e.channels)
        active = np.flatnonzero(G[:, layout.start["m"]] > e.m_small)
        if active.size > LARGEST:
            raise CompositionError(
                f"mass='consistent' is dense and allowed up to {LARGEST} occupied nodes; this scene has {active.size}. Use mass='lumped'"
            )
        M = self._matrix(active, t, dt)
        old, new = layout.start["v_old"], layout.start["v"]
        f_ext = layout.start.get("f_ext")
        for a in range(dim):
            momentum, force = G[active, old + a].astype(float), G[active, new + a].astype(float)
            m = M.sum(axis=1)
            g = sum(self._acceleration(effect, a) for effect in e.c.effects.values() if effect.acceleration is not None)
            force += m * g
            held, value = self._held(active, a)
            free = ~held
            v_old, v = value.copy(), value.copy()
            # nearest to the lumped velocities, which are exact in uniform motion: M leaves what no particle sees undetermined
            lumped = momentum / m
            rest = momentum - M[:, free] @ lumped[free] - M[:, held] @ value[held]
            v_old[free] = lumped[free] + _solve(M[np.ix_(free, free)], rest[free])
            inner = M[np.ix_(free, free)]
            # gravity apart, so that a body falls with it exactly also where M is singular
            v[free] = v_old[free] + float(dt) * (g + _solve(inner, force[free] - g * inner.sum(axis=1)))
            reaction = M[held] @ (v - v_old) - float(dt) * force[held]
            e.work[IMPULSE + a] += float(reaction.sum())
            e.work[BOUNDARY] += float(reaction @ value[held])
            e.work[FORCE + a] += float(dt) * g * float(m.sum())
            e.work[EXTERNAL] += float(dt) * g * float(m @ (0.5 * (v_old + v)))
            if f_ext is not None:
                outer = G[active, f_ext + a].astype(float)
                e.work[FORCE + a] += float(dt) * float(outer.sum())
                given = np.zeros(active.size)  # the velocity external forces give; the particles sum its work
                given[free] = float(dt) * _solve(M[np.ix_(free, free)], outer[free])
                G[active, f_ext + a] = given
            G[active, old + a], G[active, new + a] = v_old, v

    def _matrix(self, active: Any, t: Any, dt: Any) -> Any:
        e = self.engine
        self.number[:] = 0
        self.number[active] = np.arange(active.size)
        M = np.zeros((active.size, active.size), dtype=e.dtype)
        for k, s in enumerate(e.stores):
            arguments = (*e.particle_arguments(k, e.places.acc[k]), M, self.number, self.rows, self.ws, e.scratch[0][0], e.scratch[0][2])
            getattr(e.module, f"mass_matrix_{s.group.name}")(0, e.places.blocks[k].count, *arguments, t, dt)
        return M.astype(float)

    def _acceleration(self, effect: Any, a: int) -> float:
        g = getattr(effect, "g", None)
        if g is None:
            raise CompositionError(
                f"mass='consistent' works with Gravity and BodyForce; {type(effect).__name__} changes nodal accelerations. Use "
                "mass='lumped'"
            )
        return float(g[a])

    def _held(self, active: Any, a: int) -> tuple[Any, Any]:
        """Which nodes have component `a` prescribed, and its value: what `constrain` returns whatever it is given."""
        e = self.engine
        held, value = np.zeros(active.size, dtype=bool), np.zeros(active.size)
        place = {int(i): k for k, i in enumerate(active)}
        for layer in e.c.layers.values():
            if layer.constrain is None:
                continue
            numbers, normals = face_nodes(e, e.fields[0], layer.faces_of(e.c.grid))
            for i, n in zip(numbers, normals, strict=True):
                if int(i) not in place:
                    continue
                probes = [self._constrain(layer, v, n) for v in ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))]
                if abs(probes[0][a] - probes[1][a]) < 0.5:
                    held[place[int(i)]] = True
                    value[place[int(i)]] = probes[0][a]
        return held, value

    def _constrain(self, layer: Any, v: tuple[float, ...], n: Any) -> Any:
        special = {"v": v, "normal": tuple(float(c) for c in n)}
        try:
            return layer.constrain(
                *(special[name] if name in special else self._constant(layer, name) for name in layer.constrain.arguments)
            )
        except KeyError as error:
            raise CompositionError(
                f"mass='consistent' needs constant conditions; {type(layer).__name__} asks for {error}. Use mass='lumped'"
            ) from None

    def _constant(self, layer: Any, name: str) -> Any:
        from mpmkit.expression import as_function

        value = as_function(getattr(layer, name), self.engine.c.dim)
        if callable(value):
            raise KeyError(f"a {name} that varies")
        return value


def _solve(A: Any, b: Any) -> Any:
    """Least-squares solution of smallest norm without singular values below `KEPT` of the largest, shifted to keep sum(A x) = sum(b).

    The shift gives back what was dropped of the momentum, a share of up to sqrt(KEPT).
    """
    if not b.size:
        return b
    x = np.linalg.lstsq(A, b, rcond=KEPT)[0]
    return x + (b.sum() - (A @ x).sum()) / A.sum()
