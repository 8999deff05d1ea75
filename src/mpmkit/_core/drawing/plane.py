"""Particles of a 2D run as squares of their true size."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.drawing import style
from mpmkit._core.drawing.quantity import Quantity
from mpmkit._core.drawing.sizes import deformed, half_edges
from mpmkit.errors import ResultsError

if TYPE_CHECKING:
    from mpmkit._core.reading.frame import Frame
    from mpmkit.results import Results

MARKERS = ("square", "disc", "deformed")


def draw_plane(
    results: Results,
    frames: Sequence[Frame],
    shown: Quantity,
    *,
    limits: tuple[float, float] | None,
    cmap: str | None,
    window: tuple[tuple[float, float], ...] | None,
    marker: str,
) -> Any:
    """Draw frames side by side with one colour scale; see `mpmkit.views.view`."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.ticker import MaxNLocator

    if marker not in MARKERS:
        raise ResultsError(f"marker must be one of {', '.join(MARKERS)}, got {marker!r}")
    values = [shown.values(frame) for frame in frames]
    (x0, x1), (y0, y1) = window or visible(results, frames)
    columns, rows = _arrangement(len(frames), (x1 - x0) / (y1 - y0))
    width, height = panel_size(x1 - x0, y1 - y0, columns, rows)
    figure = style.new_figure(width * columns + 1.5, height * rows + 0.75)
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    factor, length_unit = style.scaled_unit(max(abs(v) for v in (x0, x1, y0, y1)), "m")
    categories = shown.name == "body" and bool(results.bodies)
    if categories:
        colours, extend, scale, unit = ListedColormap(style.body_colours(len(results.bodies))), "neither", 1.0, "1"
        norm: Any = Normalize(-0.5, len(results.bodies) - 0.5)
    else:
        low, high, extend = style.colour_scale(values, shown.signed, limits)
        scale, unit = style.scaled_unit(max(abs(low), abs(high)), shown.unit)
        colours, norm = style.colour_map(shown.signed, cmap), Normalize(low * scale, high * scale)
    ticks = MaxNLocator(5 if columns == 1 else 3, steps=[1, 2, 2.5, 5, 10])
    for k, (panel, frame, value) in enumerate(zip(axes.flat, frames, values, strict=False)):
        shapes = PolyCollection(
            list(_shapes(results, frame, marker) * factor), array=value * scale, cmap=colours, norm=norm, edgecolors="face", linewidths=0.4,
            rasterized=len(value) > 2000,
        )  # fmt: skip
        panel.add_collection(shapes)
        panel.set(xlim=(x0 * factor, x1 * factor), ylim=(y0 * factor, y1 * factor), aspect="equal")
        panel.set_title(style.time_label(frame.time, max(f.time for f in frames)))
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_locator(ticks)
            axis.set_major_formatter("{x:g}")
        names = ("r", "z") if results.meta.get("space") == "axisymmetric" else ("x", "y")
        if k >= len(frames) - columns:
            panel.set_xlabel(style.with_unit(names[0], length_unit))
            panel.tick_params(labelbottom=True)
        if k % columns == 0:
            panel.set_ylabel(style.with_unit(names[1], length_unit))
    for panel in axes.flat[len(frames) :]:
        panel.set_axis_off()
    if categories:
        from matplotlib.patches import Patch

        handles = [
            Patch(color=colour, label=name) for colour, name in zip(style.body_colours(len(results.bodies)), results.bodies, strict=True)
        ]
        figure.legend(handles=handles, loc="outside right center", handlelength=1.0)
    else:
        style.colour_bar(figure, axes, ScalarMappable(norm, colours), style.with_unit(shown.label, unit), extend)
    return figure


def visible(results: Results, frames: Sequence[Frame]) -> tuple[tuple[float, float], ...]:
    """Lower and upper end of what is shown in each direction [m].

    The whole grid, if the particles of these frames fill at least two fifths of it; else they and a margin.
    """
    points = np.concatenate([frame["x"] for frame in frames]).astype(float)
    grid = results.meta.get("grid") or {}
    if len(points) == 0:
        return tuple(zip(grid["lower"], grid["upper"], strict=True)) if grid else ((0.0, 1.0),) * points.shape[1]
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.06 * float((high - low).max() or 1.0)
    if grid:
        lower, upper = np.atleast_1d(grid["lower"]).astype(float), np.atleast_1d(grid["upper"]).astype(float)
        if ((high - low) >= 0.4 * (upper - lower)).all():
            return tuple(zip(lower.tolist(), upper.tolist(), strict=True))
        return tuple(zip(np.maximum(low - margin, lower).tolist(), np.minimum(high + margin, upper).tolist(), strict=True))
    return tuple(zip((low - margin).tolist(), (high + margin).tolist(), strict=True))


def panel_size(dx: float, dy: float, columns: int, rows: int) -> tuple[float, float]:
    """Width and height [inch] of one panel with its letters, so that the figure is neither tiny nor a poster."""
    widest, tallest = min(6.2, 13.5 / columns), min(5.4, 9.0 / rows)
    size = min(widest / dx, tallest / dy)
    return max(size * dx, 1.6) + 0.45, max(size * dy, 1.1) + 0.4


def _arrangement(count: int, aspect: float) -> tuple[int, int]:
    """Columns and rows: wide panels go below each other, others side by side."""
    if count <= 1:
        return 1, 1
    if aspect > 2.5:
        return (1, count) if count <= 5 else (2, -(-count // 2))
    columns = min(count, 4 if count % 4 == 0 or count > 6 else 3 if count > 2 else 2)
    return columns, -(-count // columns)


def _shapes(results: Results, frame: Frame, marker: str) -> np.ndarray:
    """Corners of each particle, float64[n, k, 2] [m]."""
    if marker == "deformed":
        return deformed(frame)
    x, half = frame["x"].astype(float), half_edges(results, frame)
    if marker == "square":
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)
    else:
        angle = np.linspace(0, 2 * np.pi, 17)[:-1]
        corners = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.asarray(x[:, None, :2] + half[:, None, None] * corners)
