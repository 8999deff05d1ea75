"""Pictures of a study: what accuracy costs in time (work-precision), and how errors fall with the resolution (convergence)."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from mpmkit._core.drawing import style
from mpmkit.errors import ResultsError, did_you_mean
from mpmkit.studies import fit
from mpmkit.studies.numbers import exponent, number, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mpmkit.studies.results import Row, StudyResults

ENDINGS = (".png", ".svg")
WORK, CONVERGENCE = "work-precision", "convergence"
KINDS = (WORK, CONVERGENCE)
COLOURS = ("#2f6db3", "#d9772b", "#3b9b6d", "#3e1e38", "#792bee", "#760a0a", "#191966", "#a298cd")
"""Of compositions. The first three are those of all pictures; the others were chosen by their distance as readers with protanopia,
deuteranopia or tritanopia see them (Machado, Oliveira and Fernandes 2009), to whom some of the colours of bodies look alike."""
IN_THE_DARK = ("#5b8fe8", "#f0994f", "#5cc291", "#8a427b", "#792bee", "#bd0f32", "#b3c3db", "#eeee2b")
"""The same on a dark page."""
MARKERS = "os^DvPX*hp<>"
"""One for each resolution, coarse to fine."""
DASHES = ("-", (0, (5, 1.5)), (0, (1.5, 1.5)), (0, (6, 1.5, 1.5, 1.5)))
"""A second sign of the composition, after each half of the colours."""
WIDTH, HEIGHT, LEGEND_LINE = 4.9, 3.9, 0.19  # inch
FRONT = "nothing is faster and better"
ANNOTATED = 6
"""Most compositions whose orders are written beside their lines."""
FEW = 4
"""Most compositions that get a colour each, even if they are a product of two axes."""
KNOWN = 1.5
"""Largest half width of the confidence interval of an order whose line and slope are drawn; more than that is scatter."""
EDGE = 0.055
"""Share of a panel for runs without a result."""


def draw(results: StudyResults, measure: str | None = None, kind: str | None = None) -> Figure:
    """Draw a study: a row for each error, with the work-precision diagram and the convergence beside each other; of one kind two in a row.

    Parameters
    ----------
    results : StudyResults
        The study.
    measure : str, optional
        One error only.
    kind : str, optional
        "work-precision" or "convergence"; both if not given, as far as there is something to draw.

    Raises
    ------
    ResultsError
        If there is no such error or kind, or nothing to draw.
    """
    measures = _measures(results, measure)
    if kind is not None and kind not in KINDS:
        raise ResultsError(f"a study has no picture {kind!r}{did_you_mean(kind, KINDS)} (it has {', '.join(KINDS)})")
    kinds = [k for k in KINDS if kind in (None, k) and any(drawable(results, m, k) for m in measures)]
    if not kinds:
        raise ResultsError(f"there is nothing to draw: no run has {'an error' if kind == CONVERGENCE else 'an error and a time'}")
    looks, parts = Looks.of(results), results.parts()
    rows = [(m, problem, part) for m in measures for problem, part in parts.items() if any(drawable(part, m, k) for k in kinds)]
    alone = len(rows) == 1
    with style.styled():
        handles = _legend(rows[0][2], kinds, measures[0] if alone else None, looks, results)
        widest = 0.45 + 0.062 * max(len(h.get_label()) for h in handles)  # inch
        places = [(*row, which) for row in rows for which in kinds]
        abreast = len(kinds) if len(kinds) > 1 else min(2, len(places))
        columns = max(1, min(4, int(WIDTH * abreast / widest)))
        height = HEIGHT * -(-len(places) // abreast) + LEGEND_LINE * -(-len(handles) // columns)
        figure: Figure = style.new_figure(WIDTH * abreast, height)
        grid: Any = figure.subplots(-(-len(places) // abreast), abreast, squeeze=False)
        for axes, place in itertools.zip_longest(grid.ravel(), places):
            if place is None:
                axes.remove()
                continue
            one, problem, part, which = place
            if which == WORK:
                _work(axes, part, one, looks)
            else:
                _convergence(axes, part, one, looks, alone)
            axes.set_title(problem, loc="left")
        figure.suptitle(results.name, x=0.01, ha="left", fontweight="bold", fontsize=11)
        shape = {"ncols": columns, "fontsize": 8.5, "handlelength": 2.4, "columnspacing": 1.5}
        figure.legend(handles=handles, loc="outside lower left", **shape)
    return figure


def save(results: StudyResults, path: str | os.PathLike[str], measure: str | None = None, kind: str | None = None) -> Figure:
    """Draw a study into a file, by its ending .png or .svg; see `draw`.

    Raises
    ------
    ResultsError
        As `draw`, for another ending, or if the file cannot be written.
    """
    path = Path(path)
    if path.suffix not in ENDINGS:
        raise ResultsError(f"cannot draw to {path}: a picture of a study ends in {' or '.join(ENDINGS)}")
    figure = draw(results, measure, kind)
    import matplotlib as mpl

    salt: dict[Any, Any] = {"svg.hashsalt": results.name}  # the same picture has the same text
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with mpl.rc_context(salt):
            figure.savefig(path, metadata={"Date": None} if path.suffix == ".svg" else None)
    except OSError as error:
        raise ResultsError(f"cannot write {path}: {error.strerror or error}; choose another place") from None
    return figure


def svg(results: StudyResults, measure: str, kind: str, prefix: str) -> str:
    """One picture as an element for a page: letters and lines in the colours of the page, other colours as variables --c0, --c1 ...

    Parameters
    ----------
    prefix : str
        Put before all identifiers, which must differ between the pictures of a page.
    """
    import io
    import re

    import matplotlib as mpl

    figure = draw(results, measure, kind)
    figure.suptitle("")
    out = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": prefix, "svg.fonttype": "none"}):
        figure.savefig(out, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    text = out.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{prefix}-', text)
    text = re.sub(r'(href="#|url\(#)', rf"\g<1>{prefix}-", text)
    for k, colour in enumerate(COLOURS):
        text = text.replace(colour, f"var(--c{k}, {colour})")
    text = text.replace(style.INK, "currentColor").replace(style.FAINT, f"var(--faint, {style.FAINT})")
    head = f'<svg role="img" aria-label="{escape(f"{results.name}: {kind}, {measure}", quote=True)}"'
    return text.replace("<svg", head, 1)


def _measures(results: StudyResults, measure: str | None) -> list[str]:
    if measure is None:
        return list(results.measures)
    if measure not in results.measures:
        raise ResultsError(
            f"the study has no error {measure!r}{did_you_mean(measure, results.measures)} (it has {', '.join(results.measures) or 'none'})"
        )
    return [measure]


def drawable(results: StudyResults, measure: str, kind: str) -> bool:
    """Whether there is something to draw."""
    rows = [r for r in results.done(measure) if r["errors"][measure] > 0.0]
    if kind == WORK:
        return any(r["seconds"] for r in rows)
    return len({r["resolution"] for r in rows if r["resolution"]}) > 1


@attrs.frozen
class Looks:
    """How runs are drawn, the same in all panels.

    Attributes
    ----------
    colours : dict
        Colour and dashes of each composition.
    sizes : dict
        Of marks and lines of each composition, from 1.6 down to 1: those drawn first show below equal ones drawn later.
    markers : dict
        Marker of each resolution.
    """

    colours: dict[str, tuple[str, Any]]
    sizes: dict[str, float]
    markers: dict[float, str]

    @classmethod
    def of(cls, results: StudyResults) -> Looks:
        """Those of a study."""
        parts = results.parts().values()
        names = list(dict.fromkeys(name for part in parts for name in part.compositions()))
        last = max(len(names) - 1, 1)
        resolutions = sorted({r["resolution"] for r in results if r["resolution"]}, reverse=True)
        return cls(
            _crossed([row for part in parts for row in part]) if len(names) > FEW else _in_turn(names),
            {name: 1.0 + 0.6 * (last - k) / last if len(names) > 1 else 1.0 for k, name in enumerate(names)},
            {h: MARKERS[k % len(MARKERS)] for k, h in enumerate(resolutions)},
        )


def _in_turn(names: list[str]) -> dict[str, tuple[str, Any]]:
    """Colours in turn; dashes change when half of them have been used, so that no two of 16 are the same."""
    return {name: (COLOURS[k % len(COLOURS)], DASHES[2 * k // len(COLOURS) % len(DASHES)]) for k, name in enumerate(names)}


def _crossed(rows: list[Row]) -> dict[str, tuple[str, Any]]:
    """Compositions that are a product of two axes: colours for the longer one, dashes for the other; else in turn."""
    names = list(dict.fromkeys(row["composition"] for row in rows))
    product = [row for row in rows if set(row["labels"]) == set(rows[0]["labels"])]  # without further runs that have a name
    choices = {name: [row["labels"] for row in product if row["composition"] == name] for name in names}
    axes = {axis: list(dict.fromkeys(row["labels"][axis] for row in product)) for axis in product[0]["labels"]}
    fixed = [a for a in axes if all(len({labels[a] for labels in found}) <= 1 for found in choices.values())]
    varied = sorted((a for a in fixed if len(axes[a]) > 1), key=lambda a: -len(axes[a]))
    others = [name for name in names if not choices[name]]
    if len(varied) != 2 or len(axes[varied[0]]) + len(others) > len(COLOURS) or len(axes[varied[1]]) > len(DASHES):
        return _in_turn(names)
    colour, dash = varied
    found = {n: (COLOURS[axes[colour].index(c[0][colour])], DASHES[axes[dash].index(c[0][dash])]) for n, c in choices.items() if c}
    return found | {name: (COLOURS[len(axes[colour]) + k], DASHES[0]) for k, name in enumerate(others)}


def _work(axes: Axes, results: StudyResults, measure: str, looks: Looks) -> None:
    """Error against seconds, with the spread of the times as bars and the Pareto front."""
    _log(axes, measure)
    axes.set_xlabel("wall time of stepping [s]")
    best = fit.front(_above_zero(results.done(measure), measure), measure)
    for name, rows in results.series(measure).items():
        colour, dash = looks.colours[name]
        timed = [r for r in _above_zero(rows, measure) if r["seconds"]]
        x, y = [r["seconds"] for r in timed], [r["errors"][measure] for r in timed]
        axes.plot(x, y, color=colour, linestyle=dash, linewidth=1.2 * looks.sizes[name], zorder=2)
        spread = [[r["seconds"] - r["seconds_low"] for r in timed], [r["seconds_high"] - r["seconds"] for r in timed]]
        axes.errorbar(x, y, xerr=spread, fmt="none", ecolor=colour, elinewidth=0.9, capsize=2.0, zorder=2)
        for row in timed:
            mark = looks.markers.get(row["resolution"], "o")
            axes.plot(row["seconds"], row["errors"][measure], mark, color=colour, markersize=5.5 * looks.sizes[name], zorder=3)
    if best:
        x, y = [r["seconds"] for r in best], [r["errors"][measure] for r in best]
        end = axes.get_xlim()[1]
        axes.step([*x, end], [*y, y[-1]], where="post", color=style.FAINT, linewidth=5.0, alpha=0.35, zorder=1, solid_joinstyle="round")
        axes.set_xlim(right=end)
    _numbers(axes.xaxis)
    _numbers(axes.yaxis)
    _edge(axes, [r for r in results if r["status"] != "done"], looks)


def _edge(axes: Axes, lost: list[Row], looks: Looks) -> None:
    """Runs without a result, one below the other in a strip at the right edge."""
    if not lost:
        return
    from matplotlib.patches import Rectangle

    left, right = axes.get_xlim()
    axes.set_xlim(left, right * (right / left) ** (2.0 * EDGE))
    shade: dict[str, Any] = {"facecolor": style.FAINT, "alpha": 0.13, "linewidth": 0, "zorder": 0}
    axes.add_patch(Rectangle((1.0 - EDGE, 0.0), EDGE, 1.0, transform=axes.transAxes, **shade))
    step = min(0.06, 0.92 / len(lost))
    for k, row in enumerate(lost):
        x, y = 1.0 - 0.5 * EDGE, 0.955 - k * step
        looked: dict[str, Any] = {"color": looks.colours[row["composition"]][0], "transform": axes.transAxes}
        axes.plot(x, y, looks.markers.get(row["resolution"], "o"), markersize=5.5, alpha=0.35, **looked)
        axes.plot(x, y, "x", markersize=6.5, markeredgewidth=1.4, zorder=5, **looked)
        if step > 0.03:
            told: dict[str, Any] = {"color": style.INK, "fontsize": 7, "ha": "right", "va": "center"}
            axes.text(1.0 - EDGE - 0.01, y, row["status"], transform=axes.transAxes, **told)


def _convergence(axes: Axes, results: StudyResults, measure: str, looks: Looks, alone: bool) -> None:
    """Error against resolution, with fitted lines and reference slopes; runs without a result stand at the upper edge."""
    _log(axes, measure)
    axis = results.meta.get("resolution") or {"name": "resolution", "unit": "1"}
    axes.set_xlabel(style.with_unit(axis["name"], axis.get("unit", "1")))
    fitted = []
    for name, rows in results.series(measure).items():
        colour, dash = looks.colours[name]
        kept = [r for r in _above_zero(rows, measure) if r["resolution"]]
        for row in kept:
            mark = looks.markers[row["resolution"]]
            axes.plot(row["resolution"], row["errors"][measure], mark, color=colour, markersize=5.5 * looks.sizes[name], zorder=3)
        found = fit.order(rows, measure)
        axes.plot(
            [r["resolution"] for r in kept], [r["errors"][measure] for r in kept], color=colour, linestyle=":", linewidth=0.9, zorder=2
        )
        if found is not None and found.high - found.slope < KNOWN:
            ends = [found.finest, max(r["resolution"] for r in kept)]
            axes.plot(ends, [found.at(h) for h in ends], color=colour, linestyle=dash, linewidth=1.4 * looks.sizes[name], zorder=2)
            fitted.append(found.slope)
            if not alone and len(looks.colours) <= ANNOTATED:
                told: dict[str, Any] = {"color": colour, "fontsize": 7.5, "textcoords": "offset points", "xytext": (5, -9)}
                axes.annotate(exponent(found.slope), (ends[0], found.at(ends[0])), **told)
    _slopes(axes, fitted)
    _numbers(axes.yaxis)
    places = sorted({r["resolution"] for r in results if r["resolution"]})
    _ticks(axes, places)
    count: dict[float, int] = {}
    for row in results:
        if row["status"] != "done" and row["resolution"]:
            k = count[row["resolution"]] = count.get(row["resolution"], -1) + 1
            where = axes.get_xaxis_transform()
            colour = looks.colours[row["composition"]][0]
            axes.plot(
                row["resolution"], 0.975 - 0.045 * k, "x", color=colour, transform=where, markersize=6.5, markeredgewidth=1.4, zorder=5
            )


def _slopes(axes: Axes, fitted: Iterable[float]) -> None:
    """Triangles of the whole orders that lie nearest to the fitted ones, in the lower right corner."""
    whole = sorted({max(1, round(p)) for p in fitted if p > 0.25})[:4]
    if not whole:
        return
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    end, start = right * (left / right) ** 0.04, right * (left / right) ** 0.19
    base = low * (high / low) ** 0.05
    axes.set_xlim(left, right)
    for p in whole:
        top = base * (end / start) ** p
        if top > high:
            continue
        axes.plot([start, end, end], [base, top, base], color=style.FAINT, linewidth=0.9, zorder=1)
        axes.text(end, top, f" {p}", color=style.INK, fontsize=7.5, ha="left", va="center", zorder=1)
    axes.plot([start, end], [base, base], color=style.FAINT, linewidth=0.9, zorder=1)
    axes.set_ylim(low, high)


def _ticks(axes: Axes, places: list[float]) -> None:
    """Ticks at the resolutions themselves, as far as there is room for their numbers."""
    import math

    from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

    left, right = axes.get_xlim()
    room = math.log(right / left) / 9.0
    kept: list[float] = []
    for h in sorted(places):
        if not kept or math.log(h / kept[-1]) > room:
            kept.append(h)
    axes.xaxis.set_major_locator(FixedLocator(kept))
    axes.xaxis.set_major_formatter(FixedFormatter([number(h, 3) for h in kept]))
    axes.xaxis.set_minor_locator(NullLocator())


def _numbers(axis: Any) -> None:
    """Plain numbers at 1, 2, 5 where an axis is shorter than two decades; powers of ten elsewhere."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

    low, high = axis.get_view_interval()
    if high / low < 100.0:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high / low > 4.0 else (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: number(value)))
        axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def _log(axes: Axes, measure: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylabel(f"error: {measure.replace('^2', '²').replace('^3', '³')}")
    axes.grid(color=style.FAINT, linewidth=0.4, alpha=0.5)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def _above_zero(rows: Iterable[Row], measure: str) -> list[Row]:
    return [r for r in rows if r["errors"].get(measure, 0.0) > 0.0]


def _legend(part: StudyResults, kinds: list[str], measure: str | None, looks: Looks, whole: StudyResults) -> list[Any]:
    """Compositions, with their orders if one error is drawn; then resolutions and what else there is."""
    from matplotlib.lines import Line2D

    found = fit.orders(part, measure) if measure and CONVERGENCE in kinds else {}
    out = []
    for name, (colour, dash) in looks.colours.items():
        order = found.get(name)
        told = f"{name}: order {exponent(order.slope)} ± {exponent(order.high - order.slope)}" if order is not None else name
        out.append(Line2D([], [], color=colour, linestyle=dash, label=told))
    if WORK in kinds:
        out.append(Line2D([], [], color=style.FAINT, linewidth=5.0, alpha=0.35, label=FRONT))
        unit = (whole.meta.get("resolution") or {}).get("unit", "1")
        for h, mark in looks.markers.items():
            out.append(Line2D([], [], color=style.INK, marker=mark, linestyle="", markersize=5.5, label=plain(h, unit, 3)))
    if any(r["status"] != "done" for r in whole):
        out.append(Line2D([], [], color=style.INK, marker="x", linestyle="", markeredgewidth=1.4, label="no result"))
    return out
