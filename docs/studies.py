"""Measures what docs/studies shows: does the published studies, and writes their results, pages and pictures.

``python docs/studies.py [NAME ...]`` does the studies of examples/studies that are named, or all of them. Results that are there from
before, for the same files and sources, are kept, so after ``--errors-only`` the same command only measures times, for which the machine
should be idle. ``--redraw`` writes pages and pictures anew from the kept results; ``--again NAME`` does one study a second time, in a
folder of its own, and writes whether it ranks the runs as before.

What people say about a study is in docs/studies.toml; everything else on its page follows from its results.
"""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import click

from mpmkit.errors import did_you_mean
from mpmkit.studies import Study, StudyResults, fit, pictures, published
from mpmkit.studies.numbers import exponent, number, seconds
from mpmkit.studies.sentences import RUNS, sections, titled

DOCS = Path(__file__).parent
ROOT = DOCS.parent
SCENES, RUNNING, IMAGES = ROOT / "examples/studies", DOCS / "_build/studies", DOCS / "images"
WORDS: dict[str, Any] = tomllib.loads((DOCS / "studies.toml").read_text(encoding="utf-8"))
STUDIES: dict[str, dict[str, Any]] = WORDS["studies"]
AGAIN = DOCS / "data/studies-again.json"
FRONT = "work_precision.png"
HEAD = "<!-- written by python docs/studies.py from {0} and docs/studies.toml; edit the words there, measure the numbers again -->\n"
BUSY = "this machine was busy"
SHOWN = {"unstable": "blew up", "over budget": "over budget"}


def study_file(name: str) -> Path:
    """The file of a study."""
    return SCENES / f"{name}_study.toml"


def data_file(name: str) -> Path:
    """Its kept results: beside the code where `mpmkit advise` uses them."""
    return published.FOLDER / f"{name}.json" if STUDIES[name].get("advises") else DOCS / f"data/studies/{name}.json"


def results_of(name: str) -> StudyResults:
    """The kept results."""
    return StudyResults.load(data_file(name))


# --- one page -------------------------------------------------------------------------------------------------------
def page(name: str, results: StudyResults) -> str:
    """The page of one study."""
    words = STUDIES[name]
    parts = [f"# {words['title']}\n", HEAD.format(data_file(name).relative_to(ROOT).as_posix()), words["asked"].strip() + "\n"]
    parts.append(f"![Errors of this study over wall time and resolution](../images/study_{name}.png)\n")
    parts += ["## What to do\n", "".join(f"- {' '.join(line.split())}\n" for line in words["said"])]
    parts += ["## Errors\n", *tables(results), remarks(results)]
    command = f"mpmkit study examples/studies/{name}_study.toml --report {name}.html"
    parts += ["## Do it again\n", f"```sh\n{command}\n```\n", origin(name, results)]
    return "\n".join(part for part in parts if part)


def tables(results: StudyResults) -> list[str]:
    """For each error and problem a line for each composition: errors from coarse to fine, and the observed order."""
    axis = results.meta["resolution"]
    unit = f" [{axis['unit']}]" if axis["unit"] != "1" else ""
    out = []
    for measure in results.measures:
        for problem, part in results.parts().items():
            sizes = sorted({r["resolution"] for r in part if r["resolution"]}, reverse=True)
            lines = [[f"{axis['name']}{unit}", *(number(h, 3) for h in sizes), "order"]]
            for composition in part.compositions():
                rows = [r for r in part if r["composition"] == composition]
                found = {r["resolution"]: cell(r, measure) for r in rows}
                if all(r["status"] == "refused" for r in rows):
                    found = dict.fromkeys(sizes, "refused")
                order = fit.order(rows, measure)
                told = "" if order is None else f"{exponent(order.slope)} ± {exponent(order.high - order.slope)}"
                lines.append([composition, *(found.get(h, "") for h in sizes), told])
            out.append(f"**{titled(measure, problem)}**\n")
            out.append(table(lines))
    return out


def cell(row: dict[str, Any], measure: str) -> str:
    """The error of a run, or what became of it."""
    if row["status"] != "done":
        return SHOWN.get(row["status"], str(row["status"]))
    return number(row["errors"][measure], 3) if measure in row["errors"] else ""


def remarks(results: StudyResults) -> str:
    """What the study itself says: the cheapest for an error, and runs that did not end well."""
    out = []
    for title, lines in sections(results).items():
        if title == RUNS:
            lines = [line for line in lines if "spread by more" not in line]
        else:
            lines = [line for line in lines if line.startswith("For ")]
        if lines:
            out.append(f"*{title}:*\n\n" + "".join(f"- {line}\n" for line in lines))
    if not out:
        return ""
    return "\n".join(["## In its own words\n", "What `mpmkit study` says; times are those of the machine named below.\n", *out])


