"""Edits of values in a YAML text, which leave everything else as it is: comments, order, styles. Slow to import."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from io import StringIO
from itertools import groupby
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from uwsim.base.texts.yaml_document import Key, dotted

Place = tuple[Key, ...]
Remark = Callable[[list[Place], str, bool], str]
COMMENT = re.compile(r"(?:^|(?<=\s))#[^\r\n]*|[^\S\r\n]*(?=[\r\n]|$)")
GAP = "   "


@dataclass(frozen=True)
class _Edit:
    """A replacement of text[start:end]. place: the value's place; empty for a comment. gap: what follows a new key."""

    start: int
    end: int
    text: str
    place: Place = ()
    gap: str = ""

    @property
    def has_own_line(self) -> bool:
        return self.gap.startswith("\n")


def with_values(text: str, name: str, values: Mapping[Place, str], remark: Remark | None = None) -> str:
    """Return a valid YAML text with these values at their places, of which only a mapping's last key may be new.

    remark: returns the comment at the end of a line with new values, from their places, the comment that is there
    ("" for none), and whether the line keeps other numbers than 0; None to leave comments as they are. name: for
    messages. Raises ValueError.
    """
    root = YAML(typ="rt").compose(StringIO(text))
    made = [_edit(root, *each, name) for each in values.items()]
    edits = list(
        {(edit.start, edit.place if edit.gap else ()): edit for edit in made}.values()
    )  # aliases share a start
    ends, kept = _lines(root, {edit.start for edit in edits})
    if remark is not None:
        own_lines = [edit for edit in edits if edit.has_own_line]
        edits = [edit for edit in edits if not edit.has_own_line]
        edits += [replace(edit, text=f"{edit.text}{GAP}# {remark([edit.place], '', False)}") for edit in own_lines]
        edits += _comments(text, [edit for edit in edits if not edit.has_own_line], ends, kept, remark)
    for edit in sorted(edits, key=lambda edit: (edit.start, edit.end), reverse=True):
        text = text[: edit.start] + edit.text + edit.gap + text[edit.end :]
    return text


def _comments(text: str, edits: list[_Edit], ends: dict[int, int], kept: set[int], remark: Remark) -> Iterator[_Edit]:
    """Yield the replacement of the comment of each edited line. ends, kept: see _lines."""
    for line, group in groupby(sorted(edits, key=_start), lambda edit: text.count("\n", 0, edit.start)):
        own = list(group)
        end = max(ends.get(line, 0), *(edit.end for edit in own))
        found = COMMENT.search(text, end)
        assert found is not None  # the end of the text matches, too
        new = remark([edit.place for edit in own], found[0].strip().removeprefix("#").strip(), line in kept)
        start = end + len(text[end : found.start()].rstrip())
        yield _Edit(start, found.end(), f"{GAP}# {new}")


def _start(edit: _Edit) -> int:
    return edit.start


def _edit(root: Node, place: Place, value: str, name: str) -> _Edit:
    """Return the replacement of a value, or the insertion of its key before the first key of its mapping."""
    node = root
    for depth, key in enumerate(place):
        inner = child(node, key)
        if inner is None and depth == len(place) - 1 and isinstance(node, MappingNode) and node.value:
            first = node.value[0][0].start_mark
            gap = ", " if node.flow_style else "\n" + " " * first.column
            return _Edit(first.index, first.index, f"{key}: {value}", place, gap)
        if inner is None:
            raise ValueError(f"{name}: {dotted(place)}: is not written there: cannot be replaced")
        node = inner
    return _Edit(node.start_mark.index, node.end_mark.index, value, place)


def child(node: Node, key: Key) -> Any:
    """Return the node below a node, or None."""
    if isinstance(node, MappingNode):
        return next((value for own, value in node.value if own.value == key), None)
    if isinstance(node, SequenceNode) and isinstance(key, int) and key < len(node.value):
        return node.value[key]
    return None


def _lines(root: Node, replaced: set[int]) -> tuple[dict[int, int], set[int]]:
    """Return, by line, where its last scalar ends, and the lines with numbers, not 0, that are not replaced."""
    ends: dict[int, int] = {}
    kept = set()
    for node in _scalars(root):
        line = node.end_mark.line
        ends[line] = max(ends.get(line, 0), node.end_mark.index)
        is_number = str(node.tag).endswith((":int", ":float")) and node.value.strip("+-.0")
        if is_number and node.start_mark.index not in replaced:
            kept.add(line)
    return ends, kept


def _scalars(node: Node) -> Iterator[ScalarNode]:
    if isinstance(node, ScalarNode):
        yield node
    elif isinstance(node, MappingNode):
        for key, value in node.value:
            yield from (*_scalars(key), *_scalars(value))
    else:
        for item in node.value:
            yield from _scalars(item)
