"""Checks of shape functions: what the core's products over the directions rely on."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.interfaces import ShapeFunction
from mpmkit.testing.calling import call
from mpmkit.testing.collect import check, expect, expect_close
from mpmkit.testing.element import Array

ROUNDING = 1e-13
"""Tolerance (rounding): a few hundred machine epsilons of a weight of size 1."""


def halves(shape: ShapeFunction) -> list[float]:
    """Half sizes to try [cells]: a small one too, if the shape function has particles of a size."""
    return [0.25] if shape.particle_size == "none" else [fraction * shape.max_half for fraction in (1e-6, 0.1, 0.5, 1.0)]


def values(shape: ShapeFunction, f: float, half: float) -> tuple[Array, Array]:
    """Weights and slopes at one place."""
    weights, slopes = call(shape, shape.weights, {"f": float(f), "half": half, "h": 1.0, "dim": 1.0})
    expect(
        len(weights) == shape.nodes and len(slopes) == shape.nodes,
        f"{type(shape).__name__}.weights returns {len(weights)} weights and {len(slopes)} slopes for nodes = {shape.nodes}",
    )
    return np.array(weights), np.array(slopes)


def places(shape: ShapeFunction, rng: Any, n: int = 40) -> Array:
    """Random local coordinates."""
    return np.asarray(shape.offset + rng.uniform(0.0, 1.0, n))


@check("shape", "partition of unity")
def partition_of_unity(shape: ShapeFunction, rng: Any) -> None:
    """Weights add up to 1, so that mass and momentum reach the nodes in full. Tolerance (rounding): 1e-13."""
    for half in halves(shape):
        for f in places(shape, rng):
            weights, _ = values(shape, f, half)
            expect_close(weights.sum(), 1.0, ROUNDING, f"sum of weights at f = {f:.3f}, half = {half:g}")


@check("shape", "slopes add up to zero")
def slopes_add_up_to_zero(shape: ShapeFunction, rng: Any) -> None:
    """A uniform velocity has no gradient, and internal forces add up to zero. Tolerance (rounding): 1e-13."""
    for half in halves(shape):
        for f in places(shape, rng):
            _, slopes = values(shape, f, half)
            expect_close(slopes.sum(), 0.0, ROUNDING, f"sum of slopes at f = {f:.3f}, half = {half:g}")


@check("shape", "linear fields are reproduced")
def linear_fields_are_reproduced(shape: ShapeFunction, rng: Any) -> None:
    """The nodes' places interpolate to the particle's place, with slope 1. Tolerance (rounding): 1e-12."""
    nodes = np.arange(shape.nodes)
    for half in halves(shape):
        for f in places(shape, rng):
            weights, slopes = values(shape, f, half)
            expect_close(weights @ nodes, f, 10 * ROUNDING, f"interpolated place at f = {f:.3f}, half = {half:g}")
            expect_close(slopes @ nodes, 1.0, 10 * ROUNDING, f"slope of the interpolated place at f = {f:.3f}, half = {half:g}")


def lowest(shape: ShapeFunction, rng: Any) -> float:
    """The smallest weight that is found."""
    return min(float(values(shape, f, half)[0].min()) for half in halves(shape) for f in places(shape, rng))


@check("shape", "weights are not negative", when=lambda shape: shape.positive)
def weights_are_not_negative(shape: ShapeFunction, rng: Any) -> None:
    """A negative weight could give a node a negative mass; a shape function that has some declares ``positive = False``."""
    found = lowest(shape, rng)
    expect(found >= -ROUNDING, f"weight {found:.3g} < 0; declare positive = False if that is meant")


@check("shape", "negative weights are there where declared", when=lambda shape: not shape.positive)
def negative_weights_are_there(shape: ShapeFunction, rng: Any) -> None:
    """``positive = False`` warns users; it must be true."""
    found = lowest(shape, rng)
    expect(found < -ROUNDING, f"positive = False is declared, but no weight is below {found:.3g}")


@check("shape", "slopes are derivatives of the weights")
def slopes_are_derivatives(shape: ShapeFunction, rng: Any) -> None:
    """Central differences. Tolerance (rate): second order in the step, which is 1e-4 of the smallest length in the function."""
    for half in halves(shape)[1:] or halves(shape):
        step = 1e-4 * min(half, 1.0)
        for f in places(shape, rng):
            if shape.offset + step < f < shape.offset + 1.0 - step:
                wanted = (values(shape, f + step, half)[0] - values(shape, f - step, half)[0]) / (2.0 * step)
                expect_close(values(shape, f, half)[1], wanted, 1e-3, f"slopes at f = {f:.3f}, half = {half:g}")


@check("shape", "continuous across cells")
def continuous_across_cells(shape: ShapeFunction, rng: Any) -> None:
    """Leaving the range of f at its end is entering it at its start, one node further; the weight that appears or goes is zero."""
    for half in halves(shape):
        last, _ = values(shape, shape.offset + 1.0, half)
        first, _ = values(shape, shape.offset, half)
        expect_close(last[1:], first[:-1], ROUNDING, f"weights on both sides of the jump of the first node, half = {half:g}")
        expect_close([last[0], first[-1]], [0.0, 0.0], ROUNDING, f"weights at the ends of the support, half = {half:g}")


@check("shape", "slopes are continuous where claimed", when=lambda shape: shape.smooth)
def slopes_are_continuous(shape: ShapeFunction, rng: Any) -> None:
    """With ``smooth`` slopes do not jump, neither at a node nor between cells. Tolerance (rate): ten times the distance of 1e-7 cells."""
    step = 1e-7
    for half in halves(shape)[1:] or halves(shape):
        slack = 10.0 * step / min(half, 1.0)
        last, first = values(shape, shape.offset + 1.0 - step, half)[1], values(shape, shape.offset + step, half)[1]
        expect_close(last[1:], first[:-1], slack, f"slopes on both sides of the jump of the first node, half = {half:g}")
        expect_close([last[0], first[-1]], [0.0, 0.0], slack, f"slopes at the ends of the support, half = {half:g}")
        for f in shape.offset + np.arange(1, 16) / 16.0:
            before, after = values(shape, f - step, half)[1], values(shape, f + step, half)[1]
            expect_close(after, before, slack, f"slopes on both sides of f = {f:.4f}, half = {half:g}")


@check("shape", "mirror symmetric")
def mirror_symmetric(shape: ShapeFunction, rng: Any) -> None:
    """The mirrored particle has the mirrored weights: no direction is preferred. Tolerance (rounding): 1e-13 for weights."""
    for half in halves(shape):
        for f in places(shape, rng):
            weights, slopes = values(shape, f, half)
            mirrored, mirrored_slopes = values(shape, shape.nodes - 1.0 - f, half)
            expect_close(mirrored[::-1], weights, ROUNDING, f"weights at f = {f:.3f}, half = {half:g}")
            # at a kink of the weights either slope is right; random places do not hit one
            expect_close(-mirrored_slopes[::-1], slopes, 10 * ROUNDING / min(half, 1.0), f"slopes at f = {f:.3f}, half = {half:g}")


@check("shape", "declared order is reproduced")
def declared_order_is_reproduced(shape: ShapeFunction, rng: Any) -> None:
    """For every degree up to ``order`` there are nodal values that give that power of f in the cell; tolerance (rounding): 1e-10."""
    half = halves(shape)[0]
    f = shape.offset + np.linspace(0.01, 0.99, 25)
    weights = np.array([values(shape, x, half)[0] for x in f])
    for degree in range(shape.order + 1):
        wanted = (f - shape.offset) ** degree
        found = weights @ np.linalg.lstsq(weights, wanted, rcond=None)[0]
        expect_close(found, wanted, 1e-10, f"degree {degree} of the declared order {shape.order}")


@check("shape", "describes its support", once=True)
def describes_its_support(shape: ShapeFunction, rng: Any) -> None:
    """The declared facts fit each other."""
    name = type(shape).__name__
    expect(shape.particle_size in ("none", "initial", "current"), f"{name}.particle_size is {shape.particle_size!r}")
    expect(
        ("half" in shape.weights.arguments) == (shape.particle_size != "none"),
        f"{name}: the kernel asks for half, or not, against particle_size",
    )
    expect(
        2.0 * shape.offset == shape.nodes - 2, f"{name}: {shape.nodes} nodes around the particle need offset = {(shape.nodes - 2) / 2:g}"
    )
