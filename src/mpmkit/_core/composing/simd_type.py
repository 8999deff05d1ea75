"""The type of the vectors of `simd` in compiled code, one LLVM vector each, and its operators."""

# mypy: disable-error-code="no-untyped-call"

from __future__ import annotations

import operator
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import models, register_model

# those of jit.FLAGS that concern + - * /; as there no "nnan" and "ninf", so that the guards see a NaN
FLAGS = ("contract", "reassoc", "nsz", "arcp")
LANES = (1, 2, 4, 8, 16, 32)
INT32 = ir.IntType(32)


class Vector(types.Type):
    """A fixed number of lanes of float32 or float64."""

    def __init__(self, dtype: Any, n: int) -> None:
        if dtype not in (types.float32, types.float64) or n not in LANES:
            raise TypingError(f"a vector has {LANES} lanes of float32 or float64, not {n} of {dtype}")
        self.dtype, self.n = dtype, n
        super().__init__(name=f"Vector({dtype}, {n})")


@register_model(Vector)
class VectorModel(models.PrimitiveModel):
    """In registers and in memory an LLVM vector."""

    def __init__(self, manager: Any, fe_type: Vector) -> None:
        lane = manager.lookup(fe_type.dtype).get_value_type()
        super().__init__(manager, fe_type, ir.VectorType(lane, fe_type.n))


def shuffle(builder: Any, a: Any, b: Any, lanes: Any) -> Any:
    """Lanes chosen from a and b, counted through."""
    lanes = list(lanes)
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(INT32, len(lanes)), lanes))


def broadcast(builder: Any, scalar: Any, n: int) -> Any:
    one = ir.VectorType(scalar.type, n)
    first = builder.insert_element(ir.Constant(one, ir.Undefined), scalar, INT32(0))
    return shuffle(builder, first, ir.Constant(one, ir.Undefined), [0] * n)


def _operator(symbols: tuple[Any, ...], instruction: str) -> None:
    """Teach numba one operator, between vectors of one type and between a vector and a scalar."""

    class Typing(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            vector = next((a for a in args if isinstance(a, Vector)), None)
            if len(args) == 2 and vector and all(a == vector or isinstance(a, (types.Float, types.Integer)) for a in args):
                return signature(vector, *args)
            return None

    def lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        vector = sig.return_type
        operands = []
        for value, kind in zip(args, sig.args, strict=True):
            if not isinstance(kind, Vector):
                value = broadcast(builder, context.cast(builder, value, kind, vector.dtype), vector.n)
            operands.append(value)
        return getattr(builder, instruction)(*operands, flags=FLAGS)

    for symbol in symbols:
        infer_global(symbol)(Typing)
        for scalar in (types.Float, types.Integer):
            lower_builtin(symbol, Vector, scalar)(lower)
            lower_builtin(symbol, scalar, Vector)(lower)
        lower_builtin(symbol, Vector, Vector)(lower)


_operator((operator.add, operator.iadd), "fadd")
_operator((operator.sub, operator.isub), "fsub")
_operator((operator.mul, operator.imul), "fmul")
_operator((operator.truediv, operator.itruediv), "fdiv")


@infer_global(operator.neg)
class _Minus(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        return signature(args[0], args[0]) if isinstance(args[0], Vector) else None


def _minus(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fneg(args[0])


lower_builtin(operator.neg, Vector)(_minus)