def origin(name: str, results: StudyResults) -> str:
    """When, where and with what it was measured."""
    meta = results.meta
    versions = ", ".join(f"{k} {v}" for k, v in meta["versions"].items() if k in ("mpmkit", "python", "numpy", "numba"))
    timed = [r["seconds"] for r in results if r["seconds"]]
    rounds = max((r["repeats"] for r in results), default=0)
    of = f"medians of {rounds} rounds" if rounds > 1 else "of one round"
    times = f"times are {of}, {seconds(sum(timed))} for all runs" if timed else "times are not measured yet"
    times += "".join(f"; {note}" for note in meta["notes"])
    machine = f"{meta['machine']['processor']}, {meta['machine']['usable cores']} cores"
    where = data_file(name).relative_to(ROOT).as_posix()
    return f"*{len(results)} runs; {times}. {meta['when'][:10]}, {machine}, {versions}. All figures: `{where}`.*\n"


def table(lines: list[list[str]]) -> str:
    """A Markdown table; the first line is its head."""
    rows = [lines[0], ["---"] * len(lines[0]), *lines[1:]]
    return "\n".join("| " + " | ".join(str(c).replace("|", "\\|") for c in row) + " |" for row in rows) + "\n"


# --- all of them ----------------------------------------------------------------------------------------------------
def index(found: dict[str, StudyResults]) -> str:
    """The page that leads to all studies, with the observed orders beside the theory."""
    parts = ["# What accuracy costs\n", HEAD.format("the results of all studies"), WORDS["asked"].strip() + "\n"]
    parts.append(f"![{WORDS['front']['told']}](../images/{FRONT})\n")
    parts.append(f"*{WORDS['front']['told']}*\n")
    lines = [["study", "what to do"]]
    lines += [[f"[{words['title']}]({name}.md)", words["short"]] for name, words in STUDIES.items() if name in found]
    parts += [table(lines), "## Observed orders and theory\n", WORDS["orders"].strip() + "\n", table(orders(found)), repeated()]
    pages = "\n".join(name for name in STUDIES if name in found)
    parts.append(f"```{{toctree}}\n:hidden:\n\n{pages}\n```\n")
    return "\n".join(part for part in parts if part)


def orders(found: dict[str, StudyResults]) -> list[list[str]]:
    """Fitted orders beside those of theory, as docs/studies.toml names them."""
    lines = [["study", "error", "composition", "observed", "95 %", "theory", "source"]]
    for name, results in found.items():
        for expected in STUDIES[name].get("theory", ()):
            measure, problem = results.measures[expected.get("error", 0)], expected.get("problem", "")
            series = results.parts()[problem].series(measure)
            for composition in expected["compositions"]:
                order = fit.order(series[composition], measure)
                got = ["none", ""] if order is None else [exponent(order.slope), f"{exponent(order.low)} to {exponent(order.high)}"]
                what = titled(measure, problem)
                lines.append([f"[{name}]({name}.md)", what, composition, *got, str(expected["order"]), expected["source"]])
    return lines


def repeated() -> str:
    """Whether a study that was done twice ranked its runs the same."""
    if not AGAIN.is_file():
        return ""
    told = json.loads(AGAIN.read_text(encoding="utf-8"))
    return (
        f"## The same again\n\nThe study [{told['study']}]({told['study']}.md) was done twice on the same machine, {told['first']} and "
        f"{told['second']}. Of the {told['pairs']} pairs of runs whose times are apart in the first, {told['same']} are in the same order "
        f"in the second (Kendall's tau of all medians {told['tau']:.3f}). The cheapest composition for an asked error was the same, or "
        f"one of the same time within the spread, for {told['agree']} of {told['levels']} powers of ten."
        f"{' The machine was busy with other work.' if told['busy'] else ''}\n"
    )


# --- pictures -------------------------------------------------------------------------------------------------------
def draw(name: str, results: StudyResults) -> None:
    """The pictures of a study, as PNG with few colours."""
    shown = STUDIES[name].get("shown")
    save(pictures.draw(results, None if shown is None else results.measures[shown]), IMAGES / f"study_{name}.png")
    front = WORDS["front"]
    if name == front["study"]:
        part = results.parts()[front["problem"]]
        part = StudyResults(part.rows, part.meta | {"name": front["title"]})
        measure = part.measures[front["error"]]
        kind = pictures.WORK if pictures.drawable(part, measure, pictures.WORK) else pictures.CONVERGENCE
        save(pictures.draw(part, measure, kind), IMAGES / FRONT)


