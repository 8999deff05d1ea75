"""Instructions per particle-step, counted by callgrind: a number that does not depend on the machine's speed and load.

The generated code is compiled for a fixed processor (`PROCESSOR`): valgrind knows no AVX-512, and a number in the repository should not
depend on the machine. Only steps are counted: the process turns the counting on and off itself, and the difference between many and few
steps leaves out what is done once. Another version of the compiler may count differently, so the file names the one it was made with.
"""

from __future__ import annotations

import ctypes
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks import problem

ROOT = Path(__file__).parents[1]
FILE = ROOT / "benchmarks/instructions.json"
PROCESSOR, FEATURES = "haswell", "+avx2,+fma,+bmi,+bmi2,+lzcnt,+popcnt,+movbe"
"""What the steps are compiled for; named in full, since valgrind shows programs another processor than the host's."""
ALLOWED = 0.10
"""More instructions than in the file by this share are an error."""
FEW, MANY = 2, 8
"""Steps whose difference is taken."""
SIZES = {3: problem.cube(8000), 2: problem.SIZES[2, "Q"]}
"""Large enough that what a step costs once, in Python and at nodes without particles, counts little."""
SETTINGS = {f"{case} {prec}": (case, prec) for case in problem.CASES for prec in problem.PRECISIONS}
START, STOP, DUMP = 4, 5, 3  # of valgrind/callgrind.h: START_INSTRUMENTATION, STOP_INSTRUMENTATION, DUMP_STATS_AT

REQUEST = """
define i64 @request(i64* %arguments) {
  %r = call i64 asm sideeffect "rolq $$3, %rdi\\0Arolq $$13, %rdi\\0Arolq $$61, %rdi\\0Arolq $$51, %rdi\\0Axchgq %rbx, %rbx",
    "={rdx},{rax},{rdx},~{cc},~{memory}"(i64* %arguments, i64 0)
  ret i64 %r
}
"""
"""What valgrind takes for a request (valgrind.h, amd64); a processor sees rotations by 128 bits in all, which change nothing."""


class NotCounted(RuntimeError):
    """No count could be made here; says what is missing."""


def main(quick: bool = False, only: tuple[str, ...] = (), write: bool = False) -> dict[str, Any]:
    """Count all settings (or those in `only`), and compare with the file or write it.

    Returns
    -------
    dict
        ``processor``, ``counts`` by setting, ``known`` from the file, ``grown``: settings beyond what is allowed.
    """
    names = [n for n in SETTINGS if (not only or n in only or SETTINGS[n][0] in only) and (not quick or n == "apic3 f64")]
    counts = callgrind(names)
    known = json.loads(FILE.read_text())["counts"] if FILE.exists() else {}
    grown = compare(counts, known)
    for name, found in counts.items():
        before = f", {found / known[name] - 1.0:+.1%} against {known[name]:.0f}" if name in known else ""
        print(f"  {name}: {found:.0f} instructions per particle-step{before}", flush=True)
    result = {
        "processor": PROCESSOR,
        "particles": {d: s.particles for d, s in SIZES.items()},
        "compiler": compiler(),
        "counts": {**known, **counts} if write else counts,
    }
    if write:
        FILE.write_text(json.dumps(result, indent=2) + "\n")
    return result | {"known": known, "grown": [] if write else grown}


def compare(counts: dict[str, float], known: dict[str, float]) -> list[str]:
    """Settings that need more than `ALLOWED` above what is known; one that is not known counts too."""
    return [name for name, found in counts.items() if name not in known or found > (1.0 + ALLOWED) * known[name]]


def compiler() -> dict[str, str]:
    """Versions that the generated instructions depend on."""
    return {name: version(name) for name in ("numba", "llvmlite")}


def callgrind(names: list[str]) -> dict[str, float]:
    """Run each setting in a process of its own under callgrind.

    Raises
    ------
    NotCounted
        If valgrind is not installed, a process fails (with the end of what it said), or a count makes no sense.
    """
    valgrind = shutil.which("valgrind")
    if valgrind is None:
        raise NotCounted("valgrind is not installed (on Debian: apt install valgrind); nothing was counted")
    environment = os.environ | {"NUMBA_CPU_NAME": PROCESSOR, "NUMBA_CPU_FEATURES": FEATURES, "PYTHONHASHSEED": "0", "MPMKIT_THREADS": "1"}
    environment |= {"PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])}
    counts = {}
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            count = [valgrind, "--tool=callgrind", "--instr-atstart=no", f"--callgrind-out-file={folder}/counts"]
            for tool in ([], count):  # once without valgrind: so the steps are compiled at full speed, and the second process finds them
                command = [*tool, sys.executable, "-m", "benchmarks.instructions", name]
                done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=ROOT, timeout=3600)
                if done.returncode:
                    raise NotCounted(f"{' '.join(command)} failed ({done.returncode}): {done.stderr.strip()[-800:]}")
            counts[name] = read([Path(p) for p in sorted(Path(folder).iterdir())])
        if not 0.0 < counts[name] < 1e6:
            raise NotCounted(f"{name}: {counts[name]:.3g} instructions per particle-step cannot be; valgrind counted wrongly")
    return counts


def read(dumps: list[Path]) -> float:
    """Instructions per particle-step from the dumps, which carry ``steps/particles`` as their reason."""
    found = {}
    for path in dumps:
        text = path.read_text()
        reason = re.search(r"^desc: Trigger: Client Request: (\d+)/(\d+)$", text, re.MULTILINE)
        total = re.search(r"^(?:totals|summary): (\d+)", text, re.MULTILINE)
        if reason and total:
            found[int(reason[1])] = int(total[1]) / int(reason[2])
    if set(found) != {FEW, MANY}:
        raise NotCounted(f"callgrind left counts of {sorted(found)} steps in place of {FEW} and {MANY}")
    return (found[MANY] - found[FEW]) / (MANY - FEW)


def child(name: str) -> None:
    """Under valgrind: few and many steps, with a dump after each."""
    from benchmarks import inside, mpmkit_program
    from benchmarks.machine import native

    request = native(REQUEST, "request", ctypes.c_int64, ctypes.POINTER(ctypes.c_int64))

    def ask(what: int, text: bytes = b"") -> None:
        reason = ctypes.create_string_buffer(text)
        words = (ctypes.c_int64 * 6)((ord("C") << 24) + (ord("T") << 16) + what, ctypes.addressof(reason), 0, 0, 0, 0)
        request(words)

    case, prec = SETTINGS[name]
    size = SIZES[problem.CASES[case]]
    stepper = inside.stepper(mpmkit_program.compose(case, size, "float64" if prec == "f64" else "float32"))
    stepper.steps(2, size.dt)
    for count in (FEW, MANY):
        ask(START)
        stepper.steps(count, size.dt)
        ask(DUMP, f"{count}/{size.particles}".encode())
        ask(STOP)


if __name__ == "__main__":
    child(sys.argv[1])
