"""The suite's results as Markdown: the default composition, what does not hold and why, the cases in words, all figures."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

Plain = dict[str, Any]
TROUBLE = ("bounded", "fails")


def page(data: Plain) -> str:
    """Everything, as it lies beside the picture."""
    return "\n".join(["# Hard cases\n", origin(data), first(data), troubles(data), in_words(data), everything(data)])


def summary(data: Plain) -> str:
    """What the documentation shows: all but the full table of figures."""
    return "\n".join([first(data), troubles(data), in_words(data), origin(data)])


def origin(data: Plain) -> str:
    """When and with what it was measured."""
    a = data["about"]
    versions = ", ".join(f"{name} {number}" for name, number in a["versions"].items())
    counts = ", ".join(f"{n} {status}" for status, n in count(data).items() if n)
    quick = "Quick runs. " if data["quick"] else ""
    what = f"{len(data['cases'])} cases under {len(data['compositions'])} compositions: {counts}."
    return f"*{quick}{what} {a['date']}, {a['machine']}, Python {a['python']}, {versions}.*\n"


def count(data: Plain) -> dict[str, int]:
    """How many cells have each status."""
    names = ("holds", "bounded", "fails", "refused", "waiting")
    return {name: sum(c["status"] == name for c in data["cells"]) for name in names}


def first(data: Plain) -> str:
    """All cases under the first composition, which is the default."""
    if not data["compositions"]:
        return ""
    cells = {c["case"]: c for c in data["cells"] if c["composition"] == 0}
    rows = []
    for case in data["cases"]:
        c = cells.get(case["name"])
        if c is not None:
            rows.append((case["title"], f"{case['dim']}D", c["status"], *_figures(c), worst(c)))
    head = ("case", "space", "verdict", "energy", "momentum", "margin", "figure with this margin")
    return f"## {data['compositions'][0]['name']}\n\n{table(head, rows)}"


def troubles(data: Plain) -> str:
    """Cells that do not hold, collected by what explains them; those that nothing explains; explanations that are not true."""
    groups: dict[tuple[str, str], list[Plain]] = {}
    for c in data["cells"]:
        if c["status"] in TROUBLE and c["explanation"] is not None:
            groups.setdefault((c["explanation"]["reason"], c["explanation"]["remedy"]), []).append(c)
    out = ["## What does not hold, and why\n"]
    if groups:
        rows = [(_where(data, cells), reason, remedy) for (reason, remedy), cells in groups.items()]
        out.append(table(("where", "why", "remedy"), rows))
    for title, lines in (("Without an explanation", data["unexplained"]), ("Explanations that are not true", data["contradicted"])):
        if lines:
            out += [f"### {title}\n", "\n".join(f"- {escape(line)}" for line in lines) + "\n"]
    if len(out) == 1:
        out.append("Everything holds.\n")
    return "\n".join(out)


def _where(data: Plain, cells: list[Plain]) -> str:
    """Cases with the compositions, in a few words: "free-flight (fails): Linear USL/FLIP, ..."."""
    names: dict[tuple[str, str], list[str]] = {}
    for c in cells:
        column = data["compositions"][c["composition"]]
        names.setdefault((c["case"], c["status"]), []).append(f"{column['group']} {column['label']}")
    by_columns: dict[tuple[str, ...], list[str]] = {}
    for (case, status), columns in names.items():
        by_columns.setdefault(tuple(columns), []).append(f"{case} ({status})")
    return "; ".join(f"{', '.join(cases)}: {', '.join(columns)}" for columns, cases in by_columns.items())


def in_words(data: Plain) -> str:
    """Each case: what goes wrong, the criterion, the source."""
    out = ["## The cases\n"]
    for case in data["cases"]:
        waits = f" *Waits for {escape(case['waits_for'])}.*" if case["waits_for"] else ""
        out.append(
            f"**{escape(case['title'])}** (`{case['name']}`, {case['dim']}D). {escape(case['failure'])} *Criterion:* "
            f"{escape(case['criterion'])} *Source:* {escape(case['source'])}{waits}\n"
        )
    return "\n".join(out)


def everything(data: Plain) -> str:
    """All cells with their figures."""
    rows = []
    for c in data["cells"]:
        column = data["compositions"][c["composition"]]
        figures = "; ".join(f"{f['name']} {number(f['value'])} (limit {number(f['limit'])})" for f in c["figures"])
        rows.append((c["case"], f"{column['group']} {column['label']}", c["status"], *_figures(c), figures or c["reason"].split("\n")[0]))
    return "## All cells\n\n" + table(("case", "composition", "verdict", "energy", "momentum", "margin", "figures or reason"), rows)


def _figures(cell: Plain) -> tuple[str, str, str]:
    return tuple(number(cell[name]) for name in ("energy", "momentum", "margin"))  # type: ignore[return-value]


def worst(cell: Plain) -> str:
    """Name of the figure with the worst margin, with its value and limit; the reason if there is none."""
    if not cell["figures"]:
        return str(cell["reason"].split("\n")[0])

    def margin(f: Plain) -> float:
        value, limit = abs(float(f["value"])), float(f["limit"])
        return value / limit if limit else (0.0 if value == 0.0 else float("inf"))

    f = max(cell["figures"], key=margin)
    return f"{f['name']} {number(f['value'])}, limit {number(f['limit'])}"


def number(value: float | str | None) -> str:
    """Two digits; "" for nothing."""
    if value is None:
        return ""
    if float(value) == 0.0:
        return "0"
    return f"{float(value):.2g}"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *[[escape(cell) for cell in row] for row in rows]]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines) + "\n"


def escape(text: str) -> str:
    """Text with the characters that Markdown would take for its own."""
    return re.sub(r"([\\*_|<>$^~])", r"\\\1", str(text).replace("\n", " "))
