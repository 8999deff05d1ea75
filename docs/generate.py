"""Writes what can be known from the code: a page for each component, command and example, and the generated functions a page quotes.

Facts about components come from `mpmkit.description.describe`, as for ``mpmkit describe``; an installed plugin of a third party gets its
pages too. A page of the gallery is the docstring, the picture and the text of a script in ``examples``.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

import click

from mpmkit._core.registry import registry
from mpmkit.cli.app import group
from mpmkit.description import describe
from mpmkit.fields import PARTICLE_FIELDS
from mpmkit.interfaces import KINDS
from mpmkit.scene.parts import scene_objects

GENERATED = "<!-- written by docs/generate.py; edit the docstring of the class instead -->\n"
TITLES = {
    "shape": "Shape functions",
    "material": "Materials",
    "contact": "Contact",
    "boundary": "Boundary layers",
    "integrator": "Integrators",
    "transfer": "Transfers",
    "effect": "Effects",
    "discretization": "Discretizations",
}


CONFORMANCE = """What `mpmkit check PLUGIN` and `mpmkit.testing.conformance(PLUGIN)` check. Components are built from the examples of their
parameters; each check runs with the first example of each and, unless it is marked (1), with each other choice and example in turn.

A tolerance is *rounding*, a multiple of machine epsilon times a stated size, or *rate*, an order of an error in a step that is stated.
Random numbers are the same in each run. A component that cannot pass a check says so,
`expected_failures = {"name of the check": "reason"}`; the reason is shown wherever the component is described, and the entry is an error as
soon as the check passes.

For each check there is a component with one fault, in `tests/conformance/mutants`, that the check must find and others must not.
"""


def main(docs: Path, examples: Path | None = None) -> None:
    """Write all pages below `docs`; files that are up to date are left alone, so that Sphinx rebuilds only what changed.

    Parameters
    ----------
    docs : Path
        Folder of the docs.
    examples : Path, optional
        Folder of the examples; ``examples`` beside `docs` if not given.
    """
    pages = {f"reference/components/{name}.md": page(describe(cls)) for name, cls in classes().items()}
    pages["reference/components/index.md"] = index()
    pages |= {"reference/command-line.md": command_line(), "reference/fields-table.md": fields()}
    pages["reference/conformance-checks.md"] = conformance_checks()
    pages |= {f"gallery/examples/{path.stem}.md": picture(path) for path in shows(examples or docs.parent / "examples")}
    for folder in ("reference/components", "gallery/examples"):
        (docs / folder).mkdir(parents=True, exist_ok=True)
        for old in (docs / folder).glob("*.md"):
            if f"{folder}/{old.name}" not in pages:
                old.unlink()
    for name, text in pages.items():
        path = docs / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
    for path in (docs / "explanation").glob("how-a-step-runs.md"):
        old = path.read_text(encoding="utf-8")
        if (text := quoting(old)) != old:
            path.write_text(text, encoding="utf-8")


def quoting(page: str) -> str:
    """A page with the generated functions that it quotes as they are now: those of the simulation ``sim`` of its first Python block."""
    from mpmkit._core.composing.composition import collect
    from mpmkit._core.composing.plan import make_plan

    names: dict[str, Any] = {}
    exec(re.search(r"^```python\n(.*?)^```", page, flags=re.MULTILINE | re.DOTALL)[1], names)  # type: ignore[index]
    module = make_plan(collect(names["sim"])).text

    def function(quoted: re.Match[str]) -> str:
        found = re.search(rf"^@compiled\ndef {quoted[1]}\(.*?(?=\n\n\n|\n\Z)", module, flags=re.MULTILINE | re.DOTALL)
        if found is None:
            raise LookupError(f"no function of the generated module is named {quoted[1]!r}")
        return f"```py\n{found[0]}\n```"

    return re.sub(r"^```py\n@compiled\ndef (\w+)\(.*?^```", function, page, flags=re.MULTILINE | re.DOTALL)


def shows(examples: Path) -> list[Path]:
    """The scripts that show something: those with a function ``main`` that draws a picture."""
    return [p for p in sorted(examples.glob("*.py")) if drawn(p)]


def drawn(path: Path) -> str:
    """Name of the picture in docs/images that a script draws; "" if it draws none."""
    found = re.search(r"docs/images/(\w+\.png)", ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "")
    return found[1] if found else ""


def picture(path: Path) -> str:
    """The gallery's page of one example."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    summary, _, rest = text.partition("\n\n")
    title = path.stem.replace("_", " ").capitalize()
    code = f"```{{literalinclude}} ../../../examples/{path.name}\n:language: python\n```\n"
    image = f"![{title}](../../images/{drawn(path)})\n"
    return "\n".join([f"# {title}\n", GENERATED, f"**{summary}**\n", image, rest + "\n", "## The script\n", code])


def classes() -> dict[str, type]:
    """Everything that has a page: components, and the objects scenes are made of."""
    return {entry.name: entry.component for entry in registry().entries} | scene_objects()