def save(figure: Any, path: Path) -> None:
    """Write a figure; a palette is enough for lines, and the page loads fast."""
    import io

    import PIL.Image

    buffer = io.BytesIO()
    figure.savefig(buffer)
    path.parent.mkdir(exist_ok=True)
    PIL.Image.open(buffer).convert("RGB").quantize(128).save(path, optimize=True)


# --- doing it -------------------------------------------------------------------------------------------------------
def write(names: list[str]) -> None:
    """Pages and pictures of these studies, and the page that leads to all, from the kept results."""
    (DOCS / "studies").mkdir(exist_ok=True)
    for name in names:
        results = results_of(name)
        (DOCS / f"studies/{name}.md").write_text(page(name, results), encoding="utf-8")
        draw(name, results)
    found = {name: results_of(name) for name in STUDIES if data_file(name).is_file()}
    (DOCS / "studies/index.md").write_text(index(found), encoding="utf-8")


def ranking(first: StudyResults, second: StudyResults, name: str) -> dict[str, Any]:
    """What is the same in two results of one study: the order of runs by time, and the cheapest composition for each decade."""
    from scipy.stats import kendalltau

    a, b = ({r["label"]: r for r in results if r["seconds"]} for results in (first, second))
    labels = [label for label in a if label in b]
    apart = [(p, q) for p in labels for q in labels if a[p]["seconds_high"] < a[q]["seconds_low"]]
    same = sum(b[p]["seconds"] < b[q]["seconds"] for p, q in apart)
    levels = agree = 0
    for measure in first.measures:
        for problem, part in first.parts().items():
            other = second.parts()[problem]
            for power in range(-12, 3):
                best = [fit.cheapest(p.done(measure), measure, 10.0**power) for p in (part, other)]
                if best[0] and any(r["errors"][measure] > 10.0 ** (power - 1) for r in part.done(measure)):
                    level = best[0][0]["seconds_high"]
                    tied = {r["composition"] for r in best[0] if r["seconds_low"] <= level}
                    levels, agree = levels + 1, agree + (bool(best[1]) and best[1][0]["composition"] in tied)
    tau = float(kendalltau([a[x]["seconds"] for x in labels], [b[x]["seconds"] for x in labels]).statistic)
    when = [results.meta["when"][:16] for results in (first, second)]
    told = {"study": name, "first": when[0], "second": when[1], "pairs": len(apart), "same": same, "tau": tau}
    busy = any(note.startswith(BUSY) for results in (first, second) for note in results.meta.get("notes", ()))
    return told | {"levels": levels, "agree": agree, "busy": busy}


@click.command(help=__doc__)
@click.argument("names", nargs=-1)
@click.option("--redraw", is_flag=True, help="Measure nothing.")
@click.option("--errors-only", is_flag=True, help="Measure no times.")
@click.option("--again", metavar="NAME", help="Time one study a second time.")
@click.option("--jobs", type=int, default=None, help="Runs side by side for errors.")
@click.option("--repeat", type=int, default=None, help="Rounds of times, in place of those in the files.")
def main(names: tuple[str, ...], redraw: bool, errors_only: bool, again: str | None, jobs: int | None, repeat: int | None) -> None:
    """Do the studies and write everything."""
    for name in (*names, *([again] if again else ())):
        if name not in STUDIES:
            raise click.BadParameter(f"no study is named {name!r}{did_you_mean(name, STUDIES)} (known: {', '.join(STUDIES)})")
    chosen = list(names or ([] if again else STUDIES))
    changed = {} if repeat is None and not errors_only else {"repeat": 0 if errors_only else repeat}
    if again:
        study = Study.from_file(study_file(again), **changed)
        told = ranking(results_of(again), study.run(RUNNING / f"{again}-again", jobs=jobs), again)
        AGAIN.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    for name in chosen if not redraw else ():
        click.echo(f"== {name}")
        results = Study.from_file(study_file(name), **changed).run(RUNNING / name, jobs=jobs)
        results.meta["notes"] = [note for note in results.meta["notes"] if note.startswith(BUSY)]  # others name folders of this machine
        data_file(name).parent.mkdir(parents=True, exist_ok=True)
        results.save(data_file(name))
        write([name])
    if redraw or again:
        write(chosen)


if __name__ == "__main__":
    main()
