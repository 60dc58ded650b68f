"""Changes of the structure of a YAML text: values that are set, added and removed, while all else stays as it is.

Each change is verified: the changed text is read again, and must hold exactly the values that were asked for. Texts are
parsed by ruamel.yaml but not written by it: its dump wraps every long line of the file again and aligns columns its own
way, adds keys below the comment of the next section, and removes that comment with the last key above it. Slow to
import.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import orjson
from ruamel.yaml.error import StringMark
from ruamel.yaml.nodes import MappingNode, ScalarNode, SequenceNode

from uwsim.base.texts.yaml_document import Key, dotted
from uwsim.base.texts.yaml_edit import Place, child
from uwsim.base.texts.yaml_parser import node_of, plain_values

PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_./ -]*(?<! )")
WORDS = ("true", "false", "null", "yes", "no", "on", "off", "y", "n")
WIDTH = 100
"""Columns of a mapping on one line; a longer one has a line for each key."""


@dataclass(frozen=True)
class _Span:
    """A replacement of text[start:end]."""

    start: int
    end: int
    text: str


def with_value(text: str, name: str, place: Place, value: Any) -> str:
    """Return a YAML text with this value at its place.

    Only what differs is written. The mappings and lists on the way are created; an index one past the end of a list
    adds an item. name: of the file, for messages. Raises ValueError if the text cannot be changed there.
    """
    wanted = copy.deepcopy(plain_values(text, name))
    _put(wanted, place, value, name)
    return _verified(_Text(text).with_spans(lambda at: at.set(place, value)), wanted, name, place)


def without(text: str, name: str, place: Place) -> str:
    """Return a YAML text without a key or an item, and without the mappings and lists that this leaves empty.

    Comments on the lines of the removed value go with it; those above it stay. Raises ValueError.
    """
    wanted: Any = copy.deepcopy(plain_values(text, name))
    while True:
        above = wanted
        for key in place[:-1]:
            above = _item(above, key, name, place)
        _item(above, place[-1], name, place)
        if len(above) > 1 or len(place) == 1:
            break
        place = place[:-1]
    del above[place[-1]]
    return _verified(_Text(text).with_spans(lambda at: at.removed(place)), wanted, name, place)


def _verified(text: str, wanted: Any, name: str, place: Place) -> str:
    try:
        is_right = _is_same(plain_values(text, name), wanted)
    except ValueError:
        is_right = False
    if not is_right:
        rule = "cannot be changed here without changing more, as with an alias: edit it by hand"
        raise ValueError(f"{name}: {dotted(place)}: {rule}")
    return text


def _is_same(one: Any, other: Any) -> bool:
    """Return whether values are equal, and flags are not numbers, as they are in Python."""
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_is_same(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list | tuple):
        return len(one) == len(other) and all(map(_is_same, one, other))
    return bool(one == other) and isinstance(one, bool) == isinstance(other, bool)


def _item(values: Any, key: Key, name: str, place: Place) -> Any:
    try:
        if isinstance(values, str):  # whose letters are no items
            raise KeyError(key)
        return values[key]
    except (KeyError, IndexError, TypeError):
        raise ValueError(f"{name}: {dotted(place)}: is not written there") from None


def _put(values: Any, place: Place, value: Any, name: str) -> None:
    for key, inner in pairwise(place):
        if isinstance(values, dict) and values.get(key) is None:
            values[key] = [] if inner == 0 else {}
        values = _item(values, key, name, place)
    if isinstance(values, list) and place[-1] == len(values):
        values.append(value)
        return
    if isinstance(values, list) or not isinstance(values, dict):
        _item(values, place[-1], name, place)
    values[place[-1]] = value


def flow(value: Any) -> str:
    """Return a value as YAML on one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(flow, value)) + "]"
    if isinstance(value, str):
        return value if PLAIN.fullmatch(value) and value.lower() not in WORDS else orjson.dumps(value).decode()
    if isinstance(value, float):
        return f"{value:.0f}" if value.is_integer() and abs(value) < 1e15 else _decimal(value)
    return "null" if value is None else str(value).lower() if isinstance(value, bool) else str(value)


