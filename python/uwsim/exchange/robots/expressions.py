"""Expressions of Python in others' files, by a grammar of ours: values, operators, and the functions that are given.

xacro evaluates them by Python itself, where a text reaches everything: attributes lead from any value to all classes.
Here, a name is one of the file's or of xacro's symbols, an attribute is an entry of a table, a call is one of a given
function, or of a text's or table's method below; whatever else Python has is refused by its name.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Iterable, Mapping
from typing import Any

OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv, ast.Mod: operator.mod, ast.Pow: operator.pow,
    ast.UAdd: operator.pos, ast.USub: operator.neg, ast.Not: operator.not_,
    ast.Eq: operator.eq, ast.NotEq: operator.ne, ast.Is: operator.is_, ast.IsNot: operator.is_not,
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge,
    ast.In: lambda one, many: operator.contains(many, one),
    ast.NotIn: lambda one, many: not operator.contains(many, one),
}  # fmt: skip
METHODS: dict[type, tuple[str, ...]] = {
    str: (
        *("lower", "upper", "title", "strip", "lstrip", "rstrip", "split", "replace", "join", "startswith", "endswith"),
        *("find", "count", "index", "isdigit"),
    ),
    list: ("count", "index"),
    dict: ("keys", "values", "items", "get"),
}
SIZE_MAX = 1_000_000
"""The longest text or list, and bits of a whole number, that an operator makes."""


def value_of(text: str, names: Mapping[str, Any], functions: Iterable[Any]) -> Any:
    """Return the value of an expression. functions: those that it may call. Raises ValueError, or an operator's error.

    A name that is none of `names` raises NameError, as in Python.
    """
    allowed = {id(each) for each in functions}

    def value(node: ast.AST | None) -> Any:
        match node:
            case ast.Constant():
                return node.value
            case ast.Name():
                if node.id not in names:
                    raise NameError(f"name '{node.id}' is not defined")
                return names[node.id]
            case ast.List() | ast.Tuple():
                made = [value(each) for each in node.elts]
                return made if isinstance(node, ast.List) else tuple(made)
            case ast.Dict() if all(node.keys):
                return {value(key): value(each) for key, each in zip(node.keys, node.values, strict=True) if key}
            case ast.UnaryOp() if type(node.op) in OPERATORS:
                return OPERATORS[type(node.op)](value(node.operand))
            case ast.BinOp() if type(node.op) in OPERATORS:
                return _combined(type(node.op), value(node.left), value(node.right))
            case ast.BoolOp():
                for each in node.values:
                    found = value(each)
                    if bool(found) is isinstance(node.op, ast.Or):
                        break
                return found
            case ast.IfExp():
                return value(node.body if value(node.test) else node.orelse)
            case ast.Compare():
                left = value(node.left)
                for op, each in zip(node.ops, node.comparators, strict=True):
                    right = value(each)
                    if not OPERATORS[type(op)](left, right):
                        return False
                    left = right
                return True
            case ast.Slice():
                return slice(*(None if each is None else value(each) for each in (node.lower, node.upper, node.step)))
            case ast.Subscript():
                return value(node.value)[value(node.slice)]
            case ast.Attribute() if isinstance(table := value(node.value), dict) and node.attr in table:
                return table[node.attr]
            case ast.Call() if all(each.arg for each in node.keywords):
                given = {str(each.arg): value(each.value) for each in node.keywords}
                return called(node.func)(*(value(each) for each in node.args), **given)
        raise ValueError(f"{text.strip()[:60]!r}: {type(node).__name__}: is not part of expressions here")

    def called(node: ast.AST) -> Callable[..., Any]:
        if isinstance(node, ast.Attribute):
            of = value(node.value)
            for kind, methods in METHODS.items():
                if isinstance(of, kind) and node.attr in methods and not (isinstance(of, dict) and node.attr in of):
                    return getattr(kind, node.attr).__get__(of)  # type: ignore[no-any-return]
        if id(found := value(node)) in allowed:
            return found  # type: ignore[no-any-return]
        raise ValueError(f"{text.strip()[:60]!r}: calls something that is not a function of expressions here")

    try:
        return value(ast.parse(text.strip(), mode="eval").body)
    except (SyntaxError, RecursionError) as error:
        raise ValueError(f"{text.strip()[:60]!r}: must be an expression: {error}") from None


def _combined(operation: type[ast.AST], left: Any, right: Any) -> Any:
    """Return the value of an operator of two. Raises ValueError where a short text asks for much memory or time."""
    sizes = [len(each) for each in (left, right) if isinstance(each, str | list | tuple)]
    times = [abs(each) for each in (left, right) if isinstance(each, int)]
    if operation is ast.Pow and len(times) == 2:
        sizes, times = [times[0].bit_length()], times[1:]
    if operation in (ast.Mult, ast.Pow) and sizes and times and sizes[0] * times[0] > SIZE_MAX:
        raise ValueError(f"an operator makes more than {SIZE_MAX}")
    return OPERATORS[operation](left, right)
