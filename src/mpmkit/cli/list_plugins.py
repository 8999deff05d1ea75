"""mpmkit list-plugins: what is installed, where it comes from, and what could not be loaded."""

from __future__ import annotations

from typing import Any

import click

from mpmkit._core.registry import Registry, registry
from mpmkit.cli.base import Command, print_json
from mpmkit.errors import did_you_mean
from mpmkit.interfaces import KINDS


@click.command(cls=Command)
@click.option("--kind", metavar="KIND", help=f"Only components of this kind: {', '.join(KINDS)}.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def list_plugins(kind: str | None, as_json: bool) -> None:
    """List all components with kind, distribution and version, and plugins that cannot be loaded, with the reason."""
    if kind is not None and kind not in KINDS:
        raise click.BadParameter(
            f"no kind of component is named {kind!r}{did_you_mean(kind, KINDS)} (kinds: {', '.join(KINDS)})", param_hint="--kind"
        )
    data = as_data(registry(), kind)
    if as_json:
        print_json(data)
    else:
        show(data)


def as_data(found: Registry, kind: str | None = None) -> dict[str, list[dict[str, Any]]]:
    """Components, broken plugins and duplicates as plain data."""
    order = list(KINDS)
    entries = [e for e in found.entries if kind is None or e.kind == kind]
    components = [
        {
            "name": e.name,
            "kind": e.kind,
            "plugin": e.plugin,
            "distribution": e.distribution,
            "version": e.version,
            "module": e.component.__module__,
            "summary": e.component.summary(),
            "capabilities": e.component.capabilities(),
        }
        for e in sorted(entries, key=lambda e: (order.index(e.kind), e.name, e.distribution))
    ]
    broken = [{"plugin": b.plugin, "distribution": b.distribution, "version": b.version, "reason": b.reason} for b in found.broken]
    duplicates = [
        {"name": name, "kind": of, "registered by": [f"{e.distribution} {e.version} ({e.component.__module__})" for e in several]}
        for (of, name), several in found.duplicates.items()
        if kind is None or of == kind
    ]
    return {"components": components, "broken": broken, "duplicates": duplicates}


def show(data: dict[str, list[dict[str, Any]]]) -> None:
    """Print tables."""
    from mpmkit.cli.tables import print_table

    rows = [
        (c["name"], c["kind"], f"{c['distribution']} {c['version']}", c["summary"], capabilities_text(c["capabilities"]))
        for c in data["components"]
    ]
    if rows:
        print_table(("name", "kind", "from", "summary", "capabilities"), rows)
    else:
        click.echo("No components are installed." if not data["broken"] else "No component could be loaded.")
    for b in data["broken"]:
        click.echo(f"not loaded  {b['plugin']}  ({b['distribution']} {b['version']}): {b['reason']}")
    for d in data["duplicates"]:
        click.echo(f"duplicate  {d['kind']} {d['name']}: {' and '.join(d['registered by'])}; unusable until one is uninstalled or disabled")


def capabilities_text(capabilities: dict[str, Any]) -> str:
    """Capabilities in one line; what every component can is left out, so that differences show."""
    from mpmkit.interfaces import SPACES

    parts = []
    for name, value in capabilities.items():
        if (
            (name == "spaces" and set(value) == set(SPACES))
            or (name == "precisions" and len(value) == 2)
            or value in ([], None, "", "none")
        ):
            continue
        if isinstance(value, bool):
            parts.append(name if value else f"no {name}")
        else:
            parts.append(f"{name}: {', '.join(map(str, value)) if isinstance(value, (list, tuple)) else value}")
    return "; ".join(parts)
