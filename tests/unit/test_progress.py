"""The reporter: whole lines into a file, a moving line on a terminal, true numbers, next to no cost."""

import io
import subprocess
import sys
import time

import pytest

from mpmkit._core.running import progress
from mpmkit._core.running.progress import Reporter, si


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Clock:
    """A clock that tests move."""

    def __init__(self):
        self.now = 100.0

    def perf_counter(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    fake = Clock()
    monkeypatch.setattr(progress, "clock", fake)
    return fake


def run(reporter, clock, steps=100, seconds=40.0, until=1.0):
    for k in range(1, steps + 1):
        clock.now += seconds / steps
        reporter.update(k, until * k / steps, until / steps, 1e-6)


def test_lines_in_a_file_are_whole_rare_and_true(clock):
    out = io.StringIO()
    run(Reporter(1.0, 5000, stream=out), clock)
    lines = out.getvalue().splitlines()
    assert len(lines) == 4, "40 s of work, a line every 10 s"
    # 100 steps of 5000 particles in 40 s: 12.5 k particle-steps/s; after a quarter 30 s are left
    assert lines[0] == "step 25  t 0.25 s (25.0%)  dt 1.00e-02 s  12.5 kparticle-steps/s  ETA 30.0 s  energy balance +1.0e-06"
    assert "\r" not in out.getvalue() and "\x1b" not in out.getvalue()


def test_the_summary_keeps_compiling_apart(clock):
    out = io.StringIO()
    reporter = Reporter(1.0, 5000, stream=out)
    with reporter.compiling():
        clock.now += 60.0
    run(reporter, clock)
    reporter.finish(
        {"particles to grid": 30.0, "grid": 10.0},
        momentum_error=2e-15,
        files=["/very/long/path/" + 20 * "deep/" + "disks.vtkhdf"],
        status="finished",
    )
    text = out.getvalue()
    assert text.splitlines()[0] == "compiling the step (first time for this composition) ..."
    words = " ".join(text.split())
    for part in (
        "finished at t = 1 s", "wall time 0:01:40", "compiling 0:01:00", "steps 100", "speed 12.5 kparticle-steps/s",
        "energy balance +1.0e-06", "momentum error 2.0e-15", "particles to grid 30.000 75.0%", "grid 10.000 25.0%",
    ):  # fmt: skip
        assert part in words, part
    assert "/very/long/path/" + 20 * "deep/" + "disks.vtkhdf" in text, "a path is printed whole"


def test_the_share_of_writing_is_shown_once_there_is_some(clock):
    out = io.StringIO()
    reporter = Reporter(1.0, 5000, stream=out)
    with reporter.compiling():
        clock.now += 60.0
    for k in range(1, 101):
        clock.now += 0.4
        reporter.update(k, k / 100, 0.01, writing=0.02 * k)
    assert "ETA 30.0 s  writing 5.0%" in out.getvalue().splitlines()[2]
    reporter.finish(writing=2.2)
    assert "writing 2.2 s (5.5%)" in " ".join(out.getvalue().split())


def test_a_resumed_run_counts_only_its_own_steps(clock):
    out = io.StringIO()
    reporter = Reporter(2.0, 1000, stream=out, start_time=1.0, start_step=100)
    for k in range(101, 201):
        clock.now += 0.2
        reporter.update(k, k / 100, 0.01)
    assert out.getvalue().splitlines()[0].startswith("step 150  t 1.5 s (75.0%)  dt 1.00e-02 s  5 kparticle-steps/s  ETA 10.0 s")
    reporter.finish()
    assert "steps 100" in " ".join(out.getvalue().split())
    assert "balance" not in out.getvalue(), "what is not known is not shown"


def test_a_terminal_shows_one_moving_line(clock):
    out = Terminal()
    reporter = Reporter(1.0, 5000, stream=out)
    run(reporter, clock, seconds=10.0)
    shown = out.getvalue()
    assert 25 <= shown.count("particle-steps/s") <= 51, "at most five times a second, in 10 s of 100 steps"
    assert "\x1b[2K" in shown, "the line is drawn over"
    reporter.finish({"grid": 1.0})
    assert "wall time" in out.getvalue()
    reporter.stop()


def test_quiet_says_nothing(clock):
    for out in (io.StringIO(), Terminal()):
        reporter = Reporter(1.0, 5000, quiet=True, stream=out)
        with reporter.compiling():
            clock.now += 1.0
        run(reporter, clock)
        reporter.finish({"grid": 1.0}, files=["a"])
        assert out.getvalue() == ""


def test_an_update_costs_next_to_nothing():
    reporter = Reporter(1e9, 5000, stream=io.StringIO())
    began = time.perf_counter()
    for k in range(20_000):
        reporter.update(k, k * 1.0, 1.0, 0.0)
    # pinned: 0.2 us on a 2-core virtual machine in 2026; the bound leaves room for a busy one
    assert (time.perf_counter() - began) / 20_000 < 5e-6


def test_rich_is_imported_only_when_something_is_drawn():
    code = (
        "import sys; from mpmkit._core.running.progress import Reporter; Reporter(1.0, 1).update(1, 0.5, 0.5); print('rich' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "False"


def test_prefixes():
    assert [si(v) for v in (3.4123e6, 999.0, 12500.0, 2e9, 0.0)] == ["3.41 M", "999 ", "12.5 k", "2 G", "0 "]
