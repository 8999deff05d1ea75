"""log, exp and pow of compiled components: accuracy, special values, precision, and that loops over lanes stay packed."""

import math
import re

import numpy as np
import pytest

import mpmkit.math
from mpmkit._core.composing import jit

pytestmark = pytest.mark.skipif(not jit.enabled(), reason="NUMBA_DISABLE_JIT=1")
PRECISIONS = [np.float32, np.float64]


def law(x, y):
    return mpmkit.math.log(x), math.exp(y), mpmkit.math.pow(x, y)


@pytest.fixture(scope="module", params=PRECISIONS, ids=lambda t: t.__name__)
def compiled(request):
    """A loop over particles that calls log, exp and pow as a component does, and its precision."""
    import numba

    functions = jit.Linker(request.param)(law)

    @numba.njit(**jit.FLAGS)
    def loop(x, y, out):
        for i in range(x.size):
            out[0, i], out[1, i], out[2, i] = functions(x[i], y[i])

    return request.param, loop


def call(compiled, x, y):
    dtype, loop = compiled
    x, y = (np.ascontiguousarray(np.broadcast_to(np.asarray(a, dtype), np.broadcast(x, y).shape)) for a in (x, y))
    out = np.zeros((3, x.size), dtype)
    loop(x, y, out)
    return x, y, out


def ulps(got, wanted):
    """Largest error in units of the last digit of the exact result."""
    return np.max(np.abs(got - wanted) / np.spacing(np.abs(wanted).astype(got.dtype)))


def test_accuracy(compiled):
    """Rounding, in units of the last digit: the figures that the functions promise."""
    dtype = compiled[0]
    rng, limits, n = np.random.default_rng(3), np.finfo(compiled[0]), 100_000
    lowest, largest = 0.998 * math.log(limits.tiny), 0.998 * math.log(limits.max)
    for x, y in [
        (np.exp2(rng.uniform(limits.minexp, limits.maxexp - 0.01, n)), rng.uniform(lowest, largest, n)),
        (rng.uniform(0.1, 10.0, n), rng.uniform(-3.0, 3.0, n)),
        (rng.uniform(0.5, 2.0, n), rng.uniform(-10.0, 10.0, n)),
        (1.0 + rng.uniform(-1e-3, 1e-3, n), rng.uniform(-1e-3, 1e-3, n)),
    ]:
        x, y, (log, exp, power) = call(compiled, x, y)
        x, y = x.astype(np.longdouble), y.astype(np.longdouble)
        assert log.dtype == dtype
        assert ulps(log, np.log(x)) < 1.0
        assert ulps(exp, np.exp(y)) < 1.2
        if np.max(x) <= 10.0:
            assert ulps(power, np.power(x, y)) < 2.0


def test_special_values(compiled):
    """Those of the C library; numbers below the normal range count as zero."""
    tiny = np.finfo(compiled[0]).tiny
    _, _, (log, exp, _) = call(compiled, [0.0, -1.0, np.inf, np.nan, 1.0, 0.25 * tiny], [np.inf, -np.inf, np.nan, 0.0, 2000.0, -2000.0])
    assert np.array_equal(log, [-np.inf, np.nan, np.inf, np.nan, 0.0, -np.inf], equal_nan=True)
    assert np.array_equal(exp, [np.inf, 0.0, np.nan, 1.0, np.inf, 0.0], equal_nan=True)
    bases, exponents = np.meshgrid([0.0, -2.0, -0.5, 2.0, 1.0, np.inf, np.nan], [0.0, 1.0, 2.0, 3.0, -1.0, -2.0, 0.5, 1e10, -1e10])
    x, y, (_, _, power) = call(compiled, bases.ravel(), exponents.ravel())
    with np.errstate(all="ignore"):
        wanted = np.power(x, y)
    # rounding: pow of small integers and halves
    np.testing.assert_allclose(power, wanted, rtol=2 * np.finfo(x.dtype).eps, atol=0.0)


def test_loop_is_packed_and_in_its_precision(compiled):
    dtype, loop = compiled
    call(compiled, 1.0 + np.zeros(4), np.zeros(4))
    [text] = loop.inspect_asm().values()
    letter, other = ("s", "d") if dtype is np.float32 else ("d", "s")
    assert len(re.findall(rf"mulp{letter}|fn?m(?:add|sub)\d+p{letter}", text)) > 40
    assert not re.findall(rf"(?:add|mul|sub|div|fn?m(?:add|sub)\d+)[sp]{other}\s", text)


def test_functions_held_in_a_closure_are_replaced_too():
    def made(f):
        def law(x):
            return f(x)

        return law

    compiled = jit.Linker(np.float64)(made(math.log))
    assert compiled(0.25 * np.finfo(float).tiny) == -np.inf


def test_plain_python_keeps_the_library():
    assert mpmkit.math.log is math.log


def test_an_edit_changes_the_digest_of_a_step():
    texts = "".join(jit.sources())
    assert "def exp_parts" in texts and "def series" in texts and "def transpose" in texts
