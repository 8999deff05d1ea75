"""Throws random files, compositions, kills and damage at mpmkit and counts what comes of it.

python tests/stability/fuzz.py files --count 5000 --seed 1
"""

from __future__ import annotations

import argparse
import collections
import os
import random
import re
import sys
import tempfile
import time
from pathlib import Path


def files(count: int, seed: int, show: int) -> int:
    """Hostile scene files."""
    import resource

    from hostile_files import hostile, seeds
    from judge_files import judge

    os.environ["NUMBA_DISABLE_JIT"] = "1"
    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    known, tally, templates, slowest = seeds(), collections.Counter(), {}, 0.0
    faults: dict[str, tuple[int, str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            rng = random.Random(f"{seed}/{number}")
            raw, form = hostile(rng, known)
            path = Path(folder) / f"scene.{form}"
            path.write_bytes(raw)
            began = time.perf_counter()
            outcome = judge(path)
            slowest = max(slowest, time.perf_counter() - began)
            tally[outcome.kind, outcome.stage] += 1
            if outcome.kind == "fault":
                key = re.sub(r"[\d.e+-]+", "#", outcome.text)[:120]
                if key not in faults:
                    faults[key] = (number, outcome.text)
                    kept = Path(tempfile.gettempdir()) / f"fault-{seed}-{number}.{form}"
                    kept.write_bytes(raw)
                    print(f"FAULT {number} [{outcome.stage}] {outcome.text[:600]}\n   kept as {kept}", flush=True)
            elif outcome.kind == "refused" and outcome.stage == "compose":
                templates.setdefault(re.sub(r"[\d.e+-]+|'[^']*'", "#", outcome.text)[:70], outcome.text)
    print(f"{count} files: {dict(tally)}, {len(faults)} kinds of fault, slowest {slowest:.1f} s")
    for text in sorted(templates.values())[:show]:
        print("  ", text[:300].replace("\n", " | "))
    return len(faults)


def compositions(count: int, seed: int, show: int, compiled: bool = False) -> int:
    """Random scenes, ten steps each."""
    import hypothesis
    import tomli_w
    from hypothesis import HealthCheck, Phase, given, settings
    from judge_scenes import judge
    from random_scenes import scenes

    if not compiled:
        os.environ["NUMBA_DISABLE_JIT"] = "1"
    tally, templates, used = collections.Counter(), collections.Counter(), collections.Counter()
    shown, faults, worst = {}, {}, {}
    number = 0

    @hypothesis.seed(seed)
    @settings(max_examples=count, phases=[Phase.generate], database=None, deadline=None, suppress_health_check=list(HealthCheck))
    @given(scenes())
    def one(drawn):
        nonlocal number
        number += 1
        mild, scene = drawn
        outcome = judge(mild, scene)
        tally[("mild" if mild else "extreme"), outcome.kind] += 1
        key = re.sub(r"[-\d.e+]+|'[^']*'", "#", outcome.text)[:90]
        if outcome.kind == "runs":
            used.update(set(re.findall(r"'kind': '(\w+)'", str(scene))))
            name = "mild" if mild else "extreme", scene.get("precision", "float64")
            worst[name] = tuple(map(max, worst.get(name, (0.0, -1.0)), (outcome.momentum, outcome.balance)))
        elif outcome.kind == "fault" and key not in faults:
            faults[key] = outcome.text
            kept = Path(tempfile.gettempdir()) / f"scene-{seed}-{number}.toml"
            kept.write_text(tomli_w.dumps(scene))
            print(f"FAULT {number} [{'mild' if mild else 'extreme'}] {outcome.text[:700]}\n   kept as {kept}", flush=True)
        elif outcome.kind != "fault":
            templates[outcome.kind, key] += 1
            shown.setdefault((outcome.kind, key), outcome.text)

    began = time.perf_counter()
    try:
        one()
    except KeyboardInterrupt:
        print("interrupted")
    print(f"{number} scenes in {time.perf_counter() - began:.0f} s: {dict(tally)}, {len(faults)} kinds of fault")
    print("largest momentum error and energy made:", {" ".join(k): tuple(f"{x:.2g}" for x in v) for k, v in worst.items()})
    print("ran:", dict(sorted(used.items())))
    for key, n in templates.most_common(show):
        print(f"  {n} x [{key[0]}]", shown[key][:300].replace("\n", " | "))
    return len(faults)


def kills(count: int, seed: int, show: int) -> int:
    """Runs killed at random moments of their writing, some of them again after they were resumed."""
    from killed_run import acknowledged, check_end, check_left, child, events

    rng, faults, killed = random.Random(seed), 0, collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        whole = {c: Path(folder) / f"whole{c}.vtkhdf" for c in (False, True)}
        last = {c: events(child("start", path, 0, c).stdout) for c, path in whole.items()}
        for number in range(count):
            compress = rng.random() < 0.3
            path = Path(folder) / f"run{number}.vtkhdf"
            what, event, frames, rows = "start", rng.randint(1, last[compress]), [], []
            for again in range(4):
                done = child(what, path, event, compress)
                killed[again, done.returncode] += 1
                new_frames, new_rows = acknowledged(done.stdout)
                frames, rows = (new_frames, new_rows) if again == 0 else (frames, rows)
                wrong = check_left(path, whole[compress], frames, rows)
                if done.returncode not in (0, -9):
                    wrong = f"exit {done.returncode}: {done.stderr[-600:]}"
                checkpoint = path.with_suffix(".ckpt.h5")
                if not wrong and done.returncode == 0:
                    wrong = check_end(path, whole[compress])
                if not wrong and not checkpoint.exists() and len(frames) > 3:
                    wrong = "frames but no checkpoint"
                if wrong:
                    faults += 1
                    print(f"FAULT {number}.{again} [{what} to event {event} of {last[compress]}] {wrong}", flush=True)
                if wrong or done.returncode == 0 or not checkpoint.exists():
                    break
                what, event = "resume", 0 if again == 2 or rng.random() < 0.6 else rng.randint(1, last[compress] // 2)
                frames, rows = [], []  # a resumed run may first cut back what is later than its checkpoint
            for file in Path(folder).glob(f"*run{number}.*"):
                file.unlink()
    print(f"{count} runs, {sum(n for (_, code), n in killed.items() if code == -9)} kills, {dict(killed)}, {faults} faults")
    return faults


def damage(count: int, seed: int, show: int) -> int:
    """Result files and checkpoints with flipped bits, missing ends and holes, read by a process of its own."""
    import multiprocessing

    from damaged_files import DAMAGES
    from killed_run import child

    os.environ["NUMBA_DISABLE_JIT"] = "1"
    faults, tally, messages = 0, collections.Counter(), collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        for compress in (False, True):
            child("start", Path(folder) / f"good{int(compress)}.vtkhdf", 0, compress)
        rng = random.Random(seed)
        jobs = []
        for number in range(count):
            kind, read = rng.choice((("vtkhdf", "contents"), ("vtkhdf", "continued"), ("ckpt.h5", "state"), ("history.csv", "rows")))
            good = Path(folder) / f"good{rng.randrange(2)}.{kind}"
            change = rng.choice(DAMAGES)
            bad = Path(folder) / f"bad{number}.{kind}"
            raw = good.read_bytes()
            bad.write_bytes(change(raw, random.Random(f"{seed}/{number}")))
            jobs.append((number, change.__name__, read, str(good), str(bad)))
        at = 0
        while at < len(jobs):  # a child that crashes is a fault of the file it was reading
            ours, theirs = multiprocessing.Pipe()
            process = multiprocessing.get_context("fork").Process(target=_read_damaged, args=(jobs[at:], theirs))
            process.start()
            theirs.close()
            while True:
                if not ours.poll(30.0):
                    outcome = ("fault", "takes longer than 30 s")
                    process.kill()
                else:
                    try:
                        outcome = ours.recv()
                    except EOFError:
                        process.join()
                        if process.exitcode == 0:
                            break
                        outcome = ("fault", f"the interpreter died with {process.exitcode}")
                number, how, kind, _, bad = jobs[at]
                tally[kind, how, outcome[0]] += 1
                messages[re.sub(r"[\d.]+|/\S+", "#", outcome[1])[:100]] += 1
                if outcome[0] == "fault":
                    faults += 1
                    kept = Path(tempfile.gettempdir()) / f"damage-{seed}-{number}.{Path(bad).name.split('.', 1)[1]}"
                    kept.write_bytes(Path(bad).read_bytes())
                    print(f"FAULT {number} [{how}] {outcome[1][:300]}\n   kept as {kept}", flush=True)
                at += 1
                if at == len(jobs) or not process.is_alive():
                    break
            process.join(5.0)
    kinds = collections.Counter()
    for (kind, _, outcome), n in tally.items():
        kinds[kind, outcome] += n
    print(f"{count} files: {dict(kinds)}, {faults} faults")
    for text, n in messages.most_common(show):
        print(f"  {n} x {text}")
    return faults


def _read_damaged(jobs, pipe) -> None:
    import resource

    import damaged_files

    resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
    good = {}
    for _, _, kind, path, bad in jobs:
        read = getattr(damaged_files, kind)
        if (kind, path) not in good:
            good[kind, path] = read(Path(path))
        pipe.send(damaged_files.judge(read, Path(bad), good[kind, path]))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("files", "compositions", "kills", "damage"))
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--show", type=int, default=0, help="messages of refusals to print")
    parser.add_argument("--compiled", action="store_true", help="compositions compiled, not as plain Python")
    given = parser.parse_args()
    more = {"compiled": True} if given.compiled else {}
    return 1 if globals()[given.what](given.count, given.seed, given.show, **more) else 0


if __name__ == "__main__":
    sys.exit(main())
