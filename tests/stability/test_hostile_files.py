"""Scene files that were spoiled: each is read and composed, or refused with a message that names the place; nothing else, and soon.

More of them: ``python tests/stability/fuzz.py files --count 10000 --seed 7``.
"""

import random

import pytest
from hostile_files import hostile, seeds
from judge_files import judge

import mpmkit as mpm

pytestmark = pytest.mark.usefixtures("plain_python")

GOOD = """
until = 1.0
[grid]
lower = [0.0]
upper = [1.0]
spacing = 0.25
[shape]
kind = "Linear"
[integrator]
kind = "MUSL"
[[bodies]]
geometry = { kind = "Box", lower = [0.25], upper = [0.5] }
material = { kind = "NeoHookean", E = 1.0, nu = 0.3, rho = 1.0 }
"""


@pytest.fixture
def plain_python(monkeypatch):
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")


@pytest.mark.parametrize("seed", range(4))
def test_spoiled_files_are_refused_or_run(seed, tmp_path):
    known = seeds()
    ends = []
    for number in range(100):
        raw, form = hostile(random.Random(f"{seed}/{number}"), known)
        path = tmp_path / f"scene.{form}"
        path.write_bytes(raw)
        outcome = judge(path)
        assert outcome.kind != "fault", f"file {number} of seed {seed}: {outcome.text}\n{raw.decode(errors='replace')}"
        ends.append(outcome.kind)
    assert {"refused", "runs"} <= set(ends)  # neither all spoiled beyond reading nor all left as they were


def test_what_they_were_made_from_runs(tmp_path):
    import tomli_w

    for k, data in enumerate(seeds()):
        path = tmp_path / f"scene{k}.toml"
        path.write_text(tomli_w.dumps(data))
        outcome = judge(path)
        assert outcome.kind == "runs", outcome


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("E = 1.0", f"E = {'9' * 5000}", ["not valid TOML", "digits"]),
        ("E = 1.0", f"E = 1{'0' * 400}", ["bodies[0].material.E", "too large", "..."]),
        ("E = 1.0", f"E = {[1.0] * 3000}", ["bodies[0].material.E must be a number", "..."]),
        ("E = 1.0", f'E = "{"a" * 10_000}"', ["bodies[0].material.E", "..."]),
        ("lower = [0.0]", f"lower = {[1.0] * 3000}", ["Grid.lower must have 1, 2 or 3 numbers, got 3000", "..."]),
        ('kind = "MUSL"', f'kind = "{"MUSL" * 3000}"', ["integrator.kind", "no integrator named", "..."]),
        ("until = 1.0", f"{'k' * 5000} = 1", ["unknown key", "..."]),
        ("until = 1.0", "until = 1.0\nz = " + "[" * 9000, ["nested too deep"]),
        ('geometry = {', 'name = "a/b"\ngeometry = {', ["bodies[0]", "Body.name must be printable", "'a/b'"]),
        ('geometry = {', 'name = "a\\u0000b"\ngeometry = {', ["bodies[0]", "Body.name must be printable"]),
        ('geometry = {', 'name = ".."\ngeometry = {', ["bodies[0]", "not only dots"]),
    ],
)  # fmt: skip
def test_faults_that_were_found(old, new, says):
    """Each of these once ended in an exception of Python, a message of many pages, or a checkpoint that could not be read."""
    with pytest.raises(mpm.SceneError) as caught:
        mpm.scene.loads(GOOD.replace(old, new, 1))
    message = str(caught.value)
    assert len(message) < 1500
    for text in says:
        assert text in message


def test_no_formula_is_executed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for text in ("__import__('os').mkdir('hacked')", "().__class__", "open('hacked', 'w')", "exec('1')", "(x := 1)", "[x for x in (1,)]"):
        with pytest.raises(mpm.SceneError, match="v"):
            mpm.scene.loads(GOOD.replace("material =", f'v = ["{text}"]\nmaterial ='))
    assert not list(tmp_path.iterdir())
