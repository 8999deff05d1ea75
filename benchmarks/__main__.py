"""``python -m benchmarks``: measure, check, and write tables and pictures for the docs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks import compare, components, instructions, memory, on_demand, report, roofline, scaling, startup

PARTS: dict[str, str] = {
    "compare": "mpmkit beside Taichi, Warp, JAX and the programs given with --against",
    "components": "cost of each component relative to the base step",
    "on_demand": "a step with each optional component over the same without it; contact touching and apart",
    "scaling": "particles, threads, empty domains, bodies flying apart",
    "startup": "from the start of a process to its first step, cold and warm",
    "memory": "a million particles beside the bytes of the declared fields",
    "roofline": "bytes and operations against what the machine can do",
    "instructions": "instructions per particle-step, against benchmarks/instructions.json",
    "report": "tables and pictures from the results that are there, without measuring",
}


def main(arguments: list[str] | None = None) -> int:
    """Run the parts asked for; 1 if a program disagrees or fails, or instructions have grown."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", formatter_class=argparse.RawDescriptionHelpFormatter, description=__doc__)
    parser.epilog = "parts:\n" + "\n".join(f"  {name:14}{what}" for name, what in PARTS.items())
    parser.add_argument("parts", nargs="*", metavar="PART", help="which parts (below); all if not given")
    parser.add_argument("--quick", action="store_true", help="small problems and few rounds: does everything run?")
    parser.add_argument(
        "--only", action="append", default=[], metavar="NAME", help="only this program, case, component, group or job; repeatable"
    )
    parser.add_argument(
        "--against", action="append", default=[], metavar="NAME=COMMAND", help="another program with the same options and line"
    )
    parser.add_argument("--write-instructions", action="store_true", help="write benchmarks/instructions.json anew in place of comparing")
    parser.add_argument(
        "--out", type=Path, default=report.RESULTS, help="folder of the results; pictures go to docs/images only from the default one"
    )
    given = parser.parse_args(arguments)
    unknown = [name for name in given.parts if name not in PARTS]
    if unknown:
        parser.error(f"no part is named {unknown[0]!r}; parts: {', '.join(PARTS)}")
    against = {}
    for text in given.against:
        name, sign, command = text.partition("=")
        if not (name and sign and command):
            parser.error(f"--against must be NAME=COMMAND, got {text!r}")
        against[name] = command
    only, problems = tuple(given.only), []
    for part in given.parts or PARTS:
        if part != "report":
            print(f"{part}: {PARTS[part]}", flush=True)
            try:
                result = _runner(part, against, given.write_instructions)(given.quick, only)
            except instructions.NotCounted as error:
                problems.append(str(error))
                continue
            problems += complaints(part, result)
            report.save(given.out, part, result, quick=given.quick)
    report.main(given.out)
    for problem in problems:
        print(f"NOT GOOD: {problem}", file=sys.stderr)
    return 1 if problems else 0


def _runner(part: str, against: dict[str, str], write: bool) -> Callable[[bool, tuple[str, ...]], Any]:
    if part == "compare":
        return lambda quick, only: compare.main(quick, against, *compare.sort_names(only))
    if part == "instructions":
        return lambda quick, only: instructions.main(quick, only, write)
    parts: dict[str, Any] = {"components": components, "on_demand": on_demand, "scaling": scaling, "startup": startup}
    return (parts | {"memory": memory, "roofline": roofline})[part].main


def complaints(part: str, result: Any) -> list[str]:
    """What makes a result an error."""
    if part == "compare":
        failed = [
            f"{row['case']} {row['prec']}, {row['threads']} thread(s), {name}: {why}"
            for row in result["settings"]
            for name, why in row["failed"].items()
        ]
        return [f"programs disagree: {text}" for text in compare.disagreements(result)] + failed
    if part == "instructions":
        return [
            f"instructions of {name}: {result['counts'][name]:.0f}, more than {1 + instructions.ALLOWED:.2f} x {_known(result, name)}"
            for name in result["grown"]
        ]
    return []


def _known(result: Any, name: str) -> str:
    return f"{result['known'][name]:.0f} in the file" if name in result["known"] else "(not in the file; --write-instructions adds it)"


if __name__ == "__main__":
    sys.exit(main())
