"""One look for all pictures: colours, letters, units."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

INK = "#22262b"
FAINT = "#9aa1a9"
BODIES = ("#2f6db3", "#d9772b", "#3b9b6d", "#8a5fb0", "#c2455a", "#8a7a3d", "#4aa7b8", "#6b7280")
"""Colours of lines and bodies, in this order; distinct also for most colour-blind readers."""
SEQUENTIAL, DIVERGING = "viridis", "coolwarm"
_RC: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.size": 9.5,
    "mathtext.fontset": "dejavusans",
    "text.color": INK,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.titlesize": 10,
    "axes.titlepad": 6,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.major.size": 3,
    "ytick.major.size": 3,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "axes.unicode_minus": True,
    "axes.formatter.limits": (-3, 4),
    "axes.formatter.use_mathtext": True,
    "figure.dpi": 150,
    "savefig.dpi": 150,
}
_PREFIXES = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))
_PREFIXABLE = ("Pa", "J", "N", "s", "m", "W", "m/s", "N s", "J/m", "J/m^2", "J/m^3", "Pa s")


@contextmanager
def styled() -> Iterator[None]:
    """Draw inside this; the caller's own settings come back afterwards."""
    import matplotlib as mpl

    with mpl.rc_context(_RC):
        yield


def new_figure(width: float, height: float) -> Any:
    """A figure of its own, without pyplot: no display, no global state.

    Parameters
    ----------
    width, height : float
        [inch]
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def scaled_unit(largest: float, unit: str) -> tuple[float, str]:
    """Factor and unit that bring numbers up to `largest` into a readable range.

    Returns
    -------
    factor : float
        Multiply SI values by it.
    unit : str
        With prefix, such as "kPa" or "mm".
    """
    if unit not in _PREFIXABLE or not math.isfinite(largest) or largest <= 0:
        return 1.0, unit
    for size, prefix in _PREFIXES:
        # 0.1 of the next larger unit still reads well
        if largest >= size * (0.999 if size != 1.0 else 0.0999):
            return 1 / size, prefix + unit
    return 1.0, unit


def with_unit(label: str, unit: str) -> str:
    """Label of an axis: "von Mises stress [kPa]"; nothing is added for numbers without a unit."""
    if unit in ("1", ""):
        return label
    text = unit.replace("^2", "²").replace("^3", "³").replace("^-1", "⁻¹").replace("*", " ").replace("deg", "°")
    return f"{label} [{text}]"


def time_label(time: float, last: float | None = None) -> str:
    """Title such as "t = 1.25 ms"; the prefix follows `last`, so that all panels of a row share it."""
    factor, unit = scaled_unit(abs(last if last else time), "s")
    return f"t = {time * factor:.4g} {unit}"


def colour_scale(values: Sequence[np.ndarray], signed: bool, limits: tuple[float, float] | None) -> tuple[float, float, str]:
    """Smallest and largest value of the colours, shared by all panels, and where the colour bar is open.

    A few outlying particles do not wash out the rest: if the extreme lies far beyond the 0.5 or 99.5 percentile,
    the scale ends there and the bar gets a tip.
    """
    everything = np.concatenate([v[np.isfinite(v)] for v in values]) if values else np.empty(0)
    if limits is not None:
        low, high = limits
    elif everything.size == 0:
        return 0.0, 1.0, "neither"
    else:
        low, high = float(everything.min()), float(everything.max())
        a, b = np.percentile(everything, (0.5, 99.5))
        span = max(b - a, 1e-300)
        low = float(a) if a - low > 0.6 * span else low
        high = float(b) if high - b > 0.6 * span else high
        if signed:
            high = max(abs(low), abs(high))
            low = -high
        elif low > 0 and low < 0.35 * high:
            low = 0.0
    if high <= low:
        margin = 0.5 * abs(high) or 0.5
        low, high = low - margin, high + margin
    under, over = bool((everything < low).any()), bool((everything > high).any())
    return low, high, {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}[under, over]


def colour_map(signed: bool, name: str | None = None) -> Any:
    """The colour map to use.

    Raises
    ------
    ResultsError
        If matplotlib has no map called `name`.
    """
    import matplotlib as mpl

    from mpmkit.errors import ResultsError, did_you_mean

    wanted = name or (DIVERGING if signed else SEQUENTIAL)
    if wanted not in mpl.colormaps:
        raise ResultsError(f"matplotlib has no colour map {wanted!r}{did_you_mean(wanted, list(mpl.colormaps))}")
    return mpl.colormaps[wanted]


def body_colours(count: int) -> list[str]:
    """A colour for each body."""
    return [BODIES[k % len(BODIES)] for k in range(count)]


def colour_bar(figure: Any, axes: Any, mappable: Any, label: str, extend: str) -> None:
    """A slim colour bar at the right of all panels."""
    bar = figure.colorbar(mappable, ax=axes, label=label, extend=extend, shrink=0.85, aspect=28, pad=0.02, extendfrac=0.035)
    bar.outline.set_visible(False)
    bar.ax.tick_params(length=2.5, width=0.8)
