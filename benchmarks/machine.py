"""What the machine can do at most: memory bandwidth by a triad, floating-point operations by chains of fused multiply-adds."""

from __future__ import annotations

import ctypes
import time
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np

CHAINS = 12
"""Independent chains: enough to hide the latency of two units with four to five cycles each."""


def bandwidth(threads: int, megabytes: int = 400, rounds: int = 7) -> float:
    """Best rate of a = b + s c with arrays far larger than the caches [byte/s]; three numbers moved per element."""
    triad = _triad()
    n = megabytes * 1_000_000 // 24
    a, b, c = np.zeros(n), np.ones(n), np.full(n, 2.0)
    cuts = [n * k // threads for k in range(threads + 1)]

    def work(k: int) -> None:
        triad(a[cuts[k] : cuts[k + 1]], b[cuts[k] : cuts[k + 1]], c[cuts[k] : cuts[k + 1]], 3.0)

    return 24.0 * n / _best(work, threads, rounds)


def peak(threads: int, bits: int = 64, millions: int = 40, rounds: int = 5) -> float:
    """Best rate of fused multiply-adds on full vectors of registers [flop/s], two for each."""
    lanes, function = _multiply_add(bits)
    count = millions * 1_000_000 // CHAINS
    # ctypes lets go of Python's lock during the call, so that threads run beside each other
    return 2.0 * lanes * CHAINS * count * threads / _best(lambda k: function(count), threads, rounds)


def _best(work: Any, threads: int, rounds: int) -> float:
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(work, range(threads)))
        times = []
        for _ in range(rounds):
            begin = time.perf_counter()
            list(pool.map(work, range(threads)))
            times.append(time.perf_counter() - begin)
    return min(times)


@cache
def _triad() -> Any:
    import numba

    @numba.njit(nogil=True, fastmath=True)
    def triad(a, b, c, s):
        for i in range(a.size):
            a[i] = b[i] + s * c[i]

    return triad


@cache
def _multiply_add(bits: int) -> tuple[int, Any]:
    """Lanes of the widest vectors of this processor, and a compiled loop of `CHAINS` fused multiply-adds on them."""
    from numba.core.codegen import get_host_cpu_features

    features = get_host_cpu_features()
    width = 512 if "+avx512f" in features else 256 if "+avx2" in features else 128
    lanes, word = width // bits, "double" if bits == 64 else "float"
    vector, name = f"<{lanes} x {word}>", f"@llvm.fma.v{lanes}f{bits}"
    one = f"<{', '.join([f'{word} 0.5'] * lanes)}>"
    lines = [
        f"declare {vector} {name}({vector}, {vector}, {vector})",
        f"define {word} @run(i64 %count) {{",
        "start:",
        "  br label %loop",
        "loop:",
    ]
    lines.append("  %i = phi i64 [0, %start], [%next, %loop]")
    lines += [f"  %a{k} = phi {vector} [{one}, %start], [%b{k}, %loop]" for k in range(CHAINS)]
    lines += [f"  %b{k} = call {vector} {name}({vector} %a{k}, {vector} {one}, {vector} {one})" for k in range(CHAINS)]
    lines += ["  %next = add i64 %i, 1", "  %more = icmp slt i64 %next, %count", "  br i1 %more, label %loop, label %end", "end:"]
    lines += [f"  %s{k} = fadd {vector} %b{k}, {f'%s{k - 1}' if k else '%b0'}" for k in range(CHAINS)]
    lines += [f"  %r = extractelement {vector} %s{CHAINS - 1}, i32 0", f"  ret {word} %r", "}"]
    return lanes, native("\n".join(lines), "run", ctypes.c_double if bits == 64 else ctypes.c_float, ctypes.c_int64)


_ENGINES: list[Any] = []


def native(text: str, name: str, result: Any, *arguments: Any) -> Any:
    """A function written in LLVM's language, compiled for this processor, callable through ctypes."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    llvm.initialize_native_asmparser()
    target = llvm.Target.from_default_triple()
    machine = target.create_target_machine(cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=2)
    module = llvm.parse_assembly(text)
    module.verify()
    engine = llvm.create_mcjit_compiler(module, machine)
    engine.finalize_object()
    _ENGINES.append(engine)  # its code lives as long as it does
    return ctypes.CFUNCTYPE(result, *arguments)(engine.get_function_address(name))