def _decimal(value: float) -> str:
    """Return a float as YAML 1.2 reads it: with a point before the exponent."""
    text = repr(value)
    return text if "e" not in text or "." in text else text.replace("e", ".0e")


def block(value: Any, column: int, newline: str = "\n") -> str:
    """Return a mapping or a list as lines at this column, the first without its indent; anything else on one line."""
    gap = newline + " " * column
    if isinstance(value, Mapping) and value:
        return gap.join(f"{key}:{_below(item, column, newline)}" for key, item in value.items())
    if isinstance(value, list | tuple) and _has_mappings(value):
        return gap.join(f"- {block(item, column + 2, newline)}" for item in value)
    return flow(value)


def _below(value: Any, column: int, newline: str) -> str:
    """Return a key's value: on the same line if it is short and not nested deeply."""
    line = flow(value)
    is_deep = _has_mappings(value) or (isinstance(value, Mapping) and any(map(_has_mappings, value.values())))
    if isinstance(value, Mapping | list) and value and (is_deep or column + len(line) > WIDTH):
        lines = block(value, column + 2, newline)
        if lines != line:
            return newline + " " * (column + 2) + lines
    return " " + line


def _has_mappings(value: Any) -> bool:
    """Return whether a mapping or a list holds mappings."""
    items = value.values() if isinstance(value, Mapping) else value if isinstance(value, list | tuple) else ()
    return any(isinstance(item, Mapping) for item in items)


