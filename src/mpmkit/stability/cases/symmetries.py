"""Symmetries that the equations have: mirror, exchange of axes, order of the particles."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import mpmkit as mpm
from mpmkit.stability.case import Case, Composition, Figure
from mpmkit.stability.cases._disks import GLANCING, SPEED, R, disks, same
from mpmkit.stability.cases._tools import rounding, run

UNTIL = 3.5
MIRROR = np.array([-1.0, 1.0])
EXCHANGED = [1, 0, 2, 3, 5, 4]  # yy xx zz xy yz xz
SOURCE = "Invariance of the equations; two disks that glance off each other, as in Sulsky, Chen and Schreyer (1994) but without symmetry."


def mirrored(x: Any) -> Any:
    """Left and right exchanged."""
    return x * MIRROR


def exchanged(x: Any) -> Any:
    """The axes x and y exchanged."""
    return x[:, ::-1]


def shuffled(x: Any) -> Any:
    """Particles in an arbitrary order, the same for all arrays of one length."""
    return x[np.random.default_rng(7).permutation(len(x))]


def pair(
    composition: Composition, quick: bool, changed: dict[str, Any], back: Callable[[Any], Any], back6: Callable[[Any], Any]
) -> list[Figure]:
    """Run the scene and its image; `back` and `back6` take vectors and stresses of the image to where they should be."""
    h = 1 / 16 if quick else 1 / 32
    grid = mpm.Grid((-1.5, -1.5), (1.5, 1.5), h)
    plain = run(disks(composition, grid, h, GLANCING), UNTIL)
    image = run(disks(composition, grid, h, GLANCING, **changed), UNTIL)
    differences = np.zeros(3)
    order = changed.get("order", same)
    for body in ("left", "right"):
        a, b = plain.particles(body), image.particles(body)
        scales = R, SPEED, np.abs(a["stress"]).max()
        for k, (field, scale, undo) in enumerate(zip(("x", "v", "stress"), scales, (back, back, back6), strict=True)):
            differences[k] = max(differences[k], np.abs(order(a[field]) - undo(b[field])).max() / scale)
    limit = rounding(composition, 1e-10)
    return [
        Figure(f"{name}, difference", float(d), limit) for name, d in zip(("positions", "velocities", "stresses"), differences, strict=True)
    ]


def mirror(composition: Composition, quick: bool) -> list[Figure]:
    """The scene and its mirror image."""
    return pair(composition, quick, {"place": mirrored, "turn": mirrored}, mirrored, lambda s: s * np.array([1, 1, 1, -1, 1, -1]))


def swap(composition: Composition, quick: bool) -> list[Figure]:
    """The scene with its axes exchanged."""
    return pair(composition, quick, {"place": exchanged, "turn": exchanged}, exchanged, lambda s: s[:, EXCHANGED])


def permutation(composition: Composition, quick: bool) -> list[Figure]:
    """The same particles in another order."""
    return pair(composition, quick, {"order": shuffled}, same, same)


CRITERION = (
    "After the impact, at 3.5 s, positions (over the radius), velocities (over the speed) and stresses (over the largest) agree to 1e-10."
)
CASES = (
    Case(
        name="mirror",
        title="Two disks glance off each other, and their mirror image",
        failure="A rule that breaks ties to one side, such as the cell of a particle on a cell face, or a normal that is chosen by "
        "order, makes left and right differ.",
        criterion=CRITERION,
        source=SOURCE,
        dim=2,
        measure=mirror,
        contact=True,
    ),
    Case(
        name="swap-of-axes",
        title="Two disks glance off each other, and the same with x and y exchanged",
        failure="Loops that treat one axis differently: blocks, colours, tensors stored by component, directions taken one after the "
        "other.",
        criterion=CRITERION,
        source=SOURCE,
        dim=2,
        measure=swap,
        contact=True,
    ),
    Case(
        name="permutation",
        title="Two disks glance off each other, with their particles in another order",
        failure="Sums over particles in another order differ by rounding; whatever depends on a particle's number differs by more.",
        criterion=CRITERION,
        source=SOURCE,
        dim=2,
        measure=permutation,
        contact=True,
    ),
)
