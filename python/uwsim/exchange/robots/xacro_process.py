"""Expansion of macros by ROS's xacro: the script of a contained process, with expressions by a grammar of ours."""

from __future__ import annotations

import io
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from xml.dom import minidom

import numpy as np
from numpy.typing import NDArray

from uwsim.base.texts.text_file import decoded, read_limited
from uwsim.exchange.robots.expressions import value_of
from uwsim.exchange.xml_text import xml_root

BYTES_MAX = 20_000_000
UNKNOWN = "unknown-package://"
"""The address of a package whose folder is not given."""
LEFT_OUT = ("type", "vars", "complex", "slice", "hash")
"""Functions of xacro that no robot needs, and that lead from values to classes."""


def read(path: str, given: dict[str, Any]) -> dict[str, NDArray[np.uint8]]:
    """Return the document of a file after its macros.

    given: its `roots`, the folders that it may read, the folders of `packages` and its `arguments`, by name.
    """
    roots = [Path(each) for each in given["roots"]]

    def find(name: str) -> str:
        return str(given["packages"].get(name, UNKNOWN + name))

    sys.modules["ament_index_python"] = ModuleType("ament_index_python")
    index = sys.modules["ament_index_python.packages"] = ModuleType("ament_index_python.packages")
    index.get_package_share_directory = find  # type: ignore[attr-defined]
    import xacro
    from xacro import substitution_args

    symbols = xacro._global_symbols
    for name in LEFT_OUT:
        symbols["python"].pop(name, None)
    functions = [each for table in (symbols, *symbols.values()) if isinstance(table, dict) for each in table.values()]

    def content(name: str) -> bytes:
        if not any(Path(name).resolve().is_relative_to(root) for root in roots):
            raise ValueError(f"'{name}': is outside '{roots[0]}': must be in the file's checkout or a ROS package")
        return read_limited(Path(name), f"'{name}'", BYTES_MAX)

    def parse(_: Any, name: str) -> minidom.Document:
        try:
            data = content(name)
        except ValueError as error:  # of the type that makes an include optional
            raise xacro.XacroException(exc=OSError(str(error))) from None
        xml_root(data, f"'{name}'")  # which has no entities, and is not too deep
        return minidom.parseString(data)

    def evaluated(text: str, names: Any, _: Any = None) -> Any:
        return value_of(text, names, functions)

    def evaluated_argument(text: str, context: Any) -> str:
        def argument(name: str) -> Any:
            return substitution_args.convert_value(context["arg"][name], "auto")

        own = {name: argument(name) for name in context["arg"]}
        names = {**symbols["math"], **symbols, "true": True, "false": False, **own, "arg": argument, "find": find}
        return str(value_of(text, names, [*functions, argument, find]))

    def refused(resolved: str, text: str, *_: Any) -> str:
        raise ValueError(f"$({text}): the environment is not read: an argument can have the value")

    def extension(text: str) -> Any:
        try:
            return whole(text) if text == "$(cwd)" else substitution_args.resolve_args(text, given_arguments)
        except substitution_args.ArgException as error:
            raise xacro.XacroException("Undefined substitution argument", exc=error) from None

    whole, given_arguments = xacro.eval_extension, xacro.substitution_args_context
    xacro.safe_eval, xacro.parse, xacro.eval_extension = evaluated, parse, extension
    xacro.open = lambda name: io.StringIO(decoded(content(name), f"'{name}'", "YAML"))
    xacro.glob = SimpleNamespace(glob=lambda name: [str(each) for root in roots for each in _matches(root, name)])
    substitution_args._eval, substitution_args._env = evaluated_argument, refused
    made = str(xacro.process_file(path, mappings=given["arguments"]).toxml()).encode()
    return {"document": np.frombuffer(made, np.uint8)}


def _matches(root: Path, name: str) -> list[Path]:
    """Return the files within a folder that a pattern names."""
    return list(root.glob(str(Path(name).relative_to(root)))) if Path(name).is_relative_to(root) else []
