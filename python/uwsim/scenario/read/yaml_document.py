"""A YAML file as plain values with line numbers."""

from __future__ import annotations

import copy
import functools
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from uwsim.scenario.read.disk_cache import cached_json
from uwsim.scenario.read.errors import ScenarioError

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
    _text: str = field(repr=False)

    def line(self, path: Sequence[Key]) -> int:
        """Return the line, counted from 1, of a key or list item, or of its nearest existing ancestor."""
        from uwsim.scenario.read.yaml_parser import line_of, parsed

        node: Any = parsed(self._text, self.name)
        line = 1
        for key in path:
            try:
                inner = node[key]
            except (KeyError, IndexError, TypeError):
                break
            line, node = line_of(node, key), inner
        return line


def read_yaml(path: Path, name: str) -> YamlDocument:
    """Read a YAML mapping. name: the file's name, for messages. Raises ScenarioError with name and line."""
    text = _read_text(path, name)
    return YamlDocument(name, copy.deepcopy(_values(text, name)), text)


@functools.lru_cache(maxsize=64)  # files rarely change
def _values(text: str, name: str) -> dict[str, Any]:
    """Return a document's content, which must not be modified. Parsing takes a tenth of a simulator's start-up time."""

    def parse() -> dict[str, Any]:
        from uwsim.scenario.read.yaml_parser import plain_values

        return plain_values(text, name)

    values: dict[str, Any] = cached_json(parse, "yaml", text)
    return values


def _read_text(path: Path, name: str) -> str:
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise ScenarioError(f"{name}: {size} bytes: must be at most {MAX_BYTES}")
        data = path.read_bytes()
    except OSError as error:
        raise ScenarioError(f"{name}: cannot be read: {error.strerror}") from None
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ScenarioError(f"{name}:{line}: not UTF-8 text") from None
    if "\0" in text:
        raise ScenarioError(f"{name}: a binary file, expected YAML text")
    return text
