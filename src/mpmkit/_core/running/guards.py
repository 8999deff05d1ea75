"""Guards: a run stops at the first step that makes no sense, and says which particle, body, component and rule."""

from __future__ import annotations

import numpy as np

from mpmkit._core.running.engine import Engine
from mpmkit.errors import StabilityError


def check(engine: Engine) -> None:
    """Look at what the loops over particles have flagged in this step.

    Raises
    ------
    StabilityError
        NaN, J <= 0, a particle outside the domain; names particle, body, material, step and time.
    """
    if engine.flags.any():
        _explain(engine)
    speed = engine.outs[:, 0].max()
    if not np.isfinite(speed):
        body = int(np.argmax(~np.isfinite(engine.outs[:, 0])))
        raise StabilityError(
            _where(engine, body, None, "the wave speed is not a number", "lower cfl, or look at the material's range of validity")
        )


def _explain(engine: Engine) -> None:
    body = int(np.argmax(engine.flags.any(axis=1)))
    store, (inverted, outside, _) = engine.stores[body], engine.flags[body]
    at = store.get("x")
    J_all = store.get("J")
    if outside:
        low, high = np.asarray(engine.c.grid.lower, at.dtype), np.asarray(engine.c.grid.upper, at.dtype)  # as the loops compare
        wrong = ~((at >= low) & (at <= high)).all(axis=1)
    elif inverted:
        wrong = ~(J_all > 0.0)
    else:
        stretch = store.get("F")[:, [0, 4, 8][: engine.c.dim]]
        shape = engine.c.shape
        assert shape is not None
        wrong = ~(store.get("size") * stretch / np.asarray(engine.c.grid.spacing) <= shape.max_half).all(axis=1)
    particle = int(np.argmax(wrong))
    x, v, J = at[particle], store.get("v")[particle], float(J_all[particle])
    if not (np.isfinite(x).all() and np.isfinite(v).all()):
        raise StabilityError(_where(engine, body, particle, "position or velocity is not a number (NaN)", _cfl(engine)))
    if outside:
        grid = engine.c.grid
        raise StabilityError(
            _where(
                engine,
                body,
                particle,
                f"it left the domain: x = {_text(x)} m is outside {_text(grid.lower)} to {_text(grid.upper)}",
                "enlarge the grid, or put a Wall or Symmetry on that face",
            )
        )
    if not inverted:
        assert engine.c.shape is not None
        shape = engine.c.shape
        reason = f"it has been stretched to more than {2 * shape.max_half:g} cells, farther than {type(shape).__name__} reaches"
        raise StabilityError(_where(engine, body, particle, reason, "raise reach, use more particles per cell, or a coarser grid"))
    reason = "J = det F is not a number (NaN)" if not np.isfinite(J) else f"the material is inverted, J = {J:.4g} <= 0"
    raise StabilityError(_where(engine, body, particle, reason, _cfl(engine)))


def _where(engine: Engine, body: int, particle: int | None, what: str, fix: str) -> str:
    store = engine.stores[body]
    material = type(engine.c.sim.bodies[body].material).__name__
    who = f"particle {particle} of body" if particle is not None else "body"
    return f"{who} {store.name!r} ({material}): {what}, at step {engine.step_number}, t = {engine.t:.6g} s. To fix: {fix}"


def _cfl(engine: Engine) -> str:
    cfl = getattr(engine.c.integrator or engine.c.discretization, "cfl", None)
    return (
        f"lower cfl (now {cfl:g}), refine the grid, or use a shape function of higher order" if cfl else "refine the grid or the time step"
    )


def _text(x: object) -> str:
    return "(" + ", ".join(f"{float(a):.6g}" for a in np.atleast_1d(np.asarray(x))) + ")"
