"""Parsing of YAML by ruamel, with the line of every key. Slow to import and to run: yaml_document.py avoids both."""

from __future__ import annotations

import functools
import re
from io import StringIO
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.constructor import ConstructorError, DuplicateKeyError, RoundTripConstructor
from ruamel.yaml.error import MarkedYAMLError, YAMLError

from uwsim.base.caught_warnings import caught_warnings

MAX_VALUES = 200_000
"""Counted with aliases expanded: a few lines of nested aliases can expand to billions of values."""


KEPT = 4
_nodes: dict[str, Any] = {}  # of the texts parsed last, whose changes begin with them


@functools.lru_cache(maxsize=64)
def parsed(text: str, name: str) -> CommentedMap:
    """Parse a document, which must not be modified. name: for messages. Raises ValueError with name and line."""
    reader = YAML(typ="rt")
    reader.Constructor = _Constructor
    try:
        if "!" in text:
            _refuse_tags(text, name)
        with caught_warnings():  # such as ReusedAnchorWarning: YAML 1.2 allows reused anchors
            root = reader.load(StringIO(text))
        _keep(text, reader.constructor.node)
    except DuplicateKeyError as error:
        raise ValueError(
            f"{name}:{_line(error)}: {str(error.problem).split(' with ')[0].removeprefix('found ')}"
        ) from None
    except MarkedYAMLError as error:
        reason = " ".join(str(part) for part in (error.context, error.problem) if part)
        raise ValueError(f"{name}:{_line(error)}: not valid YAML: {reason}") from None
    except YAMLError as error:
        raise ValueError(f"{name}: not valid YAML: {_first_line(error)}") from None
    except NotImplementedError as error:  # raised by ruamel for two comments in one place
        found = re.search(r"line: (\d+)", str(error))
        line = f":{int(found[1]) + 1}" if found else ""
        raise ValueError(f"{name}{line}: a comment between a key and its value: write it above the key") from None
    except RecursionError:
        raise ValueError(f"{name}: not valid YAML: nested too deeply") from None
    if root is None:
        raise ValueError(f"{name}: is empty, expected keys and values")
    if not isinstance(root, CommentedMap):
        raise ValueError(f"{name}:1: expected keys and values, such as 'name: lake'")
    return root


def node_of(text: str) -> Any:
    """Return the root node of a text: as `parsed` has left it if it was parsed lately. Raises YAMLError."""
    found = _nodes.get(text)
    return YAML(typ="rt").compose(StringIO(text)) if found is None else found


def _keep(text: str, node: Any) -> None:
    """Keep a text's nodes for `node_of`, but of one with merged keys, which are lost as it is read."""
    if "<<" not in text:
        for old in list(_nodes)[: 1 - KEPT]:
            _nodes.pop(old, None)
        _nodes[text] = node


def plain_values(text: str, name: str) -> dict[str, Any]:
    """Return the document's content: only dicts, lists, text, numbers, booleans and None. Raises ValueError."""
    return _Plain(name).mapping(parsed(text, name))


class _Constructor(RoundTripConstructor):
    """Keeps the root `node`, and adds line numbers to the errors for numbers or dates that Python does not read."""

    def get_single_data(self) -> Any:
        self.node = self.composer.get_single_node()
        return None if self.node is None else self.construct_document(self.node)

    def construct_object(self, node: Any, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep=deep)
        except (ArithmeticError, IndexError, KeyError, ValueError) as error:
            reason = f"not a number or date that can be read: '{node.value!s:.40}'"
            raise ConstructorError(problem=reason, problem_mark=node.start_mark) from error

    def check_mapping_key(self, node: Any, key_node: Any, mapping: Any, key: Any, value: Any) -> bool:
        try:
            return bool(super().check_mapping_key(node, key_node, mapping, key, value))
        except TypeError as error:  # a mapping that contains a list is not hashable
            raise ConstructorError(problem="a key is no plain word", problem_mark=key_node.start_mark) from error


def _refuse_tags(text: str, name: str) -> None:
    for event in YAML(typ="rt").parse(StringIO(text)):
        tag = getattr(event, "ctag", None)
        if tag is not None and tag.trval:
            line = event.start_mark.line + 1
            raise ValueError(f"{name}:{line}: tags are not supported: remove '{_written(tag):.60}'")


def _written(tag: Any) -> str:
    return f"{tag.handle or ''}{tag.suffix or ''}"


class _Plain:
    """Converts ruamel's values, which carry comments and styles, to plain values."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._count = 0
        self._open: list[int] = []

    def mapping(self, node: CommentedMap) -> dict[str, Any]:
        self._enter(node)
        plain = {}
        for key, value in node.items():
            line = line_of(node, key)
            if not isinstance(key, str):
                raise ValueError(f"{self._name}:{line}: key {key}: must be text")
            plain[str(key)] = self._value(value, line)
        self._open.pop()
        return plain

    def _sequence(self, node: CommentedSeq) -> list[Any]:
        self._enter(node)
        plain = [self._value(value, line_of(node, index)) for index, value in enumerate(node)]
        self._open.pop()
        return plain

    def _enter(self, node: CommentedMap | CommentedSeq) -> None:
        if id(node) in self._open:
            raise ValueError(f"{self._name}:{node.lc.line + 1}: an alias refers to a value that contains it")
        self._open.append(id(node))

    def _value(self, value: Any, line: int) -> Any:
        self._count += 1
        if self._count > MAX_VALUES:
            raise ValueError(f"{self._name}: more than {MAX_VALUES} values, its aliases written out")
        if isinstance(value, CommentedMap):
            return self.mapping(value)
        if isinstance(value, CommentedSeq):
            return self._sequence(value)
        for kind in (bool, int, float, str):
            if isinstance(value, kind):
                return kind(value)
        if value is None:
            return None
        if type(value).__name__ == "ScalarBoolean":  # ruamel's type for a boolean with an anchor is an int
            return bool(value)
        raise ValueError(f"{self._name}:{line}: neither text, number, boolean, list nor keys: {value!s:.60}")


def line_of(node: CommentedMap | CommentedSeq, key: Any) -> int:
    """Return the line of a key or item or, if it comes from an alias, of the enclosing mapping or list."""
    try:
        line, _ = node.lc.key(key) if isinstance(node, CommentedMap) else node.lc.item(key)
    except (KeyError, TypeError):
        line = node.lc.line
    return int(line) + 1


def _line(error: MarkedYAMLError) -> int:
    mark = error.problem_mark or error.context_mark
    return int(mark.line) + 1 if mark is not None else 1


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0]
