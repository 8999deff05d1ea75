"""The suite's results as a picture: cases by compositions, colour and figure in each cell."""

from __future__ import annotations

import math
from os import PathLike
from typing import Any

Plain = dict[str, Any]
LOOKS = {
    "holds": ("#cfe3f3", "#16324a", "holds: every figure is within its limit"),
    "bounded": ("#f2a33c", "#22262b", "bounded: beyond a limit, but no energy made"),
    "fails": ("#6d1532", "#ffffff", "F  fails: stopped by a guard, or energy made"),
    "refused": ("#ffffff", "#6b7280", "R  refused before the first step"),
    "waiting": ("#e3e5e8", "#6b7280", "W  waits for a component"),
}
"""Colour of the cell, of its text, and the legend; light to dark from good to bad, so that grey shows it too."""
WIDEST = 24
"""Columns in one panel at most; further ones stand below, so that the letters stay large."""
WIDE, HIGH = 0.35, 0.28
"""Of a cell [inch]."""
LETTER, HEADING = 0.062, 0.56
"""Mean width of a letter of the labels; height of the headings of groups, which may stand in two lines [inch]."""


def draw(data: Plain, path: str | PathLike[str]) -> None:
    """Draw the matrix as PNG; without cases or compositions there is nothing to draw.

    Parameters
    ----------
    data : dict
        As of `Suite.data`.
    path : path
        The file to write.
    """
    import io

    from PIL import Image

    from mpmkit._core.drawing.style import new_figure, styled

    if not data["cases"] or not data["compositions"]:
        return
    panels = _panels(data["compositions"])
    rows = len(data["cases"])
    names = 0.15 + LETTER * max(len(case["name"]) for case in data["cases"])
    above = [HEADING + 0.1 + LETTER * max(len(data["compositions"][k]["label"]) for k in p) for p in panels]
    tall = [labels + HIGH * rows for labels in above]
    width = names + WIDE * max(max(map(len, panels)), 16) + 0.15
    height = sum(tall) + 0.6
    with styled():
        figure = new_figure(width, height)
        figure.set_layout_engine("none")
        top = height
        for panel, labels, high in zip(panels, above, tall, strict=True):
            box = (names / width, (top - high) / height, WIDE * len(panel) / width, HIGH * rows / height)
            axes = figure.add_axes(box, frameon=False)
            _panel(axes, data, panel, 1.0 + (labels - HEADING + 0.12) / (HIGH * rows))
            top -= high
        _legend(figure, data, height)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png", facecolor="white")
    # few colours: a palette makes the file several times smaller
    Image.open(buffer).convert("RGB").quantize(64).save(path, format="PNG", optimize=True)


def _panels(compositions: list[Plain]) -> list[list[int]]:
    """Numbers of the columns in as few panels as there can be, and these as narrow as they can be."""
    panels = _filled(compositions, WIDEST)
    for widest in range(WIDEST - 1, 0, -1):
        narrower = _filled(compositions, widest)
        if len(narrower) > len(panels):
            break
        panels = narrower
    return panels


def _filled(compositions: list[Plain], widest: int) -> list[list[int]]:
    """Numbers of the columns, whole groups together as far as they fit, as many groups in a panel as it has room for."""
    groups: dict[str, list[int]] = {}
    for k, c in enumerate(compositions):
        groups.setdefault(c["group"], []).append(k)
    panels: list[list[int]] = []
    for members in groups.values():
        pieces = math.ceil(len(members) / widest)
        size = math.ceil(len(members) / pieces)
        for start in range(0, len(members), size):
            piece = members[start : start + size]
            if panels and len(panels[-1]) + len(piece) <= widest:
                panels[-1] += piece
            else:
                panels.append(piece)
    return panels


