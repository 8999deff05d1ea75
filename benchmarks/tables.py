"""Tables of the results in Markdown, for the docs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any


def tables(parts: dict[str, Any]) -> str:
    """All tables under their headings, each followed by the machine and the versions it was measured with."""
    writers = {
        "compare": _compare,
        "components": _components,
        "on_demand": _on_demand,
        "scaling": _scaling,
        "startup": _startup,
        "memory": _memory,
        "roofline": _roofline,
        "instructions": _instructions,
    }
    out = ["<!-- written by python -m benchmarks report from benchmarks/results; measure again instead of editing -->\n"]
    for name, writer in writers.items():
        if name in parts:
            out += [*writer(parts[name]["result"]), f"*{_origin(parts[name]['about'])}*\n"]
    return "\n".join(out)


def _origin(facts: dict[str, Any]) -> str:
    versions = ", ".join(f"{name} {number}" for name, number in facts["versions"].items())
    quick = "A quick run that only shows that everything works. " if facts["quick"] else ""
    return f"{quick}{facts['date']}, {facts['processor']}, {facts['cores']} cores; Python {facts['python']}, {versions}."


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table; the first column to the left, numbers to the right."""
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in lines) + "\n"


def _compare(result: dict[str, Any]) -> list[str]:
    names = list(dict.fromkeys(name for row in result["settings"] for name in row["programs"]))
    speeds, phases = [], []
    for row in result["settings"]:
        found = row["programs"]
        if "mpmkit" not in found:
            continue
        label = f"{row['case']} {row['size']} {row['prec']}, {row['threads']} thread{'s' if row['threads'] > 1 else ''}"
        cells = [f"{found['mpmkit']['mps'][0]:.1f}"]
        for name in names:
            if name != "mpmkit":
                one = found.get(name)
                cells.append(
                    f"{one['mps'][0]:.2f}: {one['ratio'][0]:.2f} x ({one['ratio'][1]:.2f} to {one['ratio'][2]:.2f})" if one else ""
                )
        speeds.append([label, *cells, _apart(found)])
        phases.append([label, ", ".join(f"{name} {share:.0%}" for name, share in found["mpmkit"].get("phases", {}).items())])
    head = ["case, size, precision", "mpmkit", *(name for name in names if name != "mpmkit"), "largest difference"]
    out = [
        "## Beside other programs\n",
        f"Million particle-steps per second, medians of {result['rounds']} rounds in which the programs take turns; then how many times as "
        "fast mpmkit is in the same round, with the lowest and highest round.\n",
        table(head, speeds),
        "Where the time of mpmkit's step goes:\n",
        table(["", "share of each phase"], phases),
    ]
    out += [f"Not measured: {name}, {why}.\n" for name, why in result["missing"].items()]
    return out


def _apart(found: dict[str, Any]) -> str:
    apart = [one["agreement"].get("difference", float("nan")) for name, one in found.items() if name != "mpmkit"]
    return f"{max(apart):.0e}" if apart else ""


def _components(result: dict[str, Any]) -> list[str]:
    rows = [
        [
            r["name"],
            r["base"],
            f"{r['ns']:.1f}",
            f"{r['ratio']:.2f}",
            f"{r['expected']:.2f}",
            f"{r['over']:.2f}",
            str(r["nodes"]),
            str(r["passes"]),
            f"{r['flops']:.0f}",
            f"{r['bytes']:.0f}",
        ]
        for r in result["rows"]
    ]
    head = ["component", "beside", "ns", "ratio", "expected", "ratio / expected", "nodes", "loops", "operations", "bytes"]
    return [
        "## What each component costs\n",
        f"One particle-step, {result['particles']:,} particles in 3D, float64, one thread.\n",
        table(head, rows),
    ]