class _Text:
    """A text and its nodes, for one set of changes."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.newline = "\r\n" if "\r\n" in text else "\n"
        self._root = node_of(text)
        self._place_nothing(self._root)

    def _place_nothing(self, node: Any) -> None:
        """Place absent values after their colon: the parser has them where the next key begins."""
        for key, value in _pairs(node) if _has_items(node) else ():
            if isinstance(node, MappingNode) and value.start_mark.index == value.end_mark.index:
                index = self.text.index(":", key.end_mark.index) + 1
                value.start_mark = value.end_mark = StringMark("", index, 0, 0, None, 0)
            self._place_nothing(value)

    def with_spans(self, make: Callable[[_Text], Iterator[_Span]]) -> str:
        text = self.text
        for span in sorted(make(self), key=lambda span: (span.start, span.end), reverse=True):
            text = text[: span.start] + span.text + text[span.end :]
        return text

    def set(self, place: Place, value: Any) -> Iterator[_Span]:
        """Yield the replacements that put a value at a place."""
        node, above, depth = self._root, None, 0
        for key in place:
            inner = child(node, key)
            if inner is None:
                break
            node, above, depth = inner, node, depth + 1
        if depth == len(place):
            yield from self._replaced(node, above, value)
            return
        for key in reversed(place[depth + 1 :]):
            value = [value] if key == 0 else {key: value}
        if _has_items(node):
            addition = self._added(node, place[depth], value)
            if isinstance(node, MappingNode) and self._is_too_long(node, above, addition):
                own = plain_values(f"value: {self._of(node)}", "")["value"]
                yield from self._rewritten(node, above, {**own, place[depth]: value})
            else:
                yield addition
        else:
            yield from self._rewritten(node, above, {place[depth]: value} if place[depth] != 0 else [value])

    def removed(self, place: Place) -> Iterator[_Span]:
        """Yield the removal of a key or an item that has others beside it."""
        node = self._root
        for key in place[:-1]:
            node = child(node, key)
        starts = [(key if isinstance(node, MappingNode) else value).start_mark.index for key, value in _pairs(node)]
        index = [key.value for key, _ in _pairs(node)].index(place[-1]) if isinstance(node, MappingNode) else place[-1]
        assert isinstance(index, int)
        end = self._end(_pairs(node)[index][1])
        is_after_a_dash = self.text[self._line_start(starts[index]) : starts[index]].strip()
        if node.flow_style and index > 0:
            yield _Span(self._end(_pairs(node)[index - 1][1]), end, "")
        elif index + 1 < len(starts) and (node.flow_style or (isinstance(node, MappingNode) and is_after_a_dash)):
            yield _Span(starts[index], starts[index + 1], "")
        else:
            yield _Span(self._line_start(starts[index]), self._line_end(end) + len(self.newline), "")

    def _replaced(self, node: Any, above: Any, value: Any) -> Iterator[_Span]:
        """Yield the replacement of those parts of a value that differ."""
        if isinstance(node, MappingNode) and isinstance(value, Mapping) and node.value:
            own = {key.value: inner for key, inner in node.value}
            if own.keys() <= value.keys():
                for key, inner in own.items():
                    yield from self._replaced(inner, node, value[key])
                yield from (self._added(node, key, value[key]) for key in value if key not in own)
                return
        if isinstance(node, SequenceNode) and isinstance(value, list | tuple) and 0 < len(node.value) == len(value):
            for inner, item in zip(node.value, value, strict=True):
                yield from self._replaced(inner, node, item)
            return
        is_scalar = isinstance(node, ScalarNode) and not isinstance(value, Mapping | list | tuple)
        if not (is_scalar and _is_same(plain_values(f"v: {self._of(node)}", "")["v"], value)):
            yield from self._rewritten(node, above, value)

    def _rewritten(self, node: Any, above: Any, value: Any) -> Iterator[_Span]:
        """Yield the replacement of a whole value: a nested one, in a block, by lines below its key."""
        start, end = node.start_mark.index, self._end(node)
        column = 0 if above is None else above.start_mark.column
        is_block = above is None or not above.flow_style
        lines = block(value, column + 2, self.newline)
        is_short = not is_block or isinstance(above, SequenceNode) or _below(value, column, "\n")[0] == " "
        if is_short and not (_has_items(node) and not node.flow_style):
            yield _Span(start, end, ("" if start < end else " ") + flow(value))
        elif self.text[self._line_start(start) : start].strip():  # on its key's line, whose comment stays
            at = self._line_end(end)
            yield _Span(at, at, self.newline + " " * (column + 2) + lines)
            yield _Span(len(self.text[:start].rstrip(" ")), end, "")
        else:
            yield _Span(start, end, block(value, node.start_mark.column, self.newline))

    def _added(self, node: Any, key: Key, value: Any) -> _Span:
        """Return the addition of a key or an item after the last one."""
        pairs = _pairs(node)
        end = self._end(pairs[-1][1])
        if node.flow_style:
            return _Span(end, end, ", " + (flow(value) if isinstance(node, SequenceNode) else f"{key}: {flow(value)}"))
        column = (pairs[0][0] if isinstance(node, MappingNode) else node).start_mark.column
        at = self._line_end(end)
        if isinstance(node, SequenceNode):
            lines = "- " + block(value, column + 2, self.newline)
        else:
            lines = f"{key}:{_below(value, column, self.newline)}"
        return _Span(at, at, self.newline + " " * column + lines)

    def _is_too_long(self, node: Any, above: Any, addition: _Span) -> bool:
        """Return whether a mapping in braces, in a block, no longer fits on its line with an addition."""
        is_inline = node.flow_style and isinstance(above, MappingNode) and not above.flow_style
        length = addition.end - self._line_start(node.start_mark.index) + len(addition.text)
        return bool(is_inline and length > WIDTH)

    def _of(self, node: Any) -> str:
        return self.text[node.start_mark.index : node.end_mark.index]

    def _end(self, node: Any) -> int:
        """Return where a value ends, without the comments and lines below it."""
        if _has_items(node) and not node.flow_style:
            return self._end(_pairs(node)[-1][1])
        return int(node.start_mark.index) + len(self._of(node).rstrip())

    def _line_start(self, index: int) -> int:
        return self.text.rfind("\n", 0, index) + 1

    def _line_end(self, index: int) -> int:
        end = self.text.find(self.newline, index)
        return len(self.text) if end < 0 else end


def _pairs(node: Any) -> list[tuple[Any, Any]]:
    return list(node.value if isinstance(node, MappingNode) else enumerate(node.value))


def _has_items(node: Any) -> bool:
    return isinstance(node, MappingNode | SequenceNode) and bool(node.value)
