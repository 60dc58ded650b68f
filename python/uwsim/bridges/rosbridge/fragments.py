"""Reassembly of messages that a client sends in fragments (op "fragment")."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

from uwsim.bridges.doors.waiting import Room
from uwsim.bridges.rosbridge.encoding import to_json
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels.ros.message_types import shortened


class _Begun:
    """An unfinished message, whose parts are counted as they come."""

    def __init__(self, total: int) -> None:
        self.parts: list[str | None] = [None] * total
        self.missing, self.characters, self.bytes = total, 0, sys.getsizeof(self.parts)

    def add(self, number: int, data: str) -> None:
        """Add a part, or replace it."""
        before = self.parts[number]
        self.parts[number] = data
        self.missing -= before is None
        self.characters += len(data) - (0 if before is None else len(before))
        self.bytes += sys.getsizeof(data) - (0 if before is None else sys.getsizeof(before))


class Fragments:
    """One client's unfinished messages. room: of the client, for their bytes."""

    def __init__(self, limits: Limits, room: Room) -> None:
        self._limits = limits
        self._room = room
        self._begun: dict[str, _Begun] = {}

    def add(self, operation: dict[str, Any]) -> str | None:
        """Add a fragment. After the last one, return the complete message. Raises ValueError."""
        identity, data = operation.get("id"), operation.get("data")
        number, total = operation.get("num"), operation.get("total")
        if not isinstance(identity, str | int) or not isinstance(data, str):
            raise ValueError("fragment: id and data must be strings")
        if not (type(total) is int and 1 <= total <= self._limits.fragments):
            raise ValueError(f"fragment.total = {shortened(total)}: must be in [1, {self._limits.fragments}]")
        if not (type(number) is int and 0 <= number < total):
            raise ValueError(f"fragment.num = {shortened(number)}: must be in [0, {total - 1}]")
        key = str(identity)
        begun = self._forget(key)
        if begun is None or len(begun.parts) != total:
            begun = _Begun(total)
        begun.add(number, data)
        if begun.characters > self._limits.frame_bytes:
            raise ValueError(f"fragments: more than {self._limits.frame_bytes} bytes in total")
        if not begun.missing:
            return "".join(part for part in begun.parts if part is not None)
        if len(self._begun) >= self._limits.fragmented_messages:
            self._forget(next(iter(self._begun)))
        if not self._room.has(begun.bytes):
            raise ValueError("fragments: no room to keep them: too much waits for you")
        self._room.take(begun.bytes)
        self._begun[key] = begun  # moved to the end, so that the least recently used message comes first
        return None

    def _forget(self, key: str) -> _Begun | None:
        begun = self._begun.pop(key, None)
        if begun is not None:
            self._room.give(begun.bytes)
        return begun


def read_fragment_size(operation: dict[str, Any]) -> int | None:
    """Read the maximum size of a fragment [characters] from an operation; None for no limit. Raises ValueError."""
    size = operation.get("fragment_size")
    if size is not None and (type(size) is not int or size < 1):
        raise ValueError(f"fragment_size = {shortened(size)}: must be a positive whole number of characters")
    return size


def split(text: str, size: int, identity: str, most: int) -> Iterator[str]:
    """Split a text into "fragment" operations of up to `size` characters.

    Fragments are longer if there would otherwise be more than `most`.
    """
    size = max(size, -(-len(text) // most))
    total = -(-len(text) // size)
    for number in range(total):
        part = {"id": identity, "data": text[number * size : (number + 1) * size], "num": number, "total": total}
        yield to_json({"op": "fragment", **part})
