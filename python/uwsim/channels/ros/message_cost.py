"""The memory cost of a message, predicted before the message is built and measured afterwards.

A message with empty lists has a fixed size, which depends on its type. A client can increase it only with lists, whose
lengths are known, so the cost is bounded before anything is built.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import orjson

from uwsim.channels.ros.message_out import NUMBERS, default_message, numpy_type, to_plain
from uwsim.channels.ros.message_types import Kind, fields

SLICE_OBJECTS = 500
"""The number of objects built before other tasks get a turn."""
SLICE_NUMBERS = 16_384
"""The number of list elements converted before other tasks get a turn."""
SLOT_BYTES = 8
OBJECT_BYTES = 72
FEW_FIELDS = 16  # with more fields, each object has a dict
FIELD_BYTES = 18  # in a key-sharing dict, as measured for a hundred objects
SHARED_FIELDS = 29  # with more, each object has a dict of its own ...
UNUSED_BYTES = 272  # ... and, in Python 3.13, its unused room for the values of shared keys
ARRAY_BYTES = 232  # an empty array, and its tag in CBOR
NUMBER_BYTES = 32
STRING_BYTES = 64
LONGEST_NUMBER = {"float64": 25, "float32": 16}  # characters in JSON, with the comma; for integers see _digits


class Cost(NamedTuple):
    """The cost of one message with empty lists. written_bytes: the size of its plain values plus twice its JSON."""

    objects: int
    made_bytes: int
    written_bytes: int


@cache
def cost_of(name: str) -> Cost:
    """Return the cost of a message of this type with empty lists."""
    message = default_message(name)
    objects, made = _measured(message)
    text = len(orjson.dumps(to_plain(message, 1), option=orjson.OPT_SERIALIZE_NUMPY))
    return Cost(objects, made, _plain_bytes(to_plain(message, 1, "cbor")) + 2 * text)


def _measured(message: Any) -> tuple[int, int]:
    objects, size = 1, OBJECT_BYTES + _fields_bytes(vars(message))
    for value in vars(message).values():
        for part in value if isinstance(value, list) else [value]:
            if hasattr(part, "__msgtype__"):
                inner = _measured(part)
                objects, size = objects + inner[0], size + inner[1] + SLOT_BYTES
            elif isinstance(part, np.ndarray):
                size += ARRAY_BYTES + part.nbytes
        size += sys.getsizeof(value) if isinstance(value, list) else 0
    return objects, size


def _fields_bytes(values: dict[str, Any]) -> int:
    count = len(values)
    if count <= FEW_FIELDS:
        return 16 * count
    if count <= SHARED_FIELDS:
        return max(FIELD_BYTES * count, sys.getsizeof(values))
    return UNUSED_BYTES + sys.getsizeof(values)


def _plain_bytes(value: Any) -> int:
    if isinstance(value, dict):
        return sys.getsizeof(value) + sum(_plain_bytes(part) for part in value.values())
    if isinstance(value, list):
        return sys.getsizeof(value) + sum(_plain_bytes(part) for part in value)
    return ARRAY_BYTES if hasattr(value, "tag") or isinstance(value, bytes) else 0


def _digits(base: str) -> int:
    return LONGEST_NUMBER.get(base) or 2 + len(str(np.iinfo(numpy_type(base)).max))


@cache
def element_cost(kind: Kind) -> Cost:
    """Return the cost of one additional list element."""
    if kind.is_message:
        one = cost_of(kind.base)
        return Cost(one.objects, one.made_bytes + SLOT_BYTES, one.written_bytes + SLOT_BYTES)
    if kind.base == "bool":
        return Cost(0, 9, 2 * 6)
    if kind.base in NUMBERS:
        # during conversion, an array of a type chosen by NumPy also exists
        return Cost(0, SLOT_BYTES + numpy_type(kind.base).itemsize, 2 * _digits(kind.base))
    return Cost(0, SLOT_BYTES, SLOT_BYTES + 6)


class Meter:
    """Counts the objects that one frame creates, and rejects excessive frames before they are built.

    limit_bytes: the limit on the size of the decoded frame plus the message, and later on the size of the message plus
    its written form. spent_bytes: the size of the decoded frame. objects: the maximum number of messages within the
    message. pause: called between chunks of the work. made_bytes: the size of the message as counted so far.
    """

    def __init__(
        self,
        limit_bytes: float = math.inf,
        spent_bytes: float = 0,
        objects: float = math.inf,
        pause: Callable[[], None] | None = None,
    ) -> None:
        self.limit_bytes = limit_bytes
        self.spent_bytes = spent_bytes
        self.made_bytes = 0
        self.objects = 0
        self.pauses = 0
        self._written_bytes = 0
        self._most_objects = objects
        self._pause = pause

    def charge(self, cost: Cost, count: int, path: str) -> None:
        """Count elements that are about to be built. Raises ValueError if they exceed a limit."""
        self.objects += count * cost.objects
        self.made_bytes += count * cost.made_bytes
        self._written_bytes += count * cost.written_bytes
        if self.objects > self._most_objects:
            raise ValueError(f"{path}: a message of more than {self._most_objects} messages, the maximum")
        needed = self.made_bytes + max(self.spent_bytes, self._written_bytes)
        if needed > self.limit_bytes:
            rule = f"must take {self.limit_bytes / 1e6:.1f} MB of memory at most"
            raise ValueError(f"{path}: a message that takes {needed / 1e6:.1f} MB: one of this size {rule}")

    def pause(self) -> None:
        """Let other tasks run."""
        self.pauses += 1
        if self._pause is not None:
            self._pause()


def held_bytes(message: Any) -> int:
    """Return a message's approximate size [bytes]: its type's fixed size, plus lists, arrays and strings."""
    return _holder(message.__msgtype__)(message)


@cache
def _holder(name: str) -> Callable[[Any], int]:
    own = cost_of(name).made_bytes
    parts = [
        (field.attribute, _part_holder(field.kind))
        for field in fields(name, 2)
        if field.attribute and _part_holder(field.kind)
    ]

    def hold(message: Any) -> int:
        return own + sum(size(getattr(message, attribute)) for attribute, size in parts)  # type: ignore[misc]

    return hold


def _part_holder(kind: Kind) -> Callable[[Any], int] | None:
    """Return a function that measures a field's memory beyond the fixed size of its type, or None if there is none."""
    if kind.is_message:
        if kind.length is None:
            return lambda value: _holder(kind.base)(value) if _varies(kind.base) else 0
        return lambda values: sum(_holder(kind.base)(value) for value in values)
    if kind.length is not None and kind.base in NUMBERS:
        return lambda values: int(getattr(values, "nbytes", NUMBER_BYTES * len(values)))
    if kind.length is not None:
        return lambda values: sum(STRING_BYTES + len(value) if isinstance(value, str) else 1 for value in values)
    return len if kind.base in ("string", "wstring") else None


@cache
def _varies(name: str) -> bool:
    return any(
        field.kind.length is not None
        or field.kind.base in ("string", "wstring")
        or (field.kind.is_message and _varies(field.kind.base))
        for field in fields(name, 2)
        if field.attribute
    )
