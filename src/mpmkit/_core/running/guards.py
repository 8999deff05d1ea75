"""Guards: a run stops at the first step that makes no sense, and says which particle, body, component and rule."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit._core.composing.sizes import half_sizes
from mpmkit._core.running.engine import FLAGS, Engine
from mpmkit._core.running.store import BodyStore
from mpmkit.errors import ParameterError, StabilityError


def check(engine: Engine) -> None:
    """Look at what the loops over particles have flagged in this step.

    Raises
    ------
    StabilityError
        NaN, J <= 0, a particle outside the domain; names particle, body, material, step and time, and whether a shorter step may help.
    """
    if engine.flags.any():
        _explain(engine)
    _speeds(engine)


def _speeds(engine: Engine) -> None:
    """Refuse wave speeds that are infinite or not a number."""
    if np.isfinite(engine.outs[:, 0]).all():
        return
    body = int(np.argmax(~np.isfinite(engine.outs[:, 0])))
    speed = float(engine.outs[body, 0])
    what = "the wave speed, or the speed of a particle, is infinite or not a number"  # the loops report both as infinite
    begun = engine.step_number > 0
    fix = "lower cfl, or look at the material's range of validity" if begun else "smaller moduli, a larger rho, or other units"
    raise _failed(engine, body, None, f"{what}, c + |v| = {speed:g} m/s", fix, shorter=begun)


def masses(store: BodyStore, rho: float) -> None:
    """Refuse masses and kinetic energies that the precision in use cannot hold.

    Raises
    ------
    ParameterError
        With the body, the number, the allowed range, and the density that it comes from.
    """
    precision = np.finfo(store.P.dtype)
    with np.errstate(over="ignore"):
        found = [(m.min(), m.sum(), 0.5 * (m * v**2).sum()) for m, v in store.pieces("m", "v")]
        lightest, mass, kinetic = min(one[0] for one in found), sum(one[1] for one in found), sum(one[2] for one in found)
    sums = (("the mass of its lightest particle", lightest, "kg"), ("its mass", mass, "kg"), ("its kinetic energy", kinetic, "J"))
    for k, (what, number, unit) in enumerate(sums):
        if not number <= float(precision.max) or (k == 0 and number < float(precision.tiny)):
            given = f"rho = {rho:g} kg/m^3 and {store.n} particles of {float(np.min(store.points.V0)):.3g} m^3 or more"
            fix = "another rho, other units" + (', or precision="float64"' if precision.bits < 64 else "")
            raise ParameterError(
                f"body {store.name!r}: {what} is {number:g} {unit}, with {given}; {precision.dtype} holds {float(precision.tiny):.2g} to "
                f"{float(precision.max):.2g}. To fix: {fix}"
            )


def wrong(engine: Engine, body: int, flag: str) -> Any:
    """Which particles of a body deserve a flag of `FLAGS`, bool[n], in the order of their numbers."""
    store = engine.stores[body]
    if flag == "inside":
        at = store.get("x")
        low, high = np.asarray(engine.c.grid.lower, at.dtype), np.asarray(engine.c.grid.upper, at.dtype)  # as the loops compare
        return ~((at >= low) & (at <= high)).all(axis=1)
    if flag == "inverted":
        return ~(store.get("J") > 0.0)
    shape = engine.c.shape
    if shape is None or shape.particle_size != "current":
        return np.zeros(store.n, dtype=bool)
    now = half_sizes(store.get("size"), store.get("F"))
    return ~(now / np.asarray(engine.c.grid.spacing) <= shape.max_half).all(axis=1)


def jumped(engine: Engine, body: int) -> bool:
    """Whether a particle has moved by more than a cell in the last step: no time step allows that, so this is no flight."""
    return not engine.c.stored_operator and not engine.places.pace[body] <= 1.0


def _explain(engine: Engine) -> None:
    body = int(np.argmax(engine.flags.any(axis=1)))
    store = engine.stores[body]
    raised = dict(zip(FLAGS, engine.flags[body].tolist(), strict=True))
    flag = next(one for one in ("inside", "inverted", "stretched") if raised[one])
    p = int(np.argmax(wrong(engine, body, flag)))
    x, v, J = store.get("x")[p], store.get("v")[p], float(store.get("J")[p])
    if not (np.isfinite(x).all() and np.isfinite(v).all()):
        raise _failed(engine, body, p, "position or velocity is not a number (NaN)", _cfl(engine), shorter=True)
    if flag == "inside":
        grid = engine.c.grid
        where = f"x = {_text(x)} m is outside {_text(grid.lower)} to {_text(grid.upper)}"
        if jumped(engine, body):
            cells = engine.places.pace[body]
            what = f"it left the domain in a step in which a particle of the body moved by {cells:.3g} cells: {where}"
            raise _failed(engine, body, p, what, _cfl(engine), shorter=True)
        what = f"it left the domain: {where}"
        fix = 'enlarge the grid, put a Wall or Symmetry on that face, or choose Simulation(leaving="remove") or "clamp"'
        raise _failed(engine, body, p, what, fix)
    if flag == "stretched":
        assert engine.c.shape is not None
        shape = engine.c.shape
        what = f"it has been stretched to more than {2 * shape.max_half:g} cells, farther than {type(shape).__name__} reaches"
        raise _failed(engine, body, p, what, "raise reach, use more particles per cell, or a coarser grid", shorter=True)
    what = "J = det F is not a number (NaN)" if not np.isfinite(J) else f"the material is inverted, J = {J:.4g} <= 0"
    raise _failed(engine, body, p, what, _cfl(engine), shorter=True)


def _failed(engine: Engine, body: int, particle: int | None, what: str, fix: str, shorter: bool = False) -> StabilityError:
    store = engine.stores[body]
    material = type(engine.c.sim.bodies[body].material).__name__
    who = f"particle {store.points_now()[particle]} of body" if particle is not None else "body"
    text = f"{who} {store.name!r} ({material}): {what}, at step {engine.step_number}, t = {engine.t:.6g} s. To fix: {fix}"
    return StabilityError(text, shorter=shorter)


def _cfl(engine: Engine) -> str:
    stepper = engine.c.integrator or engine.c.discretization
    fixed, cfl = getattr(stepper, "dt", None), getattr(stepper, "cfl", None)
    if fixed is not None:
        return f"a smaller dt (now {fixed:.3g} s), or leave dt out for an automatic time step; refine the grid"
    return (
        f"lower cfl (now {cfl:g}), refine the grid, or use a shape function of higher order" if cfl else "refine the grid or the time step"
    )


def _text(x: object) -> str:
    return "(" + ", ".join(f"{float(a):.6g}" for a in np.atleast_1d(np.asarray(x))) + ")"
