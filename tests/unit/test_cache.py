"""Compiled code on disk: shared, read-only, damaged, killed, full and absent folders; every process is one of its own."""

import ctypes
import json
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time

import pytest

TEXT = """
@compiled
def total(a, k):
    s = zero
    for i in range(a.size):
        s += k * a[i]
    return s
"""
CHILD = f"""
import json, os, resource, signal, sys, warnings
warnings.simplefilter("always")
import numpy as np
from mpmkit._core.composing import cache
from mpmkit._core.composing.jit import compiled

kill_at = int(sys.argv[1])
replace = os.replace
def counted(*paths):
    global kill_at
    kill_at -= 1
    if kill_at == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    replace(*paths)
os.replace = counted

module = cache.load("0123456789abcdef0123", {TEXT!r}, {{"compiled": compiled, "zero": 0.0}})
results = [module.total(np.arange(5.0), 2.0), module.total(np.arange(5, dtype=np.float32), 3)]
found = [module.total.stats.cache_hits, module.total.stats.cache_misses]
print(json.dumps({{"results": results, "hits": sum(found[0].values()), "misses": sum(found[1].values()), "file": module.__file__}}))
"""
RESULTS = [20.0, 30.0]
MINE = "0123456789abcdef0123"

pytestmark = pytest.mark.skipif(os.name != "posix", reason="permissions, limits and signals of POSIX")


def obey():
    """The superuser, too, minds permissions."""
    if os.geteuid() == 0:
        ctypes.CDLL(None).prctl(24, 1, 0, 0, 0)  # PR_CAPBSET_DROP, CAP_DAC_OVERRIDE


