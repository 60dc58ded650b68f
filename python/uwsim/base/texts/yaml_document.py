"""The reader of YAML: a file as plain values with line numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from uwsim.base.texts.text_file import decoded, read_limited

MAX_BYTES = 300_000  # a file of this size takes at most 7 s

Key = str | int


def dotted(path: Sequence[Key]) -> str:
    """Return a key path as error messages show it: vehicles[0].sonar.model."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


@dataclass(frozen=True)
class YamlDocument:
    """A parsed YAML file. name: the file's name, for messages.

    values: only dicts, lists, text, numbers, booleans and None.
    """

    name: str
    values: dict[str, Any]
    text: str = field(repr=False)

    def line(self, path: Sequence[Key]) -> int:
        """Return the line, counted from 1, of a key or list item, or of its nearest existing ancestor."""
        from uwsim.base.texts.yaml_parser import line_of, parsed

        node: Any = parsed(self.text, self.name)
        line = 1
        for key in path:
            try:
                inner = node[key]
            except (KeyError, IndexError, TypeError):
                break
            line, node = line_of(node, key), inner
        return line

    def column(self, path: Sequence[Key]) -> int | None:
        """Return the column, counted from 0, of the keys of an existing mapping; None for one in braces."""
        from uwsim.base.texts.yaml_parser import parsed

        node: Any = parsed(self.text, self.name)
        for key in path:
            node = node[key]
        return None if node.fa.flow_style() else int(node.lc.col)


def read_yaml(
    path: Path, name: str = "", values_in: Callable[[str, str], dict[str, Any]] | None = None
) -> YamlDocument:
    """Read a YAML mapping. name: the file's name, for messages. Raises ValueError with name, line and rule.

    values_in: a function with the arguments and the result of yaml_parser.plain_values(), for instance from a cache.
    """
    name = name or str(path)
    text = decoded(read_limited(path, name, MAX_BYTES), name, "YAML text")
    return yaml_document(text, name, values_in)


def yaml_document(text: str, name: str, values_in: Callable[[str, str], dict[str, Any]] | None = None) -> YamlDocument:
    """Return the YAML mapping in a text; see read_yaml(). Raises ValueError."""
    if values_in is not None:
        return YamlDocument(name, values_in(text, name), text)
    from uwsim.base.texts.yaml_parser import plain_values

    return YamlDocument(name, plain_values(text, name), text)
