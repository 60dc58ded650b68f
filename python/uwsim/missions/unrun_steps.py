"""Finds the steps that a mission makes and never runs, as `goto(...)` alone on a line, without `yield from`.

Calling a generator function runs none of its body, so a step has no effect, whatever its arguments, if it is dropped,
only asked for its truth, as in `if until(...):`, or stored in a name that is not used otherwise: each that is found is
an error. The text of the mission is read, and of the functions that it calls outside uwsim and libraries. Not found are
steps that are passed on or kept in a container, and methods of objects whose class the text does not show.
"""

from __future__ import annotations

import ast
import builtins
import inspect
import linecache
import sysconfig
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from types import FunctionType, ModuleType
from typing import Any

STEP_TYPES = ("Steps[", "Wait")
OURS = "uwsim."
INSTALLED = tuple({sysconfig.get_path(scheme) for scheme in ("stdlib", "purelib", "platlib")})


def require_steps_run(mission: Any) -> None:
    """Raise ValueError, with file and line, if a mission or a part of it makes a step and never runs it."""
    parts, seen = _functions(mission), set[FunctionType]()
    while parts:
        function = parts.pop()
        if function in seen or f"{function.__module__}.".startswith(OURS) or _is_of_a_library(function):
            continue
        seen.add(function)
        tree = _tree(function)
        names = _names(function, tree)
        nodes = list(ast.walk(tree))
        for node in nodes:
            if isinstance(node, ast.Call):
                parts += _functions(_found(node.func, names))
        for call in (*_dropped(nodes), *_stored_only(nodes)):
            if isinstance(call, ast.Call) and _makes_steps(_found(call.func, names)):
                where = f"{function.__code__.co_filename}:{call.lineno}"
                text = ast.unparse(call.func)
                raise ValueError(f"{where}: {text}(...) is made and never run: write `yield from {text}(...)`")


def _is_of_a_library(function: FunctionType) -> bool:
    """Return whether a function is of an installed module that names nothing of uwsim, as NumPy's."""
    known = (each for each in function.__globals__.values() if isinstance(each, FunctionType | ModuleType | type))
    return function.__code__.co_filename.startswith(INSTALLED) and not any(
        f"{each.__name__ if isinstance(each, ModuleType) else each.__module__}.".startswith(OURS) for each in known
    )


_ASKS = ast.If | ast.While | ast.IfExp | ast.Assert | ast.UnaryOp
"""The nodes that ask for the truth of an expression."""


def _dropped(nodes: Sequence[ast.AST]) -> Iterator[ast.expr]:
    """Yield the expressions whose value is dropped: alone on a line, or after their truth was asked for."""
    for node in nodes:
        if isinstance(node, ast.Expr):
            yield from _values(node.value)
        elif isinstance(node, _ASKS):
            yield from _values(node.operand if isinstance(node, ast.UnaryOp) else node.test)


def _stored_only(nodes: Sequence[ast.AST]) -> Iterator[ast.expr]:
    """Yield the expressions whose value is stored in local names that are used nowhere, or only as in `_dropped`."""
    dropped = {id(value) for value in _dropped(nodes)}
    used = {
        node.id for node in nodes
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and id(node) not in dropped
    } | {name for node in nodes if isinstance(node, ast.Global | ast.Nonlocal) for name in node.names}  # fmt: skip
    of_classes = {id(line) for node in nodes if isinstance(node, ast.ClassDef) for line in node.body}
    for node in nodes:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None and id(node) not in of_classes:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if all(isinstance(target, ast.Name) and target.id not in used for target in targets):
                yield from _values(node.value)


def _values(node: ast.expr) -> Iterator[ast.expr]:
    """Yield the expressions that an expression has as its value or, of a list, as its elements."""
    parts: list[ast.expr] = []
    match node:
        case ast.IfExp():
            parts = [node.body, node.orelse]
        case ast.BoolOp():
            parts = node.values
        case ast.Tuple() | ast.List():
            parts = node.elts
        case ast.ListComp():
            parts = [node.elt]
        case _:
            yield node
    for part in parts:
        yield from _values(part)


def _functions(found: Any) -> list[FunctionType]:
    """Return the functions written in Python that calling an object runs: itself, or the methods of a class."""
    while isinstance(found, partial):
        found = found.func
    found = inspect.unwrap(found) if callable(found) else found
    methods = list(vars(found).values()) if inspect.isclass(found) else [getattr(found, "__func__", found)]
    return [method for method in methods if isinstance(method, FunctionType)]


def _tree(function: FunctionType) -> ast.AST:
    """Return a function's text, parsed, with its file's line numbers. It is empty if it cannot be read."""
    linecache.checkcache(function.__code__.co_filename)
    try:
        lines, first = inspect.getsourcelines(function)
        tree = ast.parse(textwrap.dedent("".join(lines)))
    except (OSError, TypeError, SyntaxError):  # SyntaxError: a lambda within an expression of several lines
        return ast.Module([], [])
    return ast.increment_lineno(tree, max(first, 1) - 1)


def _names(function: FunctionType, tree: ast.AST) -> dict[str, Any]:
    """Return what the names in a function refer to, as far as its text shows: for an instance, its class."""
    closed = inspect.getclosurevars(function)
    names: dict[str, Any] = {**vars(builtins), **function.__globals__, **closed.nonlocals}
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.name != function.__name__:
            names[node.name] = _Inner(node)
        elif isinstance(node, ast.arg):
            names[node.arg] = _found(node.annotation, names) if node.annotation is not None else None
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            made_by = _found(node.value.func, names) if isinstance(node.value, ast.Call) else None
            names[node.targets[0].id] = made_by if inspect.isclass(made_by) else None
    owner = function.__globals__.get(function.__qualname__.split(".")[0])
    return names | {"self": owner} if inspect.isclass(owner) else names


class _Inner:
    """A function defined inside another."""

    def __init__(self, node: ast.FunctionDef) -> None:
        self.is_generator = any(isinstance(inner, ast.Yield | ast.YieldFrom) for inner in ast.walk(node))


def _found(node: ast.AST, names: Mapping[str, Any]) -> Any:
    """Return the object that a name or a dotted name refers to, or None."""
    if isinstance(node, ast.Name):
        return names.get(node.id)
    if isinstance(node, ast.Attribute) and (owner := _found(node.value, names)) is not None:
        return inspect.getattr_static(owner, node.attr, None)
    return None


def _makes_steps(found: Any) -> bool:
    if isinstance(found, _Inner):
        return found.is_generator
    return any(
        inspect.isgeneratorfunction(function) or str(function.__annotations__.get("return", "")).startswith(STEP_TYPES)
        for function in _functions(found)
        if not inspect.isclass(found)
    )