def page(data: dict[str, Any]) -> str:
    """One page, from the facts of `describe`."""
    origin = f", from {data['distribution']} {data['version']}" if data.get("distribution") else ""
    parts = [f"# {data['name']}\n", GENERATED, f"*{data['kind']}{origin}* (`{data['module']}`)\n", rst(data["summary"])]
    if data["text"]:
        parts.append(rst(data["text"]))
    for title, body in data["sections"].items():
        if title not in ("Parameters", "Attributes", "References", "Examples"):
            parts += [f"## {title}\n", rst(body)]
    parts += ["## Parameters\n", parameters(data["parameters"])]
    if data.get("state"):
        rows = [(f"`{f['name']}`", f["unit"], f["shape"], f"{f['initial']:g}", f["doc"]) for f in data["state"]]
        parts += ["## State of each particle\n", table(("name", "unit", "shape", "at the start", "meaning"), rows)]
    if data.get("capabilities"):
        rows = [(name, words(value)) for name, value in data["capabilities"].items() if value not in ([], None)]
        parts += ["## Capabilities\n", table(("what", "value"), rows)]
    if data.get("kernels"):
        rows = [(f"`{n}({', '.join(k['arguments'])})`", code(k["summary"])) for n, k in data["kernels"].items()]
        parts += ["## Kernels\n", table(("kernel", "meaning"), rows)]
    if data.get("known failures"):
        parts += ["## Known to fail\n", table(("conformance check", "reason"), list(data["known failures"].items()))]
    references = list(data.get("references", [])) + [s.strip() for s in data["sections"].get("References", "").splitlines() if s.strip()]
    if references:
        parts += ["## References\n", "\n".join(f"- {escape(r)}" for r in references) + "\n"]
    return "\n".join(parts)


def parameters(rows: list[dict[str, Any]]) -> str:
    """The table of parameters."""
    if not rows:
        return "none\n"
    cells = []
    for p in rows:
        default = "required" if p["required"] else words(p["default"])
        cells.append((f"`{p['name']}`", p["type"], p["unit"], p["bounds"], default, words(p["example"]), p["doc"]))
    return table(("name", "type", "unit", "allowed", "default", "example", "meaning"), cells)


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A Markdown table."""
    lines = [head, tuple("---" for _ in head), *rows]
    return (
        "\n".join(
            "| " + " | ".join(cell if cell.startswith("`") and cell.endswith("`") else escape(cell) for cell in row) + " |" for row in lines
        )
        + "\n"
    )


def words(value: Any) -> str:
    """A default, example or capability as text."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:g}"
    return ", ".join(words(v) for v in value) if isinstance(value, (list, tuple)) else str(value)


def escape(text: str) -> str:
    """Text with the characters that Markdown would take for its own; letters between backquotes are left as they are."""
    parts = re.split(r"(`[^`|]*`)", text.replace("``", "`").replace("\n", " "))
    return "".join(part if k % 2 else re.sub(r"([\\*_|<>$])", r"\\\1", part) for k, part in enumerate(parts))


def code(text: str) -> str:
    """A formula in letters, such as the first line of a kernel's docstring."""
    return f"`{text.replace('`', '').replace('|', chr(0x2223))}`" if text else ""


def rst(text: str) -> str:
    """A part of a docstring, which is reStructuredText; ``|x|`` is an absolute value there, no substitution."""
    lines, math = [], False
    for line in text.splitlines():
        math = line.strip().startswith(".. math::") or (math and (not line.strip() or line.startswith(" ")))
        lines.append(line if math else re.sub(r"(:\w+:`[^`]*`|``[^`]*``)|\|", lambda m: m[1] or r"\|", line))
    return "```{eval-rst}\n" + "\n".join(lines) + "\n```\n"


def index() -> str:
    """The page that lists all components by kind."""
    what = "One page for each installed component and each object a scene is made of, as `mpmkit describe NAME` prints it.\n"
    out = ["# Components\n", GENERATED, what]
    for kind in KINDS:
        names = list(registry().of(kind))
        if names:
            out += [f"## {TITLES.get(kind, kind)}\n", listing(names)]
    out += ["## Objects of a scene\n", listing(list(scene_objects()))]
    return "\n".join(out)


def listing(names: list[str]) -> str:
    """Names with their summaries, and their entries in the table of contents."""
    rows = "\n".join(f"- [{name}]({name}.md): {escape(describe(classes()[name])['summary'])}" for name in names)
    return rows + "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(names) + "\n```\n"


def fields() -> str:
    """The table of standard particle fields, included in fields.md."""
    rows = [(f"`{f.name}`", f.shape, f.unit, f.doc) for f in PARTICLE_FIELDS.values()]
    return table(("field", "shape", "unit", "meaning"), rows)


def conformance_checks() -> str:
    """All checks of the conformance suite by kind, with what their docstrings say."""
    from mpmkit.testing.checks import table as checks
    from mpmkit.testing.suite import ALWAYS

    found = checks()
    out = [
        "# Conformance checks\n",
        "<!-- written by docs/generate.py; edit the docstrings in mpmkit/testing/checks instead -->\n",
        CONFORMANCE,
    ]
    for kind in ("all", *KINDS):
        rows = [(name, text) for name, text in ALWAYS.items()] if kind == "all" else []
        rows += [(d.name + (" (1)" if d.once else ""), " ".join(d.doc.split())) for d in found if d.kind == kind]
        out += [f"## {TITLES.get(kind, 'Components of all kinds')}\n", table(("check", "what it asks"), rows)]
    return "\n".join(out)


def command_line() -> str:
    """The help texts of all commands."""
    out = ["# Command line\n", "<!-- written by docs/generate.py from the commands themselves -->\n"]
    with click.Context(group, info_name="mpmkit") as context:
        out += ["```text\n" + group.get_help(context) + "\n```\n"]
        for name in group.list_commands(context):
            command = group.get_command(context, name)
            with click.Context(command, info_name=name, parent=context) as inner:
                out += [f"## mpmkit {name}\n", "```text\n" + command.get_help(inner) + "\n```\n"]
    return "\n".join(out)


if __name__ == "__main__":
    main(Path(__file__).parent)
