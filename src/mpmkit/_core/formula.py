"""The parser behind `mpmkit.Expression`: text to a small tree of allowed operations, and from there to numbers or Python text."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from functools import reduce
from typing import Any, NoReturn

import attrs
import numpy as np

from mpmkit.errors import ParameterError, did_you_mean

MAX_LENGTH = 1000
MAX_DEPTH = 60
MAX_NODES = 1000
MAX_POWER = 64  # whole exponents up to this stay multiplications

FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "tanh": np.tanh,
    "abs": np.abs,
}
_OPERATORS: dict[type, tuple[str, Callable[..., Any]]] = {
    ast.Add: ("+", np.add),
    ast.Sub: ("-", np.subtract),
    ast.Mult: ("*", np.multiply),
    ast.Div: ("/", np.true_divide),
}
_COMPARISONS: dict[type, tuple[str, Callable[..., Any]]] = {
    ast.Lt: ("<", np.less),
    ast.LtE: ("<=", np.less_equal),
    ast.Gt: (">", np.greater),
    ast.GtE: (">=", np.greater_equal),
    ast.Eq: ("==", np.equal),
    ast.NotEq: ("!=", np.not_equal),
}
_ADVICE: dict[type, str] = {
    ast.BitXor: "; write ** for powers",
    ast.FloorDiv: "; write / for division",
    ast.Attribute: "; only plain names are allowed",
    ast.Subscript: "; write x, y, z for the components",
    ast.Tuple: "; give a vector as a list of formulas",
    ast.List: "; give a vector as a list of formulas",
}


@attrs.frozen(eq=False)
class Formula:
    """A checked formula: `evaluate` for arrays, `code` for the text of a scalar Python expression."""

    names: tuple[str, ...]
    evaluate: Callable[[Mapping[str, Any]], Any]
    code: Callable[[Mapping[str, str]], str]


@attrs.frozen(eq=False)
class _Part:
    """One node: what it is ("number" or "condition"), its value for arrays, its text."""

    kind: str
    value: Callable[[Mapping[str, Any]], Any]
    text: Callable[[Mapping[str, str]], str]


def parse(text: str, names: tuple[str, ...], path: str) -> Formula:
    """Read a formula that may use `names`.

    Raises
    ------
    ParameterError
        Naming `path`, the position, and what would be allowed.
    """
    if not isinstance(text, str):
        raise ParameterError(f"{path} must be a formula in text, got {text!r}")
    if len(text) > MAX_LENGTH:
        raise ParameterError(
            f"{path}: the formula has {len(text)} characters, at most {MAX_LENGTH} are allowed; pass a Python function instead"
        )
    if not text.strip():
        raise ParameterError(f"{path}: the formula is empty; write a number or a formula of {', '.join(names)}")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        at = f" at character {error.offset}" if isinstance(error, SyntaxError) and error.offset else ""
        raise ParameterError(f"{path}: cannot read {shortened(text)!r} as a formula{at}: {getattr(error, 'msg', None) or error}") from None
    reader = _Reader(text.strip(), names, path)
    reader.check_extent(tree)
    whole = reader.number(tree)
    return Formula(tuple(sorted(reader.used)), whole.value, whole.text)


def shortened(text: str, length: int = 80) -> str:
    """Text cut to a length that fits a message."""
    return text if len(text) <= length else text[: length - 3] + "..."


class _Reader:
    """Walks the syntax tree; one method for each kind of node that is allowed, and no other kind passes."""

    def __init__(self, text: str, names: tuple[str, ...], path: str) -> None:
        self.text, self.names, self.path = text, names, path
        self.used: set[str] = set()

    def fail(self, node: ast.AST, problem: str) -> NoReturn:
        # Offsets count bytes of UTF-8; a formula that was accepted by the parser can be cut there.
        line = self.text.split("\n")[getattr(node, "lineno", 1) - 1].encode()
        at = len(line[: getattr(node, "col_offset", 0)].decode(errors="replace")) + 1
        raise ParameterError(f"{self.path}: {problem}, at character {at} of {shortened(self.text)!r}")

    def check_extent(self, tree: ast.AST) -> None:
        """Refuse huge or deeply nested formulas, with a stack of our own because theirs would overflow."""
        stack, count = [(tree, 1)], 0
        while stack:
            node, depth = stack.pop()
            count += 1
            if depth > MAX_DEPTH or count > MAX_NODES:
                self.fail(
                    tree,
                    f"the formula is nested deeper than {MAX_DEPTH} or has more than {MAX_NODES} parts; pass a Python function instead",
                )
            stack.extend((child, depth + 1) for child in ast.iter_child_nodes(node))

    def number(self, node: ast.AST) -> _Part:
        part = self.part(node)
        if part.kind != "number":
            self.fail(node, "a comparison is not a number; write for example (1 if t < 2 else 0)")
        return part

    def condition(self, node: ast.AST) -> _Part:
        part = self.part(node)
        if part.kind != "condition":
            self.fail(node, "a comparison such as t < 2 is needed here")
        return part

    def part(self, node: ast.AST) -> _Part:
        read = getattr(self, f"_{type(node).__name__.lower()}", None)
        if read is None:
            what = ast.get_source_segment(self.text, node) or type(node).__name__
            self.fail(node, f"{shortened(what, 40)!r} is not allowed in a formula{_ADVICE.get(type(node), '')}")
        part: _Part = read(node)
        return part

    def _constant(self, node: ast.Constant) -> _Part:
        if isinstance(node.value, bool) or not isinstance(node.value, (int, float)):
            self.fail(node, f"{str(node.value)[:20]!r} is not a number")
        try:
            number = float(node.value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            self.fail(node, "this number is too large")
        return _Part("number", lambda values: number, lambda names: repr(number))

    def _name(self, node: ast.Name) -> _Part:
        name = node.id
        if name == "pi":
            return _Part("number", lambda values: math.pi, lambda names: "pi")
        if name not in self.names:
            known = [*self.names, "pi", *FUNCTIONS, "min", "max"]
            call = "; write its argument in parentheses" if name in known else did_you_mean(name, known)
            self.fail(node, f"unknown name {shortened(name, 40)!r}{call} (known here: {', '.join([*self.names, 'pi'])})")
        self.used.add(name)
        return _Part("number", lambda values: values[name], lambda names: names[name])

    def _unaryop(self, node: ast.UnaryOp) -> _Part:
        if isinstance(node.op, ast.Not):
            inner = self.condition(node.operand)
            return _Part("condition", lambda values: np.logical_not(inner.value(values)), lambda names: f"(not {inner.text(names)})")
        if isinstance(node.op, ast.Invert):
            self.fail(node, "'~' is not allowed in a formula")
        inner = self.number(node.operand)
        if isinstance(node.op, ast.UAdd):
            return inner
        return _Part("number", lambda values: np.negative(inner.value(values)), lambda names: f"(-{inner.text(names)})")

    def _binop(self, node: ast.BinOp) -> _Part:
        if isinstance(node.op, ast.Pow):
            return self._power(node)
        if type(node.op) not in _OPERATORS:
            self.fail(node, f"this operator is not allowed in a formula{_ADVICE.get(type(node.op), '; use + - * / **')}")
        sign, apply = _OPERATORS[type(node.op)]
        a, b = self.number(node.left), self.number(node.right)
        return _Part(
            "number", lambda values: apply(a.value(values), b.value(values)), lambda names: f"({a.text(names)} {sign} {b.text(names)})"
        )

    def _power(self, node: ast.BinOp) -> _Part:
        base, whole = self.number(node.left), _whole_number(node.right)
        if whole is not None and abs(whole) <= MAX_POWER:
            # A positive whole power is written as a product of powers that compilers unroll; a negative one as its inverse.
            def text(names: Mapping[str, str]) -> str:
                power = f"({base.text(names)})**{abs(whole)}"
                return f"({power})" if whole >= 0 else f"(1.0 / {power})"

            return _Part("number", lambda values: np.power(np.asarray(base.value(values), dtype=float), float(whole)), text)
        exponent = self.number(node.right)
        return _Part(
            "number",
            lambda values: np.power(np.asarray(base.value(values), dtype=float), exponent.value(values)),
            lambda names: f"pow({base.text(names)}, {exponent.text(names)})",
        )

    def _call(self, node: ast.Call) -> _Part:
        if not isinstance(node.func, ast.Name):
            self.fail(node, "only the functions " + ", ".join([*FUNCTIONS, "min", "max"]) + " can be called")
        name = node.func.id
        if node.keywords or any(isinstance(a, ast.Starred) for a in node.args):
            self.fail(node, f"{name} takes plain arguments only")
        if name in ("min", "max"):
            return self._extreme(node, name)
        if name not in FUNCTIONS:
            known = [*FUNCTIONS, "min", "max"]
            self.fail(node, f"unknown function {shortened(name, 40)!r}{did_you_mean(name, known)} (known: {', '.join(known)})")
        if len(node.args) != 1:
            self.fail(node, f"{name} takes 1 argument, got {len(node.args)}")
        apply, inner = FUNCTIONS[name], self.number(node.args[0])
        return _Part("number", lambda values: apply(inner.value(values)), lambda names: f"{name}({inner.text(names)})")

    def _extreme(self, node: ast.Call, name: str) -> _Part:
        if len(node.args) < 2:
            self.fail(node, f"{name} takes 2 or more arguments, got {len(node.args)}")
        parts = [self.number(a) for a in node.args]
        apply = np.minimum if name == "min" else np.maximum
        return _Part(
            "number",
            lambda values: reduce(apply, [p.value(values) for p in parts]),
            lambda names: f"{name}({', '.join(p.text(names) for p in parts)})",
        )

    def _compare(self, node: ast.Compare) -> _Part:
        for op in node.ops:
            if type(op) not in _COMPARISONS:
                self.fail(node, "this comparison is not allowed in a formula; use < <= > >= == !=")
        parts = [self.number(n) for n in (node.left, *node.comparators)]
        pairs = [(*_COMPARISONS[type(op)], a, b) for op, a, b in zip(node.ops, parts, parts[1:], strict=False)]
        return _Part(
            "condition",
            lambda values: reduce(np.logical_and, [compare(a.value(values), b.value(values)) for _, compare, a, b in pairs]),
            lambda names: "(" + " and ".join(f"{a.text(names)} {sign} {b.text(names)}" for sign, _, a, b in pairs) + ")",
        )

    def _boolop(self, node: ast.BoolOp) -> _Part:
        parts = [self.condition(n) for n in node.values]
        word, apply = ("and", np.logical_and) if isinstance(node.op, ast.And) else ("or", np.logical_or)
        return _Part(
            "condition",
            lambda values: reduce(apply, [p.value(values) for p in parts]),
            lambda names: "(" + f" {word} ".join(p.text(names) for p in parts) + ")",
        )

    def _ifexp(self, node: ast.IfExp) -> _Part:
        test, a, b = self.condition(node.test), self.number(node.body), self.number(node.orelse)
        return _Part(
            "number",
            lambda values: np.where(test.value(values), a.value(values), b.value(values)),
            lambda names: f"({a.text(names)} if {test.text(names)} else {b.text(names)})",
        )


def _whole_number(node: ast.AST) -> int | None:
    """The value of a literal such as 2 or -3."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        inner = _whole_number(node.operand)
        return None if inner is None else -inner
    if isinstance(node, ast.Constant) and type(node.value) is int:
        return node.value
    if isinstance(node, ast.Constant) and type(node.value) is float and node.value.is_integer():
        return int(node.value)
    return None
