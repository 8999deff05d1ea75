"""Vectors of a fixed number of lanes: the one place with low-level SIMD.

The loops over nodes of the generated step work on short vectors that must stay in registers; numba vectorises plain loops, but not
these. The functions here make such vectors explicit. Compiled, they come from `simd_numba` (one LLVM vector each); with
NUMBA_DISABLE_JIT=1 from `simd_numpy`, so that the very same generated text runs as plain Python.

`a`, `src`, `dst` are flat contiguous arrays of float32 or float64, `i`, `k`, `step`, `d`, `stride` integers of any type (negative ones have
no meaning), `n`, `c`, `first`, `mask` literal integers. Numbers of lanes are powers of two from 1 to 32.

===========================================  =============================================================================================
``load(a, i, n)``                            the vector a[i : i + n]
``store(a, i, v)``                           a[i : i + n] = v
``splat(s, n)``                              n lanes of the scalar s, in its precision
``tiled(v, n)``                              n lanes, lane i = v[i % lanes of v]
``spread(s, c, n)``                          n lanes from the tuple s of scalars: lane i = s[i // c], zero where s has no such element
``mixed(a, b, mask)``                        lane i = b[i] where bit i of mask is set, else a[i]
``summed(v, c)``                             c lanes, lane i = v[i] + v[i + c] + v[i + 2 c] + ...
``transpose(src, k, step, dst, d, stride)``  dst[d + stride j + i] = src[k + step i + j] for i, j in 0..7
``wide()``                                   a hint for the loops of the function it stands in: the widest vectors of the machine
``tiny_to_zero()``                           on x86, numbers below the normal range count as zero from here on; returns what was before
``as_before(mode)``                          what was before ``mode = tiny_to_zero()``
``prefetch(a, i)``                           a hint that a[i] is read soon; no effect on results, i may lie outside of a
===========================================  =============================================================================================

Vectors of one type have ``+ - * /``, unary minus and ``+= -= *= /=``; the other operand may be a scalar, which is cast to the type of
the lanes. Sums of products may be fused (one rounding) and sums reordered when compiled.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from mpmkit._core.composing.jit import enabled

NAMES = (
    "load",
    "store",
    "splat",
    "tiled",
    "spread",
    "mixed",
    "summed",
    "transpose",
    "prefetch",
    "wide",
    "tiny_to_zero",
    "as_before",
)


def functions() -> dict[str, Any]:
    """The functions by name, as the generated module gets them."""
    chosen = import_module(f"mpmkit._core.composing.simd_{'numba' if enabled() else 'numpy'}")
    return {name: getattr(chosen, name) for name in NAMES}
