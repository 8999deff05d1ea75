"""mpmkit describe: everything one component declares about itself."""

from __future__ import annotations

from typing import Any

import click

from mpmkit.cli.base import Command, print_json


def _complete(_: click.Context, __: click.Parameter, incomplete: str) -> list[str]:
    from mpmkit._core.registry import registry

    return sorted(name for name in registry().of() if name.lower().startswith(incomplete.lower()))


@click.command(cls=Command)
@click.argument("name", shell_complete=_complete)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def describe(name: str, as_json: bool) -> None:
    """Show what the component NAME is: equation, parameters with units and bounds, state, validity, references.

    Geometries and scene objects (Disk, Grid, Body, Record ...) can be described too.
    """
    from mpmkit.description import describe as facts

    found = [facts(cls) for cls in look_up(name)]
    if as_json:
        print_json(found if len(found) > 1 else found[0])
        return
    for k, data in enumerate(found):
        if k:
            click.echo()
        show(data)


def look_up(name: str) -> list[type]:
    """Every class of this name: components of all kinds first, then geometries and scene objects."""
    from mpmkit._core.registry import registry
    from mpmkit.errors import PluginError, did_you_mean

    found = registry()
    kinds = dict.fromkeys(entry.kind for entry in found.entries if entry.name == name)
    if kinds:
        return [found.get(name, kind).component for kind in kinds]
    from mpmkit.scene.parts import scene_objects

    objects = scene_objects()
    if name in objects:
        return [objects[name]]
    near = did_you_mean(name, [*found.of(), *objects])
    raise PluginError(f"no component is named {name!r}{near}\n  see: mpmkit list-plugins")


def show(data: dict[str, Any]) -> None:
    """Print the facts as text."""
    origin = f"{data['distribution']} {data['version']}, {data['module']}" if data.get("distribution") else data["module"]
    click.echo(f"{click.style(data['name'], bold=True)}  ({data['kind']}, from {origin})")
    click.echo(data["summary"])
    if data["text"]:
        _block("", data["text"])
    for title, body in data["sections"].items():
        # Parameters and attributes stand in the tables below, said once by the declarations.
        if title not in ("Parameters", "Attributes", "References"):
            _block(title, body)
    _parameters(data["parameters"])
    if data.get("state"):
        _block(
            "State of each particle",
            "\n".join(f"{f['name']}  [{f['unit']}]  {f['doc']} ({f['shape']}, starts at {f['initial']:g})" for f in data["state"]),
        )
    if "capabilities" in data:
        _block("Capabilities", _all_capabilities(data["capabilities"]))
    if data.get("kernels"):
        _block(
            "Kernels",
            "\n".join(
                f"{n}({', '.join(k['arguments'])})" + (f"\n    {k['summary']}" if k["summary"] else "") for n, k in data["kernels"].items()
            ),
        )
    if data.get("known failures"):
        _block("Known to fail", "\n".join(f"{check}: {reason}" for check, reason in data["known failures"].items()))
    references = list(data.get("references", [])) + [
        line.strip() for line in data["sections"].get("References", "").splitlines() if line.strip()
    ]
    if references:
        _block("References", "\n".join(references))


def _parameters(parameters: list[dict[str, Any]]) -> None:
    if not parameters:
        _block("Parameters", "none")
        return
    from mpmkit.cli.tables import print_table

    click.echo("\nParameters")
    rows = [
        (
            p["name"],
            p["type"],
            "" if p["unit"] == "1" else p["unit"],
            p["bounds"],
            "required" if p["required"] else _text(p["default"]),
            _text(p["example"]),
            p["doc"],
        )
        for p in parameters
    ]
    print_table(("name", "type", "unit", "allowed", "default", "example", "meaning"), rows, indent=2)


def _text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list):
        return "[" + ", ".join(_text(item) for item in value) + "]"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "" if value is None else str(value)


def _all_capabilities(capabilities: dict[str, Any]) -> str:
    return "\n".join(
        f"{name}: {', '.join(map(str, v)) if isinstance(v, (list, tuple)) else _text(v)}"
        for name, v in capabilities.items()
        if v not in ([], None)
    )


def _block(title: str, body: str) -> None:
    click.echo("\n" + (f"{title}\n" if title else "") + "\n".join(f"  {line}" if line else "" for line in body.splitlines()))
