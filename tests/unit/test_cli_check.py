"""mpmkit check: what plugins do in their processes, and what the report says about it."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from mpmkit import cli
from mpmkit.cli.check import show
from mpmkit.testing import isolated

GOOD = '''
    """A plugin."""
    import os, sys, time, warnings
    import mpmkit as mpm

    @mpm.kernel
    def pull(v, strength):
        """a = -s v."""
        return (-strength * v[0], -strength * v[1], -strength * v[2])

    @mpm.define
    class {name}(mpm.Effect):
        """Pulls, a = -s v."""

        references = ("none",)
        strength: float = mpm.parameter("how much", unit="1/s", ge=0.0, example=1.0)
        acceleration = pull
        {body}

    @mpm.hookimpl
    def mpmkit_components():
        return [{name}]
'''
"""Source of a plugin with one effect; `body` is more of its class."""

RATES = (
    "def rates(self):\n            if sys._getframe(1).f_code.co_name == 'rates_are_rates':\n                {}\n            return {{}}"
)
"""A method that does something in one check only."""


@pytest.fixture
def call(capsys):
    """Run a command in this process; returns status, stdout and stderr."""

    def run(*arguments):
        with pytest.raises(SystemExit) as ended:
            cli.main(arguments)
        out, err = capsys.readouterr()
        return ended.value.code, out, err

    return run


@pytest.fixture
def plugin(fakes, monkeypatch):
    """Install a plugin with one effect, also for child processes."""
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(fakes.folder), *filter(None, [os.environ.get("PYTHONPATH")])]))
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")  # what is compiled is not what these tests are about

    def install(name="Puller", body="", point="puller", statement=None):
        body = RATES.format(statement) if statement else body
        fakes.add(f"mpmkit-{point}", f"module_{point}", GOOD.format(name=name, body=body), point=point)

    return install


def rows_of(call, *arguments):
    status, out, _ = call("check", *arguments, "--json")
    return status, json.loads(out)


def test_a_good_plugin_passes_and_is_told_in_a_table(call, plugin):
    plugin(body="def rates(self):\n            return {'pull': self.strength}")
    status, out, err = call("check", "puller")
    lines = out.splitlines()
    assert (status, err) == (0, "")
    assert lines[0].split() == ["component", "kind", "plugin", "passed", "failed", "known", "failures", "time"]
    assert lines[2].split()[:3] == ["Puller", "effect", "puller"]
    assert "0 failed; " in lines[-1]
    assert not any(line.startswith("ok") for line in lines)


def test_verbose_shows_every_check(capsys):
    row = {"plugin": "p", "component": "C", "kind": "effect", "check": "acts", "passed": True, "reason": "", "known": False}
    show([row | {"seconds": 0.5, "warnings": []}], verbose=True)
    assert "ok      C  acts  (0.50 s)\n" in capsys.readouterr().out


def test_json_has_a_row_for_each_check(call, plugin):
    plugin()
    status, rows = rows_of(call, "mpmkit-puller")
    assert status == 0
    assert {r["component"] for r in rows} == {"Puller"}
    assert set(rows[0]) == {"plugin", "component", "kind", "check", "passed", "reason", "known", "seconds", "warnings"}
    assert len(rows) == len({r["check"] for r in rows}) > 25


def test_a_failed_check_is_told_with_its_reason(call, plugin):
    plugin(statement="return {'pull': float('nan')}")
    status, out, _ = call("check", "puller")
    assert status == 1
    assert "FAILED  Puller  rates are rates  rate 'pull' is nan" in out
    assert "1 failed" in out


@pytest.mark.parametrize(
    ("statement", "told"),
    [
        ("os._exit(7)", "the process ended with status 7"),
        ("os.kill(os.getpid(), 11)", "killed by signal 11 (SIGSEGV)"),
        pytest.param("time.sleep(1e6)", "did not end within 10 s", marks=pytest.mark.physics),
    ],
    ids=["exit", "crash", "hang"],
)
def test_a_crash_or_hang_fails_the_checks_it_stops_and_no_other(call, plugin, statement, told):
    plugin(statement=statement)
    status, rows = rows_of(call, "puller", "--timeout", "10")
    assert status == 1
    assert [(r["check"], told in r["reason"]) for r in rows if not r["passed"]] == [("rates are rates", True)]
    names = [r["check"] for r in rows]
    assert "pickles" in names[: names.index("rates are rates")] and "acts" in names[names.index("rates are rates") :]


def test_a_plugin_that_always_crashes_is_given_up(call, plugin, monkeypatch):
    monkeypatch.setattr(isolated, "MOST_DEATHS", 3)
    plugin(body="def __eq__(self, other):\n            os._exit(7)")
    status, rows = rows_of(call, "puller")
    failed = [r["reason"] for r in rows if not r["passed"]]
    assert status == 1
    assert 0 < len(failed) <= 4
    assert "status 7" in failed[0]


def test_sys_exit_prints_and_warnings_are_survived(call, plugin):
    plugin(statement="print('noise'); sys.stderr.write('more'); warnings.warn('an old plugin'); sys.exit(3)")
    status, rows = rows_of(call, "puller")
    row = next(r for r in rows if r["check"] == "rates are rates")
    assert status == 1
    assert row["reason"] == "SystemExit: 3"
    assert row["warnings"] == ["UserWarning: an old plugin"]
    assert not any(r["warnings"] for r in rows if r is not row)


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("import a_module_that_is_not_there", "ModuleNotFoundError"),
        ("import sys; sys.exit(2)", "SystemExit: 2"),
        ("import os; os._exit(9)", "before the first check the process ended with status 9"),
        ("import time; time.sleep(1e6)", "before the first check did not end within 5 s"),
    ],
    ids=["import", "sys.exit", "exit", "hang"],
)
def test_a_plugin_that_cannot_be_loaded_is_one_failed_check(call, plugin, fakes, source, told):
    fakes.add("mpmkit-bad", "bad", source)
    status, rows = rows_of(call, "bad", "--timeout", "5")
    assert status == 1
    assert [(r["component"], r["check"], r["passed"]) for r in rows] == [("bad", "entry point loads", False)]
    assert told in rows[0]["reason"]


@pytest.mark.physics
def test_another_plugin_that_hangs_does_not_stop_the_check_of_a_good_one(call, plugin, fakes):
    plugin()
    fakes.add("mpmkit-bad", "bad", "import time; time.sleep(1e6)")
    status, rows = rows_of(call, "puller", "--timeout", "10")
    assert status == 0
    assert len(rows) > 25


def test_without_a_name_all_plugins_are_checked_each_by_itself(call, plugin, fakes, monkeypatch):
    plugin()
    plugin(name="Other", point="other", statement="return {'pull': float('nan')}")
    bundled = ",".join(name for name, distribution in isolated.plugins().items() if distribution == "mpmkit")
    monkeypatch.setenv("MPMKIT_DISABLE_PLUGINS", bundled)
    monkeypatch.setattr("mpmkit.cli.check.run", lambda names, timeout, jobs: [{"plugin": n, "passed": True} for n in names])
    wanted = {n for n, d in isolated.plugins().items() if n in ("other", "puller")}
    for arguments in ((), ("--all",)):
        assert {r["plugin"] for r in rows_of(call, *arguments)[1]} >= wanted == {"other", "puller"}


def test_several_plugins_are_told_in_the_order_of_their_names(call, plugin):
    plugin()
    plugin(name="Other", point="other", statement="return {'pull': float('nan')}")
    status, rows = rows_of(call, "puller", "other")
    assert status == 1
    assert list(dict.fromkeys(r["plugin"] for r in rows)) == ["puller", "other"]
    assert {r["plugin"] for r in rows if not r["passed"]} == {"other"}


@pytest.mark.parametrize(
    ("arguments", "status", "told"),
    [
        (["materals"], 1, "did you mean 'materials'"),
        (["materials", "--all"], 2, "not both"),
        (["materials", "--timeout", "0"], 2, "--timeout"),
    ],
)
def test_mistakes(call, arguments, status, told):
    code, out, err = call("check", *arguments)
    assert (code, out) == (status, "")
    assert told in err


def test_ctrl_c_ends_the_processes_of_the_plugins(plugin, fakes):
    plugin(statement=f"open({str(fakes.folder / 'pid')!r}, 'w').write(str(os.getpid())); time.sleep(1e6)")
    process = subprocess.Popen([sys.executable, "-m", "mpmkit", "check", "puller"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    begun = time.monotonic()
    while not (fakes.folder / "pid").exists() or not (fakes.folder / "pid").read_text():
        assert time.monotonic() - begun < 60 and process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert b"interrupted" in err
    with pytest.raises(ProcessLookupError):
        os.kill(int((fakes.folder / "pid").read_text()), 0)
