"""The modules of uwsim, what each imports, and the rings that they form."""

import ast
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple

ROOT = Path(__file__).parents[1]
PYTHON = ROOT / "python"
HEART = "heart"

When = Literal["always", "later", "types"]
"""When an import runs: with its module, in a function, or never, being for type checkers alone."""


class Import(NamedTuple):
    """One import of a module of uwsim in another."""

    module: str
    imported: str
    when: When


class Ring(NamedTuple):
    """rooms: modules and packages, without those that another ring names. needs: the add-ons that it imports."""

    rooms: tuple[str, ...]
    needs: frozenset[str]


@cache
def rings() -> Mapping[str, Ring]:
    """Return the rings of pyproject.toml by name, the heart first."""
    table = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["uwsim"]
    found = {HEART: table["heart"], **table["add-ons"]}
    return {
        name: Ring(tuple(f"uwsim.{room}" for room in ring["rooms"]), frozenset(ring.get("needs", ())))
        for name, ring in found.items()
    }


def ring_of(module: str) -> str | None:
    """Return the ring with the closest room around a module; None for the package's own files."""
    found = [(len(room), name) for name, ring in rings().items() for room in ring.rooms if is_in(module, room)]
    return max(found)[1] if found else None


def is_in(module: str, package: str) -> bool:
    """Return whether a module is a package or lies in it."""
    return f"{module}.".startswith(f"{package}.")


@cache
def modules() -> Mapping[str, Path]:
    """Return the files of all modules and packages by name."""
    found = {}
    for path in sorted((PYTHON / "uwsim").rglob("*.py")):
        parts = path.relative_to(PYTHON).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def imports() -> frozenset[Import]:
    """Return all imports of uwsim's own modules; of a name in a package, the package's."""
    return frozenset(
        Import(module, imported, when)
        for module, path in modules().items()
        for imported, when in imported_by(path.read_text())
        if imported != module
    )


def imported_by(text: str) -> Iterator[tuple[str, When]]:
    """Yield uwsim's modules that a text imports, and when."""
    for node, when in _statements(ast.parse(text), "always"):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [name if name in modules() else str(node.module) for name in names]
        yield from (
            (name, when) for name in names if name in modules() and name != "uwsim"
        )  # of which only _core is used


def _statements(node: ast.AST, when: When) -> Iterator[tuple[ast.Import | ast.ImportFrom, When]]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield child, when
        elif isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
            yield from _statements(ast.Module(child.body, []), "types")
            yield from _statements(ast.Module(child.orelse, []), when)
        else:
            is_function = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            yield from _statements(child, "later" if is_function and when == "always" else when)


def packages_around(module: str, importing: str) -> Iterator[str]:
    """Yield the packages that run before a module does, without those that contain the importing module."""
    parts = module.split(".")
    for end in range(2, len(parts)):
        package = ".".join(parts[:end])
        if not is_in(importing, package):
            yield package


def circles(edges: Iterable[tuple[str, str]]) -> list[set[str]]:
    """Return the groups of modules that reach each other (Tarjan 1972)."""
    to: dict[str, list[str]] = {}
    for start, end in sorted(set(edges)):
        to.setdefault(start, []).append(end)
    order: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    found: list[set[str]] = []

    def visit(module: str) -> None:
        order[module] = lowest[module] = len(order)
        stack.append(module)
        for end in to.get(module, ()):
            if end not in order:
                visit(end)
                lowest[module] = min(lowest[module], lowest[end])
            elif end in stack:
                lowest[module] = min(lowest[module], order[end])
        if lowest[module] == order[module]:
            at = stack.index(module)
            found.append(set(stack[at:]))
            del stack[at:]

    for module in to:
        if module not in order:
            visit(module)
    return [group for group in found if len(group) > 1]
