"""The benchmarks run and their logic is right; nothing here looks at a speed."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numpy as np
import pytest

SIZE_T = ("--size", "T", "--budget", "0", "--steps", "8")


@pytest.fixture(autouse=True)
def from_the_top(root, monkeypatch):
    """The benchmarks are not installed: they are started from the top of the checkout."""
    monkeypatch.syspath_prepend(str(root))


def line(impl="mpmkit", mps=10.0, **more):
    numbers = {"px": 250.0, "pz": 60.0, "ke": 585.0, "sx2": 0.8, "j": 1.0, "f2": 3.0} | more.pop("diag20", {})
    base = {"impl": impl, "case": "apic3", "size": "S", "prec": "f64", "threads": 1, "n": 262144}
    return base | {"mps_min": mps, "mps_med": mps, "mps_max": mps, "diag20": numbers} | more


@pytest.mark.parametrize("case", ["apic2", *(pytest.param(case, marks=pytest.mark.physics) for case in ("apic3", "flip3"))])
def test_a_tiny_run_prints_its_line_and_moves_as_the_exact_motion(case, root):
    from benchmarks import problem

    size = problem.SIZES[problem.CASES[case], "T"]
    command = [sys.executable, "-m", "benchmarks.mpmkit_program", "--case", case, *SIZE_T]
    out = subprocess.run(command, capture_output=True, text=True, cwd=root, env=os.environ | {"NUMBA_DISABLE_JIT": "0"}, timeout=300)
    assert out.returncode == 0, out.stderr
    found = json.loads(out.stdout.splitlines()[-1])
    assert found["n"] == size.particles and found["impl"] == "mpmkit" and found["case"] == case
    assert 0.0 < found["mps_min"] <= found["mps_med"] <= found["mps_max"]
    assert sum(found["phases"].values()) == pytest.approx(1.0)
    mass = size.mass * size.particles
    exact = {"px": 2.0 * mass, "pz": mass * (problem.TRANSLATION[size.dim - 1] - problem.GRAVITY * 20 * size.dt)}
    for name, value in exact.items():  # no wall is touched: momentum to rounding, a thousand particles and twenty steps
        assert found["diag20"][name] == pytest.approx(value, rel=1e-12)


def test_the_start_is_a_lattice_with_a_rigid_motion():
    from benchmarks import problem

    size = problem.SIZES[3, "T"]
    x, v = problem.start(size)
    assert x.shape == v.shape == (size.particles, 3)
    assert len(np.unique(np.round(x / size.h * 4), axis=0)) == size.particles
    assert np.all(x > size.h * np.array(size.lower)) and np.all(x < size.h * (np.array(size.lower) + size.block))
    r = x - 0.5
    spin = np.cross([0.0, 0.0, problem.OMEGA], r)
    np.testing.assert_allclose(v, np.array(problem.TRANSLATION) + spin, rtol=1e-14, atol=1e-13)
    assert [s.particles for key, s in problem.SIZES.items() if key[1] in "SL"] == [262144, 1048576, 262144]


def test_programs_agree_or_are_told_apart():
    from benchmarks.agreement import agreement

    assert agreement(line(), line("other", diag20={"ke": 585.0 * (1 + 1e-13)}))["agrees"]
    apart = agreement(line(), line("other", diag20={"ke": 585.0 * (1 + 1e-9)}))
    assert not apart["agrees"] and apart["of"] == "ke" and apart["difference"] == pytest.approx(1e-9, rel=1e-3)
    assert agreement(line(prec="f32"), line("other", prec="f32", diag20={"ke": 585.0 * (1 + 1e-6)}))["agrees"]
    assert "n is 8" in agreement(line(), line("other", n=8))["note"]
    # by construction only where it is said, and only of mpmkit
    near = {"diag20": {"ke": 585.0 * (1 + 1e-5)}}
    assert agreement(line(case="flip3"), line("other", case="flip3", **near))["note"]
    assert agreement(line(case="flip3"), line("other", case="flip3", **near))["agrees"]
    assert not agreement(line("one", case="flip3"), line("other", case="flip3", **near))["agrees"]


def test_ratios_are_taken_within_rounds():
    from benchmarks import compare

    lines = {
        "mpmkit": [line(mps=10.0), line(mps=40.0), line(mps=20.0)],
        "other": [line("other", 5.0), line("other", 10.0), line("other", 10.0)],
    }
    found = compare.summary(lines)
    assert found["other"]["ratio"] == [
        2.0,
        2.0,
        4.0,
    ]  # the median of the ratios, not the ratio of the medians (which is 2 too), lowest, highest
    assert found["mpmkit"]["mps"] == [20.0, 10.0, 40.0]
    row = {"case": "apic3", "size": "S", "prec": "f64", "threads": 1, "programs": found, "failed": {}}
    assert "mpmkit is 2.00 x (2.00 to 4.00)" in compare.text(row)
    assert compare.disagreements({"settings": [row]}) == []
    lines["other"][0]["diag20"]["j"] = 1.1
    row["programs"] = compare.summary(lines)
    assert compare.disagreements({"settings": [row]}) == ["apic3 S f64 1: other"]
    assert "NOT THE SAME RESULT" in compare.text(row)


def test_any_program_with_the_line_can_be_compared(tmp_path):
    from benchmarks import compare

    good, bad = tmp_path / "good.py", tmp_path / "bad.py"
    good.write_text(f"print('hello'); print('''{json.dumps(line('other'))}''')")
    bad.write_text("raise SystemExit('no such case')")
    programs, missing = compare.commands({"good": f"{sys.executable} {good}", "bad": f"{sys.executable} {bad}"}, only=("good",))
    assert list(programs) == ["mpmkit", "good", "bad"] and missing == {}
    del programs["mpmkit"]
    lines, failed = compare.rounds(programs, {"case": "apic3", "size": "S", "prec": "f64", "threads": 1}, count=2, budget=0.0)
    assert [found["impl"] for found in lines["good"]] == ["other", "other"]
    assert "bad" not in lines and "no such case" in failed["bad"]


def test_operations_are_counted_in_the_text_of_kernels():
    from benchmarks.arithmetic import operations
    from mpmkit.math import sqrt
    from mpmkit.shapes import CubicBSpline, Linear, QuadraticBSpline

    def inner(a):
        return sqrt(a) + 1.0

    def outer(a, b):
        return -a * inner(b)

    outer.__globals__["inner"] = inner
    try:
        assert operations(inner) == 9
        assert operations(outer) == 2 + 9
    finally:
        del outer.__globals__["inner"]
    assert 0 < operations(Linear.weights) < operations(QuadraticBSpline.weights) < operations(CubicBSpline.weights)


def test_more_nodes_fields_and_loops_are_more_work(monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")  # counted in the text, not run
    from benchmarks import arithmetic, inside, variants

    chosen = {v.name: v for v in variants.variants()}
    work = {}
    for name in ("base", "Linear", "APIC", "MUSL", "XPIC(3)"):
        v = chosen[name]
        with inside.quiet():
            stepper = inside.Stepper(variants.compose(v, 4).compose())
        work[name] = (
            arithmetic.flops(stepper, v.shape, v.integrator.transfer, v.material),
            sum(arithmetic.traffic(stepper, 8, 8).values()),
        )
    for name in ("APIC", "MUSL", "XPIC(3)"):
        assert work[name][0] > work["base"][0] and work[name][1] > work["base"][1], name
    assert work["Linear"][0] < 0.5 * work["base"][0]


def test_every_bundled_component_is_among_the_variants():
    from benchmarks import variants
    from mpmkit._core.registry import registry

    text = repr(variants.variants())
    for kind in ("shape", "material", "transfer", "contact", "effect"):
        for name, entry in registry().of(kind).items():
            assert entry.distribution != "mpmkit" or f"{name}(" in text, name


def test_callgrind_dumps_are_read(tmp_path):
    from benchmarks import instructions

    for number, (steps, total) in enumerate(((2, 3000), (8, 9000)), 1):
        (tmp_path / f"counts.{number}").write_text(f"version: 1\ndesc: Trigger: Client Request: {steps}/10\nevents: Ir\ntotals: {total}\n")
    (tmp_path / "counts").write_text("version: 1\ndesc: Trigger: Program termination\ntotals: 7\n")
    assert instructions.read(sorted(tmp_path.iterdir())) == 100.0
    with pytest.raises(instructions.NotCounted, match=r"counts of \[2\] steps"):
        instructions.read([tmp_path / "counts.1"])
    known = {"a": 100.0, "b": 100.0}
    assert instructions.compare({"a": 109.0, "b": 111.0, "c": 1.0}, known) == ["b", "c"]


def test_tables_and_pictures_come_from_the_results(tmp_path):
    from benchmarks import compare, report

    lines = {"mpmkit": [line(mps=12.5, phases={"p2g": 0.4, "g2p": 0.6})], "other": [line("other", 5.0)]}
    setting = {"case": "apic3", "size": "S", "prec": "f64", "threads": 1, "programs": compare.summary(lines), "failed": {}}
    report.save(tmp_path, "compare", {"rounds": 1, "missing": {"gone": "is not installed"}, "settings": [setting]}, quick=True)
    component = {
        "name": "base",
        "group": "base",
        "base": "base",
        "ns": 40.0,
        "ratio": 1.0,
        "expected": 1.0,
        "over": 1.0,
        "nodes": 27,
        "passes": 2,
    }
    report.save(tmp_path, "components", {"particles": 8000, "rounds": 3, "rows": [component | {"flops": 2000, "bytes": 700.0}]}, quick=True)
    used = {"particles": 1000, "particle fields": 2e6, "node fields": 2e6, "peak": 5e6, "peak with frames": 6e6}
    report.save(tmp_path, "memory", [{"stepper": "MUSL, FLIP"} | used], quick=True)
    report.main(tmp_path)
    text = (tmp_path / "tables.md").read_text()
    assert "| MUSL, FLIP | 2 | 2 | 5: 1.25 x | 6: 1.50 x |" in text
    assert "| apic3 S f64, 1 thread | 12.5 | 5.00: 2.50 x (2.50 to 2.50) | 0e+00 |" in text
    assert "p2g 40%, g2p 60%" in text and "Not measured: gone, is not installed." in text and "A quick run" in text
    assert (tmp_path / "performance_compare.png").stat().st_size > 1000
    assert (tmp_path / "performance_components.png").stat().st_size > 1000


@pytest.mark.physics
def test_memory_counts_fields_and_growth(root):
    from benchmarks import memory

    found = memory._child("MUSL, FLIP", True, 4)
    assert found["particles"] == 512 and found["particle fields"] == 512 * 17 * 8 and found["peak"] >= 0  # 17 numbers: x, v, m, V0, F


def test_wrong_words_on_the_command_line_are_refused(capsys):
    from benchmarks.__main__ import main

    for words, message in ((["compar"], "no part is named 'compar'"), (["compare", "--against", "x"], "must be NAME=COMMAND")):
        with pytest.raises(SystemExit):
            main(words)
        assert message in capsys.readouterr().err


def test_programs_of_others_are_not_imported_by_mpmkit(root, pyproject):
    extra = {text.split(">")[0] for text in pyproject["project"]["optional-dependencies"]["bench"]}
    assert extra == {"jax", "taichi", "warp-lang"}
    for path in [*(root / "src").rglob("*.py"), *(root / "plugins").rglob("*.py")]:
        text = path.read_text(encoding="utf-8")
        assert not any(f"import {name}" in text for name in ("benchmarks", "jax", "taichi", "warp")), path
