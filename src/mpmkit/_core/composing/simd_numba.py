"""The functions of `simd` in compiled code: intrinsics on the vectors of `simd_type`."""

# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.errors import TypingError
from numba.extending import intrinsic

from mpmkit._core.composing.simd_type import FLAGS, INT32, Vector, broadcast, shuffle


def _literal(kind: Any, what: str) -> int:
    if not isinstance(kind, types.IntegerLiteral):
        raise TypingError(f"{what} must be a literal integer, not {kind}")
    return kind.literal_value


def _expect(kind: Any, wanted: type, what: str) -> None:
    flat = not isinstance(kind, types.Array) or (kind.ndim == 1 and kind.layout == "C")
    if not isinstance(kind, wanted) or not flat:
        raise TypingError(f"{what}, not {kind}")


def _index(context: Any, builder: Any, sig: Any, args: Any, k: int) -> Any:
    """Argument k as a signed machine integer."""
    return context.cast(builder, args[k], sig.args[k], types.intp)


def _pointer(context: Any, builder: Any, kind: Any, array: Any, index: Any, target: Any) -> Any:
    """Address of array[index] as a pointer to `target`, without the wrap-around of negative indices."""
    data = context.make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), target.as_pointer())


def _read(context: Any, builder: Any, kind: Any, array: Any, index: Any, vector: Any) -> Any:
    value = builder.load(_pointer(context, builder, kind, array, index, context.get_value_type(vector)))
    value.align = kind.dtype.bitwidth // 8
    return value


def _write(context: Any, builder: Any, kind: Any, array: Any, index: Any, value: Any) -> None:
    store = builder.store(value, _pointer(context, builder, kind, array, index, value.type))
    store.align = kind.dtype.bitwidth // 8


@intrinsic(prefer_literal=True)
def load(typing_context, a, i, n):  # type: ignore[no-untyped-def]
    """The vector a[i : i + n]."""
    _expect(a, types.Array, "load reads a flat contiguous array")
    vector = Vector(a.dtype, _literal(n, "the number of lanes"))

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _read(context, builder, a, args[0], _index(context, builder, sig, args, 1), vector)

    return vector(a, i, n), lower


@intrinsic(prefer_literal=True)
def store(typing_context, a, i, v):  # type: ignore[no-untyped-def]
    """a[i : i + n] = v."""
    _expect(a, types.Array, "store writes a flat contiguous array")
    _expect(v, Vector, "store writes a vector")
    if a.dtype != v.dtype:
        raise TypingError(f"{v} does not go into {a}")

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        _write(context, builder, a, args[0], _index(context, builder, sig, args, 1), args[2])
        return context.get_dummy_value()

    return types.void(a, i, v), lower


@intrinsic(prefer_literal=True)
def splat(typing_context, s, n):  # type: ignore[no-untyped-def]
    """n lanes of a scalar."""
    vector = Vector(s, _literal(n, "the number of lanes"))

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return broadcast(builder, args[0], vector.n)

    return vector(s, n), lower


def _rearranged(result: Vector, arguments: tuple[Any, ...], lanes: Any) -> tuple[Any, Any]:
    """Signature and lowering of a fixed rearrangement of the lanes of the one or two leading vectors."""
    two = isinstance(arguments[1], Vector)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return shuffle(builder, args[0], args[1] if two else ir.Constant(args[0].type, ir.Undefined), lanes)

    return result(*arguments), lower


@intrinsic(prefer_literal=True)
def tiled(typing_context, v, n):  # type: ignore[no-untyped-def]
    """n lanes, v repeated."""
    _expect(v, Vector, "tiled repeats a vector")
    lanes = _literal(n, "the number of lanes")
    return _rearranged(Vector(v.dtype, lanes), (v, n), [i % v.n for i in range(lanes)])


@intrinsic(prefer_literal=True)
def mixed(typing_context, a, b, mask):  # type: ignore[no-untyped-def]
    """Lanes of b where a bit of the mask is set, else of a."""
    _expect(a, Vector, "mixed takes lanes of two vectors")
    if a != b:
        raise TypingError(f"mixed takes two vectors of one type, not {a} and {b}")
    bits = _literal(mask, "the mask")
    return _rearranged(a, (a, b, mask), [i + a.n * (bits >> i & 1) for i in range(a.n)])


