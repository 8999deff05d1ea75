"""The history of a run as lines over time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.drawing import style
from mpmkit._core.drawing.profile import finish_lines
from mpmkit.errors import ResultsError

if TYPE_CHECKING:
    from mpmkit.results import Results

TIME = "t"


def energy_columns(results: Results) -> list[str]:
    """Columns of the history that are energies: by their unit, or by name where a run gives no units."""
    units = results.meta.get("units", {})
    known = ("kinetic", "stored", "dissipated", "external", "external_work", "total")
    return [name for name in results.history if (units.get(name) == "J" if name in units else name in known)]


def draw_history(results: Results, columns: Sequence[str]) -> Any:
    """Draw columns of the history over time, all of one unit in one panel.

    Raises
    ------
    ResultsError
        If the history has no such column or no rows.
    """
    history = results.history
    units = {name: results.meta.get("units", {}).get(name, "J" if name in energy_columns(results) else "1") for name in columns}
    data = {name: np.asarray(history[name]) for name in columns}
    for name, column in data.items():
        if column.dtype.kind not in "if":
            raise ResultsError(f"the history's column {name!r} holds text and cannot be drawn over time")
    time = np.asarray(history[TIME], dtype=float)
    if not len(time):
        raise ResultsError("the history has no rows yet; draw it when the run has made some steps")
    panels = list(dict.fromkeys(units.values()))
    figure = style.new_figure(6.6, 1.0 + 2.7 * len(panels))
    axes = figure.subplots(len(panels), 1, squeeze=False, sharex=True)[:, 0]
    factor, time_unit = style.scaled_unit(float(time[-1]), "s")
    number = 0
    for panel, unit in zip(axes, panels, strict=True):
        names = [name for name in columns if units[name] == unit]
        largest = max(float(np.abs(data[name][np.isfinite(data[name])]).max(initial=0.0)) for name in names)
        scale, shown_unit = style.scaled_unit(largest, unit)
        for name in names:
            total = name == "total"
            colour = style.INK if total else style.BODIES[number % len(style.BODIES)]
            number += not total
            panel.plot(
                time * factor,
                data[name] * scale,
                color=colour,
                linewidth=1.2 if total else 1.7,
                linestyle=(0, (5, 2)) if total else "-",
                label=_words(name),
            )
        single = _words(names[0]) if len(names) == 1 and unit != "J" else "energy" if unit == "J" else ""
        panel.set_ylabel(style.with_unit(single, shown_unit).strip())
        panel.axhline(0, color=style.FAINT, linewidth=0.6, zorder=0)
        panel.margins(x=0)
        panel.spines[["top", "right"]].set_visible(False)
        if len(panels) > 1:
            panel.legend(loc="best", ncols=2)
    axes[-1].set_xlabel(style.with_unit("t", time_unit))
    if len(panels) == 1:
        finish_lines(figure, axes[0])
    return figure


def _words(name: str) -> str:
    return name.replace("_", " ")
