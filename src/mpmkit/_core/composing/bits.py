"""Bits of floating-point numbers in compiled code, the same source for float32 and float64, without branches.

Numba computes with 64-bit integers whatever their type, and an accidental 64-bit step halves the speed of float32 loops; so these few
operations are written for LLVM directly. All are on scalars, and LLVM turns them into packed ones in a loop over lanes.
"""

# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

import struct
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.errors import TypingError
from numba.extending import intrinsic

# sums of products may be fused; nothing else, since the functions made of these rely on the order of their operations
FLAGS = ("contract", "nsz")


class _Format:
    """Widths of a floating-point format: its integer type, bits of the mantissa, bias of the exponent."""

    def __init__(self, kind: Any) -> None:
        if kind not in (types.float32, types.float64):
            raise TypingError(f"a number must be float32 or float64, not {kind}")
        single = kind == types.float32
        self.integer = ir.IntType(32 if single else 64)
        self.mantissa, self.bias = (23, 127) if single else (52, 1023)
        self._pack = ("<f", "<i") if single else ("<d", "<q")

    def bits(self, value: float) -> Any:
        """Constant with the bits of a number."""
        return self.integer(struct.unpack(self._pack[1], struct.pack(self._pack[0], value))[0])


@intrinsic
def split(typing_context, x):  # type: ignore[no-untyped-def]
    """k and f with x = 2^k (1 + f), sqrt(1/2) <= 1 + f < sqrt(2), for positive normal x."""
    form = _Format(x)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        lowest = form.bits(0.5**0.5)
        # so shifted that the exponent field changes where 1 + f starts again from sqrt(1/2)
        u = builder.add(builder.sub(builder.bitcast(args[0], form.integer), lowest), form.bits(1.0))
        biased = builder.lshr(u, form.integer(form.mantissa))
        fraction = builder.add(builder.and_(u, form.integer((1 << form.mantissa) - 1)), lowest)
        # an integer below 2^mantissa in the mantissa of 2^mantissa: a conversion that every processor has packed
        magic = 2.0**form.mantissa
        k = builder.fsub(builder.bitcast(builder.or_(biased, form.bits(magic)), args[0].type), args[0].type(magic + form.bias))
        f = builder.fsub(builder.bitcast(fraction, args[0].type), args[0].type(1.0))
        return context.make_tuple(builder, sig.return_type, [k, f])

    return types.UniTuple(x, 2)(x), lower


@intrinsic
def rounded(typing_context, x):  # type: ignore[no-untyped-def]
    """x + 1.5 * 2^mantissa, which holds x rounded to an integer in its lowest bits, and that integer as a number."""
    form = _Format(x)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        magic = args[0].type(1.5 * 2.0**form.mantissa)
        held = builder.fadd(args[0], magic, flags=FLAGS)
        return context.make_tuple(builder, sig.return_type, [held, builder.fsub(held, magic)])

    return types.UniTuple(x, 2)(x), lower


@intrinsic
def scaled(typing_context, x, held):  # type: ignore[no-untyped-def]
    """x 2^k for the k that `rounded` holds, if both x and the result are normal numbers."""
    form = _Format(x)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        power = builder.shl(builder.bitcast(args[1], form.integer), form.integer(form.mantissa))
        return builder.bitcast(builder.add(builder.bitcast(args[0], form.integer), power), args[0].type)

    return x(x, x), lower


@intrinsic
def head(typing_context, x):  # type: ignore[no-untyped-def]
    """x cut to half of its digits, so that a product of two heads is exact."""
    form = _Format(x)

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kept = form.integer(-1 << (form.mantissa // 2 + 1))
        return builder.bitcast(builder.and_(builder.bitcast(args[0], form.integer), kept), args[0].type)

    return x(x), lower


@intrinsic
def like(typing_context, x, single, double):  # type: ignore[no-untyped-def]
    """`single` or `double`, by the precision of x and in it."""
    _Format(x)
    k = 1 if x == types.float32 else 2

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return context.cast(builder, args[k], sig.args[k], x)

    return x(x, single, double), lower


@intrinsic
def series(typing_context, x, single, double):  # type: ignore[no-untyped-def]
    """c_0 + c_1 x + c_2 x^2 + ... with the coefficients `single` or `double`, by the precision of x and in it."""
    _Format(x)
    k = 1 if x == types.float32 else 2

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = sig.args[k]
        terms = [context.cast(builder, builder.extract_value(args[k], i), kind[i], x) for i in range(len(kind))]
        value = terms.pop()
        while terms:
            value = builder.fadd(builder.fmul(value, args[0], flags=FLAGS), terms.pop(), flags=FLAGS)
        return value

    return x(x, single, double), lower