@intrinsic(prefer_literal=True)
def spread(typing_context, s, c, n):  # type: ignore[no-untyped-def]
    """n lanes, each scalar of a tuple c times, then zeros."""
    _expect(s, types.UniTuple, "spread takes a tuple of scalars of one type")
    each = _literal(c, "the number of lanes of a scalar")
    vector = Vector(s.dtype, _literal(n, "the number of lanes"))

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = ir.Constant(context.get_value_type(vector), None)
        for k in range(min(len(s), vector.n // each)):
            # broadcasts and blends: the processor merges a broadcast from memory into some lanes at no cost
            scalar = broadcast(builder, builder.extract_value(args[0], k), vector.n)
            value = shuffle(builder, value, scalar, [i + vector.n * (i // each == k) for i in range(vector.n)])
        return value

    return vector(s, c, n), lower


@intrinsic(prefer_literal=True)
def summed(typing_context, v, c):  # type: ignore[no-untyped-def]
    """c lanes, the sum of the groups of c lanes, by adding halves."""
    _expect(v, Vector, "summed takes a vector")
    lanes = _literal(c, "the number of lanes")
    result = Vector(v.dtype, min(lanes, v.n))

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value, n = args[0], v.n
        while n > result.n:
            n //= 2
            low, high = shuffle(builder, value, value, range(n)), shuffle(builder, value, value, range(n, 2 * n))
            value = builder.fadd(low, high, flags=FLAGS)
        return value

    return result(v, c), lower


@intrinsic
def transpose(typing_context, src, s, step, dst, d, stride):  # type: ignore[no-untyped-def]
    """dst[d + stride j + i] = src[s + step i + j] for i, j in 0..7, in registers."""
    _expect(src, types.Array, "transpose reads a flat contiguous array")
    _expect(dst, types.Array, "transpose writes a flat contiguous array")
    if src.dtype != dst.dtype:
        raise TypingError(f"transpose from {src} to {dst}")
    vector = Vector(src.dtype, 8)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        begin, apart, target, between = (_index(context, builder, sig, args, k) for k in (1, 2, 4, 5))
        rows = [_read(context, builder, src, args[0], builder.add(begin, builder.mul(apart, begin.type(i))), vector) for i in range(8)]
        for bit in (4, 2, 1):  # exchange one bit of the number of the row with the same bit of the number of the lane
            for i in (i for i in range(8) if not i & bit):
                low = shuffle(builder, rows[i], rows[i | bit], [lane + 8 - bit if lane & bit else lane for lane in range(8)])
                high = shuffle(builder, rows[i], rows[i | bit], [lane + 8 if lane & bit else lane + bit for lane in range(8)])
                rows[i], rows[i | bit] = low, high
        for j in range(8):
            _write(context, builder, dst, args[3], builder.add(target, builder.mul(between, begin.type(j))), rows[j])
        return context.get_dummy_value()

    return types.void(src, s, step, dst, d, stride), lower


@intrinsic
def prefetch(typing_context, a, i):  # type: ignore[no-untyped-def]
    """Ask for the cache line of a[i], to be read and kept."""
    _expect(a, types.Array, "prefetch takes a flat contiguous array")

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        byte = ir.IntType(8)
        address = _pointer(context, builder, a, args[0], _index(context, builder, sig, args, 1), byte)
        kind = ir.FunctionType(ir.VoidType(), [byte.as_pointer(), INT32, INT32, INT32])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0")
        builder.call(function, [address, INT32(0), INT32(3), INT32(1)])  # read, keep in all levels, data
        return context.get_dummy_value()

    return types.void(a, i), lower


@intrinsic
def wide(typing_context):  # type: ignore[no-untyped-def]
    """Let LLVM use the widest vectors of the machine in the loops of this function, not only those that cost no clock speed."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        # an attribute of the function, for which llvmlite has no name
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), lower


@intrinsic
def tiny_to_zero(typing_context):  # type: ignore[no-untyped-def]
    """Let the processor take numbers below the normal range for zero, with which it is some hundred cycles faster; returns its mode."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if not _x86(builder):
            return INT32(0)
        mode = _mode(builder, None)
        _mode(builder, builder.or_(mode, INT32(0x8040)))  # flush to zero, denormals are zero
        return mode

    return types.int32(), lower


@intrinsic
def as_before(typing_context, mode):  # type: ignore[no-untyped-def]
    """Give the processor back the mode that `tiny_to_zero` returned."""

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if _x86(builder):
            _mode(builder, args[0])
        return context.get_dummy_value()

    return types.void(types.int32), lower


def _x86(builder: Any) -> bool:
    return str(builder.module.triple).startswith(("x86_64", "i686", "amd64"))


def _mode(builder: Any, new: Any) -> Any:
    """Read the control register of x86 vector units, or write it."""
    place = cgutils.alloca_once(builder, INT32)
    address = builder.bitcast(place, ir.IntType(8).as_pointer())
    kind = ir.FunctionType(ir.VoidType(), [ir.IntType(8).as_pointer()])
    if new is not None:
        builder.store(new, place)
    name = "llvm.x86.sse.stmxcsr" if new is None else "llvm.x86.sse.ldmxcsr"
    builder.call(cgutils.get_or_insert_function(builder.module, kind, name), [address])
    return builder.load(place)
