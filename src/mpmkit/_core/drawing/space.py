"""Particles of a 3D run: lit spheres in a box with scales."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.drawing import style
from mpmkit._core.drawing.floor import Floor
from mpmkit._core.drawing.plane import visible
from mpmkit._core.drawing.quantity import Quantity
from mpmkit._core.drawing.render import render
from mpmkit._core.drawing.sizes import half_edges
from mpmkit._core.drawing.splat import Camera, Raster

if TYPE_CHECKING:
    from mpmkit._core.reading.frame import Frame
    from mpmkit.results import Results

_MANY = 150_000
"""Above this number of particles edges are not smoothed by finer pixels: the particles are small enough."""


def draw_space(
    results: Results,
    frames: Sequence[Frame],
    shown: Quantity,
    *,
    limits: tuple[float, float] | None,
    cmap: str | None,
    window: tuple[tuple[float, float], ...] | None,
    azimuth: float,
    elevation: float,
    floor: bool,
    axes_box: bool,
    softness: float,
) -> Any:
    """Draw frames side by side with one colour scale; see `mpmkit.views.view`."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    values = [shown.values(frame) for frame in frames]
    bounds = np.array(window or visible(results, frames), dtype=float)
    lower, upper = bounds[:, 0], bounds[:, 1]
    camera = Camera.orbit(azimuth, elevation)
    corners = camera.project(np.array([[(lower, upper)[(k >> a) & 1][a] for a in range(3)] for k in range(8)]))
    low, high = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
    columns = len(frames) if len(frames) <= 3 else -(-len(frames) // 2)
    rows = -(-len(frames) // columns)
    size = min(12.0 / columns, 6.0) / float((high - low)[0]), min(9.0 / rows, 5.2) / float((high - low)[1])
    inches = min(size) * (high - low)
    figure = style.new_figure(columns * (inches[0] + 0.7) + 1.1, rows * (inches[1] + 0.75))
    grid = figure.subplots(rows, columns, squeeze=False)
    pixel = float((high - low)[0]) / max(200, round(inches[0] * 150))
    raster = Raster((round(float((high - low)[1]) / pixel), round(float((high - low)[0]) / pixel)), pixel, (float(low[0]), float(low[1])))
    categories = shown.name == "body" and bool(results.bodies)
    first, last, extend = style.colour_scale(values, shown.signed, limits)
    scale, unit = style.scaled_unit(max(abs(first), abs(last)), shown.unit)
    norm, colours = Normalize(first * scale, last * scale), style.colour_map(shown.signed, cmap)
    for panel, frame, value in zip(grid.flat, frames, values, strict=False):
        if categories:
            from matplotlib.colors import to_rgb

            rgb = np.array([to_rgb(c) for c in style.body_colours(len(results.bodies))])[value.astype(int)]
        else:
            rgb = colours(norm(value * scale))[:, :3]
        # a sphere that just covers its cube's faces closes the gaps of the lattice
        radius = 1.15 * half_edges(results, frame)
        picture = render(
            frame["x"].astype(float), radius, rgb, camera, raster, floor=Floor(lower, upper) if floor else None, softness=softness,
            oversample=1 if len(value) > _MANY else 2,
        )  # fmt: skip
        panel.imshow(
            picture,
            extent=(low[0], low[0] + raster.shape[1] * pixel, low[1], low[1] + raster.shape[0] * pixel),
            zorder=3,
            interpolation="antialiased",
        )
        panel.set_axis_off()
        panel.set_aspect("equal")
        if axes_box:
            _box(panel, lower, upper, camera)
        pad = 0.09 * (high - low).max() if axes_box else 0.0
        panel.set(xlim=(low[0] - pad, high[0] + pad), ylim=(low[1] - pad, high[1] + 0.2 * pad))
        panel.set_title(style.time_label(frame.time, max(f.time for f in frames)))
    for panel in grid.flat[len(frames) :]:
        panel.set_axis_off()
    if categories:
        from matplotlib.patches import Patch

        handles = [Patch(color=c, label=name) for c, name in zip(style.body_colours(len(results.bodies)), results.bodies, strict=True)]
        figure.legend(handles=handles, loc="outside right center", handlelength=1.0)
    else:
        style.colour_bar(figure, grid, ScalarMappable(norm, colours), style.with_unit(shown.label, unit), extend)
    return figure


def _box(panel: Any, lower: np.ndarray, upper: np.ndarray, camera: Camera) -> None:
    """Edges of the box behind the particles, and scales along three edges at the outline."""
    factor, unit = style.scaled_unit(float(np.abs([lower, upper]).max()), "m")
    ends = (lower, upper)

    def corner(side: Sequence[int]) -> np.ndarray:
        return np.array([ends[side[a]][a] for a in range(3)])

    nearest = [int(camera.toward[a] > 0) for a in range(3)]
    for axis in range(3):
        others = [a for a in range(3) if a != axis]
        for s in (0, 1):
            for t in (0, 1):
                # an edge of two near faces would cross the particles
                if s == nearest[others[0]] and t == nearest[others[1]]:
                    continue
                side = [0, 0, 0]
                side[others[0]], side[others[1]] = s, t
                start, stop = corner([*side[:axis], 0, *side[axis + 1 :]]), corner([*side[:axis], 1, *side[axis + 1 :]])
                flat = camera.project(np.stack([start, stop]))
                front = side[2] == 0 or axis == 2
                panel.plot(
                    flat[:, 0], flat[:, 1], color=style.FAINT, linewidth=0.7, alpha=0.9 if front else 0.45, zorder=2, solid_capstyle="round"
                )
    middle = camera.project(((lower + upper) / 2)[None])[0]
    for axis, side in _scale_edges(camera, nearest).items():
        start, stop = (corner([*side[:axis], s, *side[axis + 1 :]]) for s in (0, 1))
        _scale(panel, start, stop, axis, camera, middle, factor, style.with_unit("xyz"[axis], unit))


def _scale_edges(camera: Camera, nearest: Sequence[int]) -> dict[int, list[int]]:
    """The edges that carry numbers: two of the bottom toward the viewer, and the leftmost upright one."""
    uprights = [(camera.right[0] * (2 * i - 1) + camera.right[1] * (2 * j - 1), i, j) for i in (0, 1) for j in (0, 1)]
    _, i, j = min(uprights)
    return {0: [0, nearest[1], 0], 1: [nearest[0], 0, 0], 2: [i, j, 0]}


def _scale(
    panel: Any, start: np.ndarray, stop: np.ndarray, axis: int, camera: Camera, middle: np.ndarray, factor: float, label: str
) -> None:
    from matplotlib.ticker import MaxNLocator

    ends = camera.project(np.stack([start, stop]))[:, :2]
    along = ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    if length < 1e-9:
        return  # seen from its end
    outward = np.array([along[1], -along[0]]) / length
    if outward @ (ends.mean(axis=0) - middle[:2]) < 0:
        outward = -outward
    low, high = start[axis] * factor, stop[axis] * factor
    ticks = [t for t in MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high) if low - 1e-9 <= t <= high + 1e-9]
    if axis == 1:
        # its end toward the viewer is the corner where the numbers of x end, too
        ticks = [t for t in ticks if abs(t - (high if camera.toward[1] > 0 else low)) > 0.06 * (high - low)]
    place = {
        "ha": "right" if outward[0] < -0.3 else "left" if outward[0] > 0.3 else "center",
        "va": "top" if outward[1] < -0.3 else "center",
    }
    for tick in ticks:
        at = ends[0] + along * (tick - low) / (high - low)
        panel.annotate(
            "",
            at,
            xytext=4 * outward,
            textcoords="offset points",
            arrowprops={"arrowstyle": "-", "color": style.FAINT, "lw": 0.7, "shrinkA": 0, "shrinkB": 0},
            annotation_clip=False,
        )
        panel.annotate(f"{tick:g}", at, xytext=6.5 * outward, textcoords="offset points", fontsize=7.5, annotation_clip=False, **place)
    panel.annotate(label, ends.mean(axis=0), xytext=25 * outward, textcoords="offset points", annotation_clip=False, **place)
