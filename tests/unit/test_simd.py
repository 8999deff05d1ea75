"""Compiled vectors against their stand-ins: equal wherever nothing is rounded, else to rounding."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from mpmkit._core.composing import jit, simd, simd_numpy

needs_numba = pytest.mark.skipif(not jit.enabled(), reason="NUMBA_DISABLE_JIT=1")
PRECISIONS = [np.float32, np.float64]


def build(function):
    import numba

    return numba.njit(**jit.FLAGS)(function)


def both(make, *arguments):
    """What a function of arrays does to copies of its arguments, compiled and in plain Python."""
    from mpmkit._core.composing import simd_numba

    results = []
    for function in (build(make(simd_numba)), make(simd_numpy)):
        copies = [a.copy() if isinstance(a, np.ndarray) else a for a in arguments]
        function(*copies)
        results.append([a for a in copies if isinstance(a, np.ndarray)])
    return results


def moves(n, c):
    """Every function that only moves lanes, at n lanes in groups of c."""

    def make(V):
        def run(a, i, out):
            v = V.load(a, i, n)
            V.prefetch(a, i + 1000)
            V.store(out, 0, v)
            V.store(out, n, V.tiled(V.load(a, i + c, c), n))
            V.store(out, 2 * n, V.spread((a[0], a[1], a[2]), c, n))
            V.store(out, 3 * n, V.mixed(v, V.splat(a[i], n), 0b1010010110011))
            V.store(out, 4 * n, -v)
            w = v
            w += 1.0
            V.store(out, 5 * n, v)  # += made a new value
            V.store(out, 6 * n, V.summed(v, n))

        return run

    return make


@needs_numba
@pytest.mark.parametrize("dtype", PRECISIONS)
@pytest.mark.parametrize(("n", "c"), [(8, 2), (16, 4), (32, 4)])
def test_moves_are_equal(dtype, n, c):
    a = np.random.default_rng(n).standard_normal(64).astype(dtype)
    compiled, plain = both(moves(n, c), a, np.uint32(3), np.full(7 * n, 9, dtype))
    assert np.array_equal(compiled[1], plain[1])
    assert np.array_equal(plain[1][:n], a[3 : 3 + n])
    assert np.array_equal(plain[1][2 * n : 3 * n], np.concatenate([np.repeat(a[:3], c), np.zeros(max(n - 3 * c, 0))])[:n])


def arithmetic(V):
    def run(a, out):
        v, w = V.load(a, 0, 16), V.load(a, 16, 16)
        s = a[5]
        u = v * w + v
        u += s * w - 2 * v
        u -= v / w
        u *= 0.1
        u /= 3
        V.store(out, 0, u)
        V.store(out, 16, 1.0 - v * 0.3 + (2 - v) / (1.5 + w * w))
        V.store(out, 32, V.summed(u, 4))
        V.store(out, 36, V.summed(u, 1))

    return run


@needs_numba
@pytest.mark.parametrize("dtype", PRECISIONS)
def test_arithmetic_is_equal_to_rounding(dtype):
    # rounding: a dozen operations on numbers below 20 in size, the sums over sixteen of them
    a = np.random.default_rng(1).uniform(0.5, 2.0, 32).astype(dtype)
    compiled, plain = both(arithmetic, a, np.zeros(37, dtype))
    assert compiled[1].dtype == plain[1].dtype == dtype
    assert np.abs(compiled[1] - plain[1]).max() < 16 * 20 * np.finfo(dtype).eps


@needs_numba
@pytest.mark.parametrize("dtype", PRECISIONS)
def test_transpose_is_equal(dtype):
    def make(V):
        def run(src, dst, s, step, d, stride):
            V.transpose(src, s, step, dst, d, stride)

        return run

    src = np.arange(200, dtype=dtype)
    compiled, plain = both(make, src, np.zeros(120, dtype), 5, 16, np.uint64(3), np.int32(9))
    assert np.array_equal(compiled[1], plain[1])
    for i in range(8):
        assert np.array_equal(plain[1][3 + i :: 9][:8], src[5 + 16 * i :][:8])
    assert np.count_nonzero(plain[1]) == 64  # nothing else is written


def fused(V):
    def run(a, out, count):
        u, v = V.load(out, 0, 8), V.load(out, 8, 8)
        for k in range(count):
            x = V.load(a, 8 * k, 8)
            u = u + x * v
        V.store(out, 0, u)

    return run


@needs_numba
@pytest.mark.parametrize(("dtype", "letter"), [(np.float32, "s"), (np.float64, "d")])
def test_compiled_code_is_packed(dtype, letter):
    import llvmlite.binding
    from numba import types

    from mpmkit._core.composing import simd_numba

    features = llvmlite.binding.get_host_cpu_features()
    if not features.get("fma"):
        pytest.skip("this processor has no fused multiply-add")
    flat = types.Array(types.float32 if letter == "s" else types.float64, 1, "C")
    f = build(fused(simd_numba))
    f.compile((flat, flat, types.intp))
    [text] = f.inspect_asm().values()
    assert re.search(rf"vfmadd\d+p{letter}\s", text)
    assert not re.search(rf"v(add|mul|fn?madd\d+)s{letter}\s", text)

    g = build(lambda src, dst, s, d, stride: simd_numba.transpose(src, s, 16, dst, d, stride))
    g.compile((flat, flat, types.intp, types.intp, types.intp))
    [text] = g.inspect_asm().values()
    assert not re.search(rf"mov(s{letter}|[dlh]+p[sd])\s", text), "the transpose moves single numbers"
    assert re.search(r"v(unpck|perm|shuf|insert)", text)


def test_a_generated_module_loads_from_the_disk_cache(tmp_path):
    folder = tmp_path / "digest"
    folder.mkdir()
    (folder / "step.py").write_text(
        "from mpmkit._core.composing.jit import compiled\n"
        "from mpmkit._core.composing.simd import functions\n\nglobals().update(functions())\n\n"
        "@compiled\ndef twice(v):\n    return v + v\n\n"
        "@compiled\ndef run(a, out):\n    store(out, 0, summed(twice(load(a, 0, 8)) * splat(a[0], 8), 4))\n"
    )
    script = (
        "import numpy as np, step\nfrom mpmkit._core.composing.jit import enabled\n"
        "a = np.arange(1.0, 9.0, dtype=np.float32); out = np.zeros(4, np.float32); step.run(a, out)\n"
        "print(out.tolist(), sum(step.run.stats.cache_hits.values()) if enabled() else 0)"
    )
    environment = os.environ | {"MPMKIT_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", script]  # finds modules in the folder it runs in
    runs = [subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True) for _ in range(2)]
    hits = ["0", "1"] if jit.enabled() else ["0", "0"]
    assert [r.stdout.split() for r in runs] == [["[12.0,", "16.0,", "20.0,", "24.0]", h] for h in hits], runs[0].stderr + runs[1].stderr


@needs_numba
@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda V: lambda a, i: V.load(a, 0, i), "literal integer"),
        (lambda V: lambda a, i: V.load(a, 0, 3), "lanes of float32 or float64"),
        (lambda V: lambda a, i: V.load(a[::2], 0, 4), "flat contiguous"),
        (lambda V: lambda a, i: V.store(a, 0, V.splat(np.float32(1.0), 4)), "does not go into"),
        (lambda V: lambda a, i: V.spread((a[0], i), 2, 4), "one type"),
        (lambda V: lambda a, i: V.load(a, 0, 4) + V.load(a, 0, 8), "No implementation"),
    ],
)
def test_misuse_does_not_compile(make, message):
    from numba.core.errors import TypingError

    from mpmkit._core.composing import simd_numba

    with pytest.raises(TypingError, match=message):
        build(make(simd_numba))(np.zeros(40), 1)


def test_stand_ins_check_bounds_and_types():
    a = np.zeros(10)
    with pytest.raises(IndexError, match="lanes 8 to 12 of an array of 10"):
        simd_numpy.load(a, 8, 4)
    with pytest.raises(IndexError):
        simd_numpy.store(a, -1, simd_numpy.splat(1.0, 4))
    with pytest.raises(TypeError, match="do not go into"):
        simd_numpy.store(a, 0, simd_numpy.splat(np.float32(1.0), 4))
    with pytest.raises(TypeError, match="do not mix"):
        simd_numpy.load(a, 0, 4) + simd_numpy.load(a, 0, 8)
    assert (np.float64(2.0) * simd_numpy.splat(np.float32(0.1), 2)).lanes.dtype == np.float32


def test_the_chosen_functions_have_all_names():
    assert all(callable(getattr(simd_numpy, name)) for name in simd.NAMES)
