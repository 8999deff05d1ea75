"""A study as one HTML file: sentences, pictures, tables, scene, versions and machine; nothing is loaded from elsewhere."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpmkit.studies import fit, pictures, sentences
from mpmkit.studies.numbers import exponent, number, plain
from mpmkit.studies.results import write

if TYPE_CHECKING:
    from mpmkit.studies.results import StudyResults


def _variables(colours: Sequence[str]) -> str:
    """Colours of compositions as variables of the page."""
    return " ".join(f"--c{k}: {colour};" for k, colour in enumerate(colours))


STYLE = """
:root { color-scheme: light dark; --paper: #ffffff; --ink: #22262b; --faint: #9aa1a9; --line: #dfe2e6; --soft: #f4f5f7;
  LIGHT }
@media (prefers-color-scheme: dark) { :root { --paper: #16181b; --ink: #e4e6e9; --faint: #7d858e; --line: #33383e; --soft: #1f2327;
  DARK } }
.mpmkit-study { background: var(--paper); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; }
.mpmkit-study h1 { font-size: 1.6em; margin: 0 0 0.2em; } .mpmkit-study h2 { font-size: 1.2em; margin: 2em 0 0.5em; }
.mpmkit-study p.about { color: var(--faint); margin: 0; } .mpmkit-study ul { padding-left: 1.2em; } .mpmkit-study li { margin: 0.3em 0; }
.mpmkit-study .pictures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 460px), 1fr)); gap: 1.5em; }
.mpmkit-study figure { max-width: 620px; min-width: 0; margin: 0; } .mpmkit-study figcaption { color: var(--faint); font-size: 0.9em; }
.mpmkit-study svg { width: 100%; height: auto; display: block; }
.mpmkit-study .scroll { overflow-x: auto; }
.mpmkit-study table { border-collapse: collapse; font-size: 0.85em; font-variant-numeric: tabular-nums; }
.mpmkit-study th, .mpmkit-study td { padding: 0.3em 0.8em; text-align: left; border-bottom: 1px solid var(--line); white-space: nowrap; }
.mpmkit-study td.n, .mpmkit-study th.n { text-align: right; } .mpmkit-study td.t { white-space: normal; min-width: 16em; }
.mpmkit-study th button { all: unset; cursor: pointer; font-weight: 600; }
.mpmkit-study th button:focus-visible { outline: 2px solid var(--c0); }
.mpmkit-study th[aria-sort=ascending] button::after { content: " \\2191"; }
.mpmkit-study th[aria-sort=descending] button::after { content: " \\2193"; }
.mpmkit-study tr.front td { background: var(--soft); }
.mpmkit-study pre { background: var(--soft); padding: 1em; overflow-x: auto; font-size: 0.85em; }
.mpmkit-study summary { cursor: pointer; }
""".replace("LIGHT", _variables(pictures.COLOURS)).replace("DARK", _variables(pictures.IN_THE_DARK))
PAGE = """
html { background: var(--paper); } body { margin: 0; }
main.mpmkit-study { max-width: 1240px; margin: 0 auto; padding: 1.5em 1em 4em; }
"""
SCRIPT = """
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, k) => head.querySelector("button").addEventListener("click", () => {
    const up = head.getAttribute("aria-sort") !== "ascending";
    heads.forEach(h => h.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const key = row => row.cells[k].dataset.value ?? row.cells[k].textContent;
    const rows = [...table.tBodies[0].rows].sort((a, b) => {
      const [x, y] = [key(a), key(b)];
      if (x === "" || y === "") return (x === "") - (y === "");
      const d = Number(x) - Number(y);
      return (isNaN(d) ? x.localeCompare(y) : d) * (up ? 1 : -1);
    });
    table.tBodies[0].append(...rows);
  }));
}
"""
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
"""The browser itself sees to it that nothing is loaded."""


def page(results: StudyResults, asked: Iterable[str | float] = ()) -> str:
    """The whole report; `asked` as for `sentences.sections`."""
    head = (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n'
        f"<title>{escape(results.name)}: what accuracy costs</title>\n<style>{STYLE}{PAGE}</style>\n</head>\n<body>\n"
    )
    parts = [_title(results), _said(results, asked), _orders(results), _rows(results), _scene(results), _where(results)]
    return f'{head}<main class="mpmkit-study">\n{"".join(parts)}</main>\n<script>{SCRIPT}</script>\n</body>\n</html>\n'


def save(results: StudyResults, path: str | os.PathLike[str], asked: Iterable[str | float] = ()) -> Path:
    """Write the report into one file.

    Raises
    ------
    ResultsError
        If it cannot be written.
    """
    return write(Path(path), page(results, asked))


def fragment(results: StudyResults) -> str:
    """Sentences, pictures and the table for a notebook."""
    return f'<style>{STYLE}</style><div class="mpmkit-study">{_title(results)}{_said(results, ())}{_rows(results)}</div>'


def _title(results: StudyResults) -> str:
    meta = results.meta
    ends: dict[str, int] = {}
    for row in results:
        ends[row["status"]] = ends.get(row["status"], 0) + 1
    told = [f"{len(results)} runs: {', '.join(f'{n} {s}' for s, n in ends.items())}", str(meta.get("when", ""))]
    told += [str(meta.get("machine", {}).get("processor", "")), f"mpmkit {meta.get('versions', {}).get('mpmkit', '?')}"]
    about = " · ".join(escape(t) for t in told if t)
    return f'<h1>{escape(results.name)}: what accuracy costs</h1>\n<p class="about">{about}</p>\n'


def _said(results: StudyResults, asked: Iterable[str | float]) -> str:
    """For each error what is to be said of it, and its pictures; then the runs that did not end well."""
    found = sentences.sections(results, asked)
    out = []
    parts = {sentences.titled(m, problem): (m, part) for m in results.measures for problem, part in results.parts().items()}
    for k, title in enumerate(dict.fromkeys([*parts, *found])):
        lines = "".join(f"<li>{escape(line)}</li>\n" for line in found.get(title, ()))
        out.append(f"<h2>{escape(title)}</h2>\n<ul>\n{lines}</ul>\n" if lines else f"<h2>{escape(title)}</h2>\n")
        if title in parts:
            measure, part = parts[title]
            out.append(_drawn(part, measure, f"p{k}"))
    return "".join(out)


CAPTIONS = {
    pictures.WORK: "Error against wall time. Bars: fastest and slowest; grey: nothing is faster and better{lost}.",
    pictures.CONVERGENCE: "Error against resolution, with fitted orders ({confidence:.0%} confidence); triangles are whole orders{lost}.",
}


def _drawn(results: StudyResults, measure: str, prefix: str) -> str:
    figures = []
    lost = "; crosses at the edge are runs without a result" if any(r["status"] != "done" for r in results) else ""
    for k, kind in enumerate(pictures.KINDS):
        if pictures.drawable(results, measure, kind):
            caption = CAPTIONS[kind].format(lost=lost, confidence=fit.CONFIDENCE)
            picture = pictures.svg(results, measure, kind, f"{prefix}{k}")
            figures.append(f"<figure>{picture}<figcaption>{escape(caption)}</figcaption></figure>\n")
    return f'<div class="pictures">\n{"".join(figures)}</div>\n' if figures else ""


def _orders(results: StudyResults) -> str:
    lines = []
    for measure, name, rows in [(m, n, rows) for m in results.measures for n, rows in results.series(m).items()]:
        order, price, halt = fit.order(rows, measure), fit.next_digit(rows, measure), fit.stall(rows, measure)
        best = min(r["errors"][measure] for r in rows)
        between = "" if order is None else f"{exponent(order.low)} to {exponent(order.high)}"
        cells: list[Any] = [name, measure, order and order.slope, between, order and order.count, best, price and price.factor]
        lines.append([*cells, halt and halt.resolution])
    if not any(line[2] is not None for line in lines):
        return ""
    heads = [
        "composition",
        "error",
        "order",
        f"{fit.CONFIDENCE:.0%} confidence",
        "resolutions",
        "smallest error",
        "time for a digit",
        "stalls below",
    ]
    return f"<h2>Observed orders</h2>\n{_table(heads, lines)}"


def _rows(results: StudyResults) -> str:
    axes = list(dict.fromkeys(axis for row in results for axis in row["labels"]))
    heads = [*(axes or ["run"]), *results.measures, "seconds", "fastest", "slowest"]
    heads += ["steps", "particles", "ns/particle-step", "memory [MB]"]
    best = {row["label"] for measure in results.measures for part in results.parts().values() for row in fit.front(part.rows, measure)}
    lines, marks = [], []
    for row in results:
        cells: list[Any] = [row["labels"].get(a, "") for a in axes] or [row["label"]]
        cells += [row["errors"].get(m) for m in results.measures]
        cells += [row[k] for k in ("seconds", "seconds_low", "seconds_high", "steps", "particles", "ns_per_particle_step")]
        cells.append(None if row["peak_bytes"] is None else row["peak_bytes"] / 1e6)
        told = "" if row["status"] == "done" else f"{row['status']}: {row['reason']}".split("\n")[0]
        lines.append([*cells, "; ".join(t for t in (told, *row["notes"]) if t)])
        marks.append("front" if row["label"] in best else "")
    return f'<h2>All runs</h2>\n{_table([*heads, "notes"], lines, marks)}<p class="about">Shaded: on a Pareto front.</p>\n'


def _table(heads: Sequence[str], lines: Sequence[Sequence[Any]], marks: Sequence[str] = ()) -> str:
    numeric = [all(isinstance(line[k], (int, float)) or line[k] is None for line in lines) for k in range(len(heads))]
    top = "".join(
        f'<th{" class=n" if n else ""} scope="col"><button type="button">{escape(head)}</button></th>'
        for head, n in zip(heads, numeric, strict=True)
    )
    body = []
    for k, line in enumerate(lines):
        cells = "".join(_cell(value) for value in line)
        body.append(f"<tr{' class=front' if marks and marks[k] else ''}>{cells}</tr>\n")
    return f'<div class="scroll"><table class="sortable">\n<thead><tr>{top}</tr></thead>\n<tbody>\n{"".join(body)}</tbody></table></div>\n'


def _cell(value: Any) -> str:
    if value is None:
        return '<td class="n" data-value=""></td>'
    if isinstance(value, (int, float)):
        shown = f"{value:,}" if isinstance(value, int) else number(value, 3)
        return f'<td class="n" data-value="{value!r}">{shown}</td>'
    text = str(value)
    try:
        sort = f' data-value="{float(text)!r}"'
    except ValueError:
        sort = ""
    return f"<td{' class=t' if len(text) > 40 else ''}{sort}>{escape(text)}</td>"


def _scene(results: StudyResults) -> str:
    text = results.meta.get("scene")
    return f"<h2>Scene</h2>\n<details open><summary>what the runs vary</summary><pre>{escape(text)}</pre></details>\n" if text else ""


def _where(results: StudyResults) -> str:
    """Machine, versions, how it was measured."""
    meta = results.meta
    facts = [(str(k), _fact(k, v)) for k, v in {**meta.get("machine", {}), **meta.get("versions", {})}.items()]
    facts += [(key, str(meta[key])) for key in ("startup", "threads", "when", "sources") if meta.get(key) is not None]
    reference = meta.get("reference") or {}
    if reference.get("seconds"):
        times = sorted(reference["seconds"])
        told = f"{plain(times[len(times) // 2], 's', 3)} ({number(times[0], 3)} to {number(times[-1], 3)}), {len(times)} times"
        facts.append((f"reference run ({reference.get('label', '')})", told))
    rows = "".join(f'<tr><td>{escape(k)}</td><td class="t">{escape(v)}</td></tr>\n' for k, v in facts)
    notes = "".join(f"<li>{escape(n)}</li>\n" for n in meta.get("notes", ()))
    table = f'<div class="scroll"><table>\n<tbody>{rows}</tbody></table></div>\n'
    return f"<h2>Machine and versions</h2>\n{table}" + (f"<ul>{notes}</ul>\n" if notes else "")


def _fact(key: str, value: Any) -> str:
    return f"{value / 2**30:.1f} GiB" if key == "memory_bytes" and value else str(value)