def _panel(axes: Any, data: Plain, columns: list[int], above: float) -> None:
    """One block of columns under the headings of their groups, which stand at `above` of the block's height."""
    cells = {(c["case"], c["composition"]): c for c in data["cells"]}
    names = [case["name"] for case in data["cases"]]
    axes.set(xlim=(0, len(columns)), ylim=(len(names), 0))
    for y, name in enumerate(names):
        for x, k in enumerate(columns):
            cell = cells.get((name, k))
            if cell is None:
                axes.text(x + 0.5, y + 0.5, "·", ha="center", va="center", color="#9aa1a9", fontsize=7)
                continue
            fill, ink, _ = LOOKS[cell["status"]]
            axes.add_patch(_box(x, y, fill, cell["status"]))
            unexplained = cell["status"] in ("bounded", "fails") and cell["explanation"] is None
            axes.text(x + 0.5, y + 0.5, shown(cell) + ("!" if unexplained else ""), ha="center", va="center", color=ink, fontsize=7)
    labels = [data["compositions"][k]["label"] for k in columns]
    axes.set_xticks([x + 0.5 for x in range(len(columns))], labels, rotation=90, fontsize=7.5)
    axes.set_yticks([y + 0.5 for y in range(len(names))], names, fontsize=7.5)
    axes.xaxis.tick_top()
    axes.tick_params(length=0, pad=2)
    start, raised, filled = 0, False, 0.0
    for x in range(1, len(columns) + 1):
        group = data["compositions"][columns[start]]["group"]
        if x == len(columns) or data["compositions"][columns[x]]["group"] != group:
            middle, half = 0.5 * (start + x), 0.6 * LETTER / WIDE * len(group)
            raised = not raised and middle - half < filled  # where two long names would meet, one stands higher
            filled = middle + half
            _group(axes, start, x, group, above, raised)
            start = x


def _group(axes: Any, start: int, end: int, name: str, y: float, raised: bool) -> None:
    """A heading over the columns of one shape function, and lines that hold them together."""
    place = axes.get_xaxis_transform()
    axes.plot((start + 0.12, end - 0.12), (y, y), color="#22262b", lw=0.9, transform=place, clip_on=False)
    axes.annotate(
        name,
        (0.5 * (start + end), y),
        (0, 13 if raised else 3),
        xycoords=place,
        textcoords="offset points",
        ha="center",
        fontsize=8,
        weight="bold",
    )
    if start:
        axes.plot((start, start), (0, 1), color="#22262b", lw=0.9, transform=place, clip_on=False)


def _box(x: float, y: float, colour: str, status: str) -> Any:
    from matplotlib.patches import Rectangle

    edge = "#b6bcc4" if status == "refused" else "white"
    return Rectangle((x + 0.03, y + 0.04), 0.94, 0.92, facecolor=colour, edgecolor=edge, linewidth=0.6)


def _legend(figure: Any, data: Plain, height: float) -> None:
    from matplotlib.patches import Patch

    from mpmkit.stability.table import count

    found = [name for name, n in count(data).items() if n]
    patches = [Patch(facecolor=LOOKS[n][0], edgecolor="#b6bcc4", linewidth=0.6, label=LOOKS[n][2]) for n in found]
    columns = 3 if figure.get_figwidth() > 9.0 else 2
    looks = {"ncols": columns, "fontsize": 7.5, "handlelength": 1.2, "columnspacing": 1.2}
    figure.legend(handles=patches, loc="lower left", bbox_to_anchor=(0.005, 0.2 / height), **looks)
    note = "Number: worst figure over its limit (∞: of zero). Dot: the case says nothing about the composition. !: not explained."
    figure.text(0.012, 0.08 / height, note, fontsize=7, color="#4b5563")


def shown(cell: Plain) -> str:
    """What stands in a cell: the margin in at most four characters, ∞ beyond a limit of zero, or the letter of the status."""
    letter = {"refused": "R", "waiting": "W"}.get(cell["status"])
    if letter is not None:
        return letter
    if cell["margin"] is None or not math.isfinite(float(cell["margin"])):
        return "F" if cell["status"] == "fails" else "∞"
    return ("F " if cell["status"] == "fails" and float(cell["margin"]) < 10.0 else "") + margin(float(cell["margin"]))


def margin(value: float) -> str:
    """A margin in few characters: 0, .04, .7, 1.3, 24, 3e5."""
    if value < 0.005:
        return "0"
    if value < 0.995:
        return f"{value:.2f}".lstrip("0")
    if value <= 1.0:
        return "1"
    if value < 9.95:
        return f"{max(value, 1.1):.1f}"
    if value < 999.5:
        return f"{value:.0f}"
    return f"{value:.0e}".replace("e+0", "e").replace("e+", "e")