def _on_demand(result: dict[str, Any]) -> list[str]:
    rows = [
        [
            r["name"],
            r["base"],
            f"{r['ratio'][0]:.3f}",
            f"{r['ratio'][1]:.3f} to {r['ratio'][2]:.3f}",
            ", ".join(r["fields"]) or "none",
            str(r["node numbers"]),
        ]
        for r in result["rows"]
    ]
    head = ["component", "beside", "with / without", "lowest and highest turn", "particle fields", "numbers per node"]
    return [
        "## Only what the scene calls for\n",
        f"Time of a step with a component over the same without it, {result['particles']:,} particles in 3D, float64, one thread; "
        f"two copies take turns, {result['rounds']} times. Then the fields that it adds.\n",
        table(head, rows),
    ]


def _scaling(result: dict[str, Any]) -> list[str]:
    out = ["## Scaling\n"]
    if "particles" in result:
        out.append(
            table(
                ["particles", "ns per particle-step", "lowest", "highest"],
                [[f"{r['particles']:,}", *(f"{t:.1f}" for t in r["ns"])] for r in result["particles"]],
            )
        )
    if "threads" in result:
        out.append(
            table(
                ["threads", "M/s", "ratio to one"],
                [[str(r["threads"]), f"{r['mps']:.2f}", f"{r['ratio'][0]:.2f}"] for r in result["threads"]],
            )
        )
    for part, key, head in (
        ("domain", "domain times", "volume of the domain"),
        ("apart", "halves", "two halves of a block"),
    ):
        if part in result:
            out.append(
                table([head, "ns per particle-step", "ratio"], [[str(r[key]), f"{r['ns']:.1f}", f"{r['ratio']:.3f}"] for r in result[part]])
            )
    return out


def _startup(result: list[dict[str, Any]]) -> list[str]:
    head = ["from the start of the process [s]", "imported", "composed", "first step, cold", "first step, warm"]
    rows = [
        [r["what"], *(f"{t:.2f}" for t in (r["warm"]["imported"], r["warm"]["composed"], r["cold"]["total"], r["warm"]["total"]))]
        for r in result
    ]
    return ["## Start-up\n", table(head, rows)]


def _memory(result: list[dict[str, Any]]) -> list[str]:
    head = ["[MB]", "fields of particles", "of nodes", "largest growth of the process", "with frames"]
    rows = []
    for r in result:
        declared = r["particle fields"] + r["node fields"]
        cells = [f"{r[k] / 1e6:.0f}: {r[k] / declared:.2f} x" for k in ("peak", "peak with frames")]
        rows.append([r["stepper"], f"{r['particle fields'] / 1e6:.0f}", f"{r['node fields'] / 1e6:.0f}", *cells])
    return [
        "## Memory\n",
        f"{result[0]['particles']:,} particles in 3D, quadratic B-splines, float64: bytes of the declared fields of particles and stored "
        "nodes, and by how much the process grows at the most while it samples, sorts and steps, in MB and times the fields; then with "
        "frames of velocity and stress.\n",
        table(head, rows),
    ]


def _roofline(result: dict[str, Any]) -> list[str]:
    roofs = [[t, f"{r['bandwidth'] / 1e9:.1f}", f"{r['f64'] / 1e9:.0f}", f"{r['f32'] / 1e9:.0f}"] for t, r in result["roofs"].items()]
    head = ["case", "bytes", "operations", "at most by memory [M/s]", "by arithmetic [M/s]", "measured [M/s]", "reached"]
    rows = [
        [
            f"{r['case']} {r['prec']}, {r['threads']}",
            f"{r['bytes']:.0f}",
            f"{r['flops']:.0f}",
            f"{r['memory']:.1f}",
            f"{r['arithmetic']:.1f}",
            f"{r['mps']:.1f}",
            f"{r['reached']:.0%} of {r['limited_by']}",
        ]
        for r in result["rows"]
    ]
    return [
        "## What the machine allows\n",
        table(["threads", "memory [GB/s]", "float64 [GFLOP/s]", "float32 [GFLOP/s]"], roofs),
        table(head, rows),
    ]


def _instructions(result: dict[str, Any]) -> list[str]:
    rows = [[name, f"{count:.0f}"] for name, count in result["counts"].items()]
    return [
        "## Instructions\n",
        f"Per particle-step, compiled for {result['processor']}, counted by callgrind.\n",
        table(["case", "instructions"], rows),
    ]
