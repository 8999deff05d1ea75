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
_TOTALS = ("energy", "total")
_UNITS = {
    "J": ("kinetic", "stored", "dissipated", "external_work", "boundary_work", *_TOTALS),
    "N s": tuple(f"{name}_{axis}" for name in ("momentum", "impulse", "force_impulse") for axis in "xyz"),
    "J s": tuple(f"angular_{axis}" for axis in "xyz"),
    "kg": ("mass",),
    "m^3": ("volume",),
    "s": ("dt",),
}
_UNIT_OF = {name: unit for unit, names in _UNITS.items() for name in names}


def unit_of(results: Results, column: str) -> str:
    """SI unit of a column: as the run says, else as the ledger's columns are known."""
    return str(results.meta.get("units", {}).get(column, _UNIT_OF.get(column, "1")))


def energy_columns(results: Results) -> list[str]:
    """Columns of the history that are energies, without works that stayed zero to rounding."""
    history = results.history
    energies = [name for name in history if unit_of(results, name) == "J"]
    largest = max((float(np.abs(history[name]).max(initial=0.0)) for name in energies), default=0.0)
    return [name for name in energies if not name.endswith("_work") or np.abs(history[name]).max(initial=0.0) > 1e-9 * largest]


def draw_history(results: Results, columns: Sequence[str]) -> Any:
    """Draw columns of the history over time, all of one unit in one panel.

    Raises
    ------
    ResultsError
        If the history has no such column or no rows.
    """
    history = results.history
    units = {name: unit_of(results, name) for name in columns}
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
            total = name in _TOTALS
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
        single = "energy" if unit == "J" else _words(names[0]) if len(names) == 1 else ""
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
    return "total" if name in _TOTALS else name.replace("_", " ")
