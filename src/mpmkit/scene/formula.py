"""Which formula a user might write instead of a Python function."""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Callable
from typing import Any

from mpmkit.errors import MpmkitError
from mpmkit.expression import ARGUMENT_OF, Expression

EXAMPLE = 'for example "10*sin(2*pi*t)"'
_NAME_OF = {argument: name for name, argument in ARGUMENT_OF.items()}


def proposal(function: Callable[..., Any]) -> str:
    """The formulas that `function` returns, if its source shows some that mpmkit accepts, otherwise an example.

    The function's source is read, not run; x[0] and x[:, 0] become x, and np.sin becomes sin.
    """
    node = _returned(function)
    if node is None:
        return EXAMPLE
    parts = node.elts if isinstance(node, (ast.Tuple, ast.List)) else [node]
    try:
        texts = [ast.unparse(_Translator().visit(part)) for part in parts]
        for text in texts:
            Expression(text)
    except (MpmkitError, _NoFormula):
        return EXAMPLE
    quoted = ", ".join(f'"{text}"' for text in texts)
    return f"perhaps {quoted if len(texts) == 1 else f'[{quoted}]'}"


class _NoFormula(Exception):
    """The source has something no formula can say."""


class _Translator(ast.NodeTransformer):
    """From arguments of Python functions to names of formulas."""

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        index = node.slice.elts[-1] if isinstance(node.slice, ast.Tuple) else node.slice
        text = f"{ast.unparse(node.value)}[{ast.unparse(index)}]"
        if text not in _NAME_OF:
            raise _NoFormula
        return ast.Name(_NAME_OF[text], ast.Load())

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        return ast.Name(node.attr, ast.Load())

    def visit_Name(self, node: ast.Name) -> ast.AST:
        if node.id in ("x", "X", "v"):
            raise _NoFormula  # the whole vector; in a formula x is one coordinate
        return node


def _returned(function: Callable[..., Any]) -> ast.expr | None:
    """What a function returns: the body of a lambda, or the only statement of a def."""
    try:
        wanted = list(inspect.signature(function).parameters)
        tree = ast.parse(_cut(textwrap.dedent(inspect.getsource(function))))
    except (OSError, TypeError, ValueError, SyntaxError):
        return None
    found: list[ast.expr] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Lambda) and [a.arg for a in node.args.args] == wanted:
            found.append(node.body)
        elif isinstance(node, ast.FunctionDef) and [a.arg for a in node.args.args] == wanted and len(node.body) == 1:
            statement = node.body[0]
            if isinstance(statement, ast.Return) and statement.value is not None:
                found.append(statement.value)
    # Two lambdas with the same arguments on one line: there is no telling which one it is.
    return found[0] if len(found) == 1 else None


def _cut(source: str) -> str:
    """Source that parses by itself: a lambda may begin in the middle of a call that goes on in other lines."""
    try:
        ast.parse(source)
    except SyntaxError:
        start = source.find("lambda")
        for end in range(len(source), max(start, 0), -1):
            try:
                ast.parse(source[start:end], mode="eval")
            except (SyntaxError, ValueError):
                continue
            return source[start:end]
    return source
