"""Checks of boundary layers: conditions on single nodal velocities, loads of single particles."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import BoundaryLayer
from mpmkit.testing.calling import call, flat
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.element import Array
from mpmkit.testing.points import sample

NODES = 100
ROUNDING = 1e-13
"""Tolerance (rounding): some hundred machine epsilons of velocities of about 1 m/s."""


def constrains(layer: BoundaryLayer) -> bool:
    """Condition: the layer acts on nodes."""
    return layer.constrain is not None


def at_rest(layer: BoundaryLayer) -> bool:
    """Condition: a layer on nodes that prescribes no motion, such as a wall."""
    return constrains(layer) and layer.speed() == 0.0


def rubs(layer: BoundaryLayer) -> bool:
    """Condition: the layer has friction."""
    return layer.rub is not None


def constrained(layer: BoundaryLayer, given: dict[str, Any]) -> Array:
    """Admissible velocity of a node."""
    assert layer.constrain is not None
    return np.array(call(layer, layer.constrain, given), dtype=float)


@check("boundary", "supplies a hook", once=True)
def supplies_a_hook(layer: BoundaryLayer, rng: Any) -> None:
    """Either node hooks or the particle hook."""
    name = type(layer).__name__
    expect((layer.constrain is None) != (layer.load is None), f"{name} must supply either constrain (nodes) or load (particles)")
    for hook in ("hold", "rub"):
        expect(getattr(layer, hook) is None or layer.constrain is not None, f"{name} supplies {hook} without constrain")
    expect(layer.bilateral or layer.hold is not None, f"{name} lets nodes go (bilateral is False) and must supply hold")


@check("boundary", "applying twice is applying once", when=constrains)
def applying_twice_is_applying_once(layer: BoundaryLayer, rng: Any) -> None:
    """The admissible velocity is admissible."""
    for _ in range(NODES):
        given = sample(layer, rng)
        once = constrained(layer, given)
        expect_close(constrained(layer, given | {"v": tuple(once.tolist())}), once, ROUNDING, "velocity after applying the condition twice")


@check("boundary", "nothing passes a wall at rest", when=at_rest)
def nothing_passes_a_wall(layer: BoundaryLayer, rng: Any) -> None:
    """After a condition at rest no node moves out of the domain, and none is faster than before."""
    for _ in range(NODES):
        given = sample(layer, rng)
        v = constrained(layer, given)
        expect(v @ given["normal"] <= ROUNDING, f"normal velocity {v @ given['normal']:g} m/s out of the domain is left")
        expect(np.linalg.norm(v) <= np.linalg.norm(given["v"]) + ROUNDING, "the condition makes a node faster")


@check("boundary", "friction gains no energy", when=rubs)
def friction_gains_no_energy(layer: Any, rng: Any) -> None:
    """Friction takes tangential velocity, at most its coefficient times the normal velocity, and leaves the normal one."""
    for _ in range(NODES):
        given = sample(layer, rng)
        v = constrained(layer, given)
        after = np.array(call(layer, layer.rub, given | {"v": tuple(v.tolist())}), dtype=float)
        n = np.array(given["normal"])
        expect_close(after @ n, v @ n, ROUNDING, "normal velocity after friction")
        expect(np.linalg.norm(after) <= np.linalg.norm(v) + ROUNDING, "friction makes a node faster")
        limit = getattr(layer, "friction", None)
        if isinstance(limit, float):
            loss = float(np.linalg.norm(after - v))
            expect(loss <= limit * given["dv_n"] + ROUNDING, f"friction takes {loss:g} m/s, more than {limit:g} x {given['dv_n']:g} m/s")
        still = np.array(call(layer, layer.rub, given | {"v": tuple(v.tolist()), "dv_n": 0.0}), dtype=float)
        expect_close(still, v, ROUNDING, "velocity after friction without pressure")


@check("boundary", "load follows the traction", when=lambda layer: layer.load is not None)
def load_follows_the_traction(layer: BoundaryLayer, rng: Any) -> None:
    """Force and arm are three numbers each; the force is linear in the traction, if the layer has one."""
    assert layer.load is not None
    given = sample(layer, rng)
    force, arm = call(layer, layer.load, given)
    expect(len(flat(force)) == 3 and len(flat(arm)) == 3, f"{type(layer).__name__}.load must return (force, arm), three numbers each")
    expect(np.all(np.isfinite(flat((force, arm)))), f"load is not finite: {force}, {arm}")
    if "traction" in layer.load.arguments:
        double, _ = call(layer, layer.load, given | {"traction": tuple(2.0 * t for t in given["traction"])})
        size = float(np.linalg.norm(force))
        expect(size > 0.0, "a traction gives no force")
        expect_close(double, 2.0 * np.array(force), 1e-13 * size, "force of twice the traction")