def start(place, home, kill_at=0, limit=obey):
    named = {} if place is None else {"MPMKIT_CACHE_DIR": str(place)}
    environment = {k: v for k, v in os.environ.items() if k != "MPMKIT_CACHE_DIR"} | named
    environment |= {"XDG_CACHE_HOME": str(home), "TMPDIR": str(home.parent), "NUMBA_DISABLE_JIT": "0"}
    return subprocess.Popen(
        [sys.executable, "-c", CHILD, str(kill_at)],
        env=environment, preexec_fn=limit, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def finish(process):
    out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    found = json.loads(out)
    assert found["results"] == RESULTS
    return found | {"notices": [line for line in err.splitlines() if "UserWarning: mpmkit: " in line]}


def listing(place):
    return {str(p.relative_to(place)): p.read_bytes() for p in sorted(place.rglob("*")) if p.is_file()}


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    """A folder that one process has filled; do not write to it."""
    place = tmp_path_factory.mktemp("warm") / "cache"
    first = finish(start(place, place.parent / "user"))
    assert (first["hits"], first["misses"], first["notices"]) == (0, 2, [])
    assert sorted(name.split("-")[0] for name in listing(place)) == [f"{MINE}/step.py", f"{MINE}/total", f"{MINE}/total"]
    return place


def copy(warm, tmp_path):
    place = tmp_path / "cache"
    shutil.copytree(warm, place)
    return place, sorted((place / MINE).glob("*.code"))


def test_the_next_process_compiles_nothing_and_writes_nothing(warm):
    before = listing(warm)
    again = finish(start(warm, warm.parent / "user"))
    assert (again["hits"], again["misses"]) == (2, 0)
    assert listing(warm) == before


def test_damaged_files_are_compiled_again_and_healed(warm, tmp_path):
    place, code = copy(warm, tmp_path)
    good = code[0].read_bytes()
    code[0].write_bytes(good[: len(good) // 2])
    flipped = bytearray(code[1].read_bytes())
    flipped[len(flipped) // 2] ^= 4
    code[1].write_bytes(flipped)
    (place / MINE / "step.py").write_text(TEXT[:40])
    found = finish(start(place, tmp_path / "user"))
    assert (found["hits"], found["misses"], found["notices"]) == (0, 2, [])
    assert (place / MINE / "step.py").read_text() == TEXT
    code[0].write_bytes(b"")
    found = finish(start(place, tmp_path / "user"))
    assert (found["hits"], found["misses"], found["notices"]) == (1, 1, [])


def test_processes_at_once(tmp_path):
    """All start with nothing; each is right, and what they leave serves the next."""
    place = tmp_path / "cache"
    for found in [finish(p) for p in [start(place, tmp_path / "user") for _ in range(3)]]:
        assert found["notices"] == []
    assert not list(place.rglob("*.tmp"))
    assert finish(start(place, tmp_path / "user"))["misses"] == 0


def test_killed_while_writing(tmp_path):
    """In the moment before the second file (the first machine code) gets its name."""
    place = tmp_path / "cache"
    process = start(place, tmp_path / "user", kill_at=2)
    process.communicate(timeout=60)
    assert process.returncode == -signal.SIGKILL
    (left,) = place.rglob("*.tmp")
    os.utime(left, (time.time() - 7200,) * 2)
    found = finish(start(place, tmp_path / "user"))
    assert (found["misses"], found["notices"]) == (2, [])
    assert not left.exists(), "what nobody is going to rename is removed"


def test_read_only_folder_with_the_module_is_used_and_not_written(warm, tmp_path):
    place, code = copy(warm, tmp_path)
    for path in (place / MINE, place):
        path.chmod(0o555)
    before = listing(place)
    found = finish(start(place, tmp_path / "user"))
    assert (found["hits"], found["misses"], found["notices"]) == (2, 0, [])
    assert listing(place) == before and not (listing(tmp_path / "user") if (tmp_path / "user").exists() else {})
    # one of its two compiled signatures is missing: that one, and nothing else, goes to the user's folder
    (place / MINE).chmod(0o755)
    code[0].unlink()
    (place / MINE).chmod(0o555)
    found = finish(start(place, tmp_path / "user"))
    assert (found["hits"], found["misses"]) == (1, 1)
    assert len(found["notices"]) == 1 and f"{place} is not writable; compiling into {tmp_path / 'user' / 'mpmkit'}" in found["notices"][0]
    found = finish(start(place, tmp_path / "user"))
    assert (found["hits"], found["misses"], found["notices"]) == (2, 0, [])


def test_no_folder_can_be_written(tmp_path):
    """One line of notice, a temporary folder, gone at the end."""
    (tmp_path / "file").write_text("not a folder")
    found = finish(start(tmp_path / "file" / "cache", tmp_path / "file"))
    assert len(found["notices"]) == 1 and "not writable" in found["notices"][0] and "for this process only" in found["notices"][0]
    assert str(tmp_path / "mpmkit-") in found["file"] and not os.path.exists(found["file"])
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file"]


def test_full_disk(tmp_path):
    """Files of 4 kB are the largest: the text fits, machine code does not."""

    def full():
        import resource

        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))

    found = finish(start(tmp_path / "cache", tmp_path / "user", limit=full))
    assert len(found["notices"]) == 1 and "File too large" in found["notices"][0] and "is not kept" in found["notices"][0]
    assert list(listing(tmp_path / "cache")) == [f"{MINE}/step.py"]


def test_the_users_own_folder_is_the_default(tmp_path):
    found = finish(start(None, tmp_path / "user"))
    assert found["file"] == str(tmp_path / "user" / "mpmkit" / MINE / "step.py") and found["notices"] == []


SCENE = """
import sys
sys.path.insert(0, {folder!r})
from small_scenes import bar
sim = bar(v=0.1)
sim.run(until=0.1, quiet=True)
print(sim.particles()["x"].tobytes().hex(), sum(sum(f.stats.cache_misses.values()) for f in vars(sim.compose().plan.module).values()
                                                if hasattr(f, "stats") and f.__module__.startswith("mpmkit_step")))
"""


@pytest.mark.physics
def test_two_runs_of_one_composition_at_once(tmp_path):
    environment = os.environ | {"MPMKIT_CACHE_DIR": str(tmp_path), "NUMBA_DISABLE_JIT": "0"}
    text = textwrap.dedent(SCENE.format(folder=os.path.dirname(__file__)))

    def begin():
        return subprocess.Popen([sys.executable, "-c", text], env=environment, stdout=subprocess.PIPE, text=True)

    states = [p.communicate(timeout=120)[0].split()[0] for p in (begin(), begin())]
    third = begin().communicate(timeout=60)[0].split()
    assert states[0] == states[1] == third[0] and third[1] == "0"
