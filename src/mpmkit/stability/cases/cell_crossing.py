"""The force that uniform stress leaves on the nodes when particles cross cells."""

from __future__ import annotations

from typing import Any

import numpy as np

from mpmkit.exact import cell_crossing_force, gimp
from mpmkit.interfaces import ShapeFunction
from mpmkit.stability.case import Case, Composition, Figure

SPACINGS = (1.1, 1.7, 2.2)  # particles in a cell
OFFSETS = 400
HALF = 0.25  # of a particle that keeps its size: two of them filled a cell


def nodal_forces(composition: Composition, spacing: float) -> Any:
    """Force on a node over stress and area, float64[OFFSETS], by the kernel of the shape function; particles `spacing` cells apart."""
    shape, moments = composition.shape, composition.integrator.transfer.gradient == "moment"
    half = spacing / 2.0 if shape.particle_size == "current" else HALF
    reach = int(np.ceil(shape.nodes / spacing)) + 1
    forces = np.zeros(OFFSETS)
    for k, offset in enumerate(np.arange(OFFSETS) / OFFSETS):
        for p in range(-reach, reach + 1):
            xi = (p + offset) * spacing + 1e-13  # not on a kink, where the slope of tents is not defined
            first = int(np.floor(xi - shape.offset))
            f = xi - first
            w, slopes = shape.weights(f) if shape.particle_size == "none" else shape.weights(f, half)
            if moments:
                arms = np.arange(shape.nodes) - f
                slopes = np.array(w) * arms / (np.array(w) @ arms**2)
            if 0 <= -first < shape.nodes:
                forces[k] += spacing * slopes[-first]
    return forces


def limit(shape: ShapeFunction, spacing: float) -> float:
    """Exact coefficients where the declared facts tell the function, and for all others what uniform GIMP leaves at most."""
    if shape.particle_size == "current":
        return 1e-12
    if shape.particle_size == "initial":
        return cell_crossing_force(gimp(HALF), spacing) + 1e-6
    known = {(2, False): "linear", (3, True): "quadratic B-spline", (4, True): "cubic B-spline"}.get((shape.nodes, shape.smooth))
    return cell_crossing_force(known, spacing) + 1e-6 if known else cell_crossing_force(gimp(HALF), SPACINGS[0] ** -1)


def measure(composition: Composition, quick: bool) -> list[Figure]:
    """Largest force over 400 offsets of the particles, at three spacings."""
    return [
        Figure(
            f"nodal force / stress, {n:g} particles in a cell",
            float(np.abs(nodal_forces(composition, 1 / n)).max()),
            limit(composition.shape, 1 / n),
        )
        for n in SPACINGS
    ]


CASE = Case(
    name="cell-crossing",
    title="The force that uniform stress leaves on a node",
    failure="In an infinite bar under uniform stress no node should feel a force. Where the slope of the shape function jumps, a particle "
    "that crosses a cell face takes its whole force from one node to the next, and the error does not fall with the cell size.",
    criterion="Spacings of h/1.1, h/1.7 and h/2.2, the largest of 400 offsets, over stress: contiguous particles 1e-12; uniform GIMP "
    "0.165, 0.104, 0.041; quadratic B-spline 0.083, 0.104, 0.041; cubic 0.0050, 0.0122, 0.0025; tents 0.909, 0.588, 0.455 (exact values; "
    "1e-6 of tolerance). A shape function of another kind must stay below 0.165.",
    source="Exact sums, mpmkit.exact.cell_crossing_force; Bardenhagen and Kober (2004), doi:10.3970/cmes.2004.005.477; Steffen, Kirby "
    "and Berzins (2008), doi:10.1002/nme.2360",
    dim=1,
    measure=measure,
)
