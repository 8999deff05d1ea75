"""Fields of a 1D run along x."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.drawing import style
from mpmkit._core.drawing.plane import visible
from mpmkit._core.drawing.quantity import Quantity

if TYPE_CHECKING:
    from mpmkit._core.reading.frame import Frame
    from mpmkit.results import Results


def draw_profile(
    results: Results,
    frames: Sequence[Frame],
    shown: Quantity,
    *,
    exact: Callable[[np.ndarray, float], np.ndarray] | None,
    window: tuple[tuple[float, float], ...] | None,
) -> Any:
    """A line per body and time, with a dot per particle; the exact solution, if given, as a thin dark line."""
    import matplotlib as mpl

    figure = style.new_figure(6.6, 3.8)
    axes = figure.subplots()
    values = [shown.values(frame) for frame in frames]
    ((x0, x1),) = window or visible(results, frames)
    length, length_unit = style.scaled_unit(max(abs(x0), abs(x1)), "m")
    largest = max((float(np.abs(v[np.isfinite(v)]).max(initial=0.0)) for v in values), default=0.0)
    scale, unit = style.scaled_unit(largest, shown.unit)
    last = max(frame.time for frame in frames)
    many = len(frames) > 1
    for k, (frame, value) in enumerate(zip(frames, values, strict=True)):
        numbers = frame["body"] if "body" in frame else np.zeros(len(value), dtype=int)
        for number in np.unique(numbers).astype(int):
            chosen = np.flatnonzero(numbers == number)
            order = chosen[np.argsort(frame["x"][chosen, 0])]
            # several times: the colour is the time; one time: it is the body
            colour = mpl.colormaps["viridis"](0.88 * k / max(1, len(frames) - 1)) if many else style.BODIES[number % len(style.BODIES)]
            name = results.bodies[number] if number < len(results.bodies) else ""
            label = (
                style.time_label(frame.time, last)
                if many and number == numbers.min()
                else name
                if not many and (len(results.bodies) > 1 or exact is not None)
                else None
            )
            marker = "o" if len(order) <= 150 else None
            axes.plot(
                frame["x"][order, 0] * length,
                value[order] * scale,
                color=colour,
                marker=marker,
                markersize=2.6,
                linewidth=1.2,
                label=label,
                zorder=2,
            )
        if exact is not None:
            at = np.linspace(x0, x1, 2001)
            label = "exact" if k == len(frames) - 1 else None
            axes.plot(at * length, np.asarray(exact(at, frame.time)) * scale, color=style.INK, linewidth=0.9, label=label, zorder=1)
    axes.axhline(0, color=style.FAINT, linewidth=0.6, zorder=0)
    axes.set(xlim=(x0 * length, x1 * length), xlabel=style.with_unit("x", length_unit), ylabel=style.with_unit(shown.label, unit))
    if not many:
        axes.set_title(style.time_label(last), loc="left")
    finish_lines(figure, axes)
    return figure


def finish_lines(figure: Any, axes: Any) -> None:
    """Open frame, and a legend above the lines if any line has a name."""
    axes.spines[["top", "right"]].set_visible(False)
    handles, _ = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 5), handlelength=1.6, columnspacing=1.6)
