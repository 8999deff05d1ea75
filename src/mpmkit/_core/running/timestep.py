"""The time step: limits by rule, the smallest wins and is named."""

from __future__ import annotations

import math

import attrs

from mpmkit._core.composing.limits import stable
from mpmkit._core.running.engine import Engine
from mpmkit.errors import StabilityError


@attrs.frozen
class Limit:
    """A limit of the time step and the rule it comes from; whether it is that of waves, at Courant number 1."""

    dt: float
    rule: str
    waves: bool = False


def limits(engine: Engine) -> list[Limit]:
    """All limits at the present state, at Courant number 1."""
    c = engine.c
    h, dim = c.grid.h, c.dim
    out = []
    affine = c.transfer is not None and c.transfer.affine != "none"
    sum_ = "c + |v| + |C| h" if affine else "c + |v|"  # nodes a cell from a particle get v + C (x_i - x_p)
    for store, row in zip(engine.stores, engine.outs, strict=True):
        if row[0] > 0.0:
            rule = f"wave speed and particle speed of body {store.name!r}, h / ({sum_}) with {sum_} = {row[0]:.6g} m/s"
            out.append(Limit(h / row[0], rule, waves=True))
        if row[1] > 0.0:
            out.append(
                Limit(h * h / (2.0 * dim * row[1]), f"viscosity of body {store.name!r}, h^2 / (2 dim nu) with nu = {row[1]:.6g} m^2/s")
            )
    for role, effect in c.effects.items():
        out += [Limit(1.0 / rate, f"{role}: {rule}, 1 / rate") for rule, rate in effect.rates().items() if rate > 0.0]
    for role, layer in c.layers.items():
        speed = layer.speed()
        if speed > 0.0:
            out.append(Limit(h / speed, f"{role}: prescribed speed {speed:.6g} m/s, one cell per step"))
    return out


def next_step(engine: Engine) -> Limit:
    """The time step to take and the rule that limits it.

    Raises
    ------
    StabilityError
        If a fixed time step exceeds the limit, or no rule limits the step.
    """
    found = limits(engine)
    stepper = engine.c.integrator or engine.c.discretization
    fixed, cfl = getattr(stepper, "dt", None), getattr(stepper, "cfl", 1.0)
    if not found:
        if not any(store.n for store in engine.stores):
            return Limit(fixed if fixed is not None else math.inf, "no particle is left in the domain")
        if fixed is not None:
            return Limit(fixed, "fixed dt; nothing moves or carries waves")
        raise StabilityError("no rule limits the time step (no wave speed, no motion); give the integrator a fixed dt")
    limit = min(found, key=lambda one: one.dt)
    if fixed is None:
        return Limit(cfl * limit.dt, limit.rule)
    limit = min((_as_found(engine, one) for one in found), key=lambda one: one.dt)
    if fixed > limit.dt:
        raise StabilityError(
            f"fixed dt = {fixed:.6g} s is above the stable limit {limit.dt:.6g} s at step {engine.step_number}, t = {engine.t:.6g} s "
            f"({limit.rule}). To fix: dt <= {0.8 * limit.dt:.3g} s, a coarser grid, or leave dt out for an automatic time step"
        )
    return Limit(fixed, f"fixed dt = {fixed:.6g} s; stable up to {limit.dt:.6g} s: {limit.rule}")


def _as_found(engine: Engine, limit: Limit) -> Limit:
    """The limit at the largest Courant number at which the composition was found to be stable, if that is below 1."""
    courant = stable(engine.c).courant
    if not limit.waves or courant >= 1.0:
        return limit
    return Limit(courant * limit.dt, f"{limit.rule}, times {courant:g}, the largest at which these components were found to be stable")


def land(t: float, dt: float, target: float, *, fixed: bool) -> tuple[float, bool]:
    """The step to take so that steps land on `target`, at most `dt`; whether this one does.

    Steps of automatic length are as equal as they can be: a leapfrog keeps its energy with equal steps only. Of fixed ones only the last
    two are shortened, lest one be tiny. A step may be longer than `dt` by one part in 1e9, lest rounding of t cuts one in two.
    """
    left = target - t
    if dt >= left * (1.0 - 1e-9):
        return left, True
    if fixed:
        return (0.5 * left if 2.0 * dt > left else dt), False
    return left / math.ceil(left / dt * (1.0 - 1e-9)), False
