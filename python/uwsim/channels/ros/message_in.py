"""Conversion of plain values, from a client's JSON or CBOR, to a message object. Every field is checked.

A missing or null field gets its default, except that null for a floating-point number means NaN, as in our output. An
error states the field's path, its value and the rule, as in `msg.linear.x = 'fast': must be a number (float64)`.

The messages in a list are counted against a budget before any is built: `{}` has two characters and becomes hundreds of
bytes. What else is built takes a few times the memory of the plain values.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any

import cbor2
import numpy as np

from uwsim.channels.ros.base64_text import from_base64
from uwsim.channels.ros.message_out import BYTES, NUMBERS, TYPED_ARRAY_TAGS, default_message, default_value, numpy_type
from uwsim.channels.ros.message_types import TIMES, Field, Kind, Ros, fields, shortened, typestore

SLICE_NUMBERS = 16_384
"""The number of list elements that NumPy converts in one call, which blocks all other threads."""
SPELLINGS = {"secs": "sec", "nsecs": "nanosec", "nanosecs": "nanosec"}  # fields of times in ROS 1
IGNORED = {"std_msgs/msg/Header": ("seq",)}  # ROS 1's seq is not used
_ARRAYS = {tag: np.dtype(name).newbyteorder("<") for name, tag in TYPED_ARRAY_TAGS.items()} | {
    64: np.dtype("u1"),
    68: np.dtype("u1"),
}
_BIG_ENDIAN = {65: ">u2", 66: ">u4", 67: ">u8", 73: ">i2", 74: ">i4", 75: ">i8", 81: ">f4", 82: ">f8"}
_ARRAYS |= {tag: np.dtype(name) for tag, name in _BIG_ENDIAN.items()}


class Budget:
    """Counts the messages within one message, of which there may be `most`."""

    def __init__(self, most: float) -> None:
        self._most, self._count = most, 0

    def charge(self, name: str, count: int, path: str) -> None:
        """Count messages that are about to be built. Raises ValueError if there are too many."""
        self._count += count * messages_in(name)
        if self._count > self._most:
            raise ValueError(f"{path}: a message of more than {self._most} messages, the maximum")


Reader = Callable[[Any, str, Budget], Any]  # value, path, budget


def from_plain(name: str, plain: Any, path: str = "msg", most: float = math.inf) -> Any:
    """Build a message of type `name` from plain values, whose fields may be spelled as in ROS 1 or ROS 2.

    most: the number of messages that it may consist of. Raises ValueError that states path, value and rule.
    """
    budget = Budget(most)
    budget.charge(name, 1, path)
    return _reader(name)(plain, path, budget)


@cache
def messages_in(name: str) -> int:
    """Return how many messages a message of this type with empty lists consists of, itself included."""
    inner = (field.kind for field in fields(name, 2) if field.attribute and field.kind.is_message)
    return 1 + sum(messages_in(kind.base) * (1 if kind.length is None else kind.length) for kind in inner)


def typed_array(tag: cbor2.CBORTag) -> np.ndarray[Any, np.dtype[Any]]:
    """Return the array in an RFC 8746 CBOR tag. Raises ValueError for other tags and for invalid lengths."""
    element = _ARRAYS.get(tag.tag)
    if element is None or not isinstance(tag.value, bytes) or len(tag.value) % element.itemsize:
        raise ValueError(f"CBOR tag {tag.tag}: must be a typed array of RFC 8746 with whole elements")
    return np.frombuffer(tag.value, element)


@cache
def _reader(name: str) -> Reader:
    cls = typestore().types[name]
    known: dict[str, tuple[str, Reader, Field]] = {}
    generations: tuple[Ros, Ros] = (1, 2)
    for ros in generations:
        for field in fields(name, ros):
            if field.attribute is not None:
                known[field.name] = (field.attribute, _value_reader(_own_kind(name, field)), field)
    if name in TIMES:
        known |= {spelling: known[to] for spelling, to in SPELLINGS.items() if to in known}
    ignored = IGNORED.get(name, ())
    wanted = {field.attribute: field.kind for field in fields(name, 2) if field.attribute}

    def read(value: Any, path: str, budget: Budget) -> Any:
        if value is None:
            return default_message(name)
        if not isinstance(value, dict):
            raise ValueError(f"{path} = {shortened(value)}: must be an object ({name})")
        found = {}
        for key, part in value.items():
            if key in known:
                attribute, read_value, field = known[key]
                if part is not None or (field.kind.length is None and field.kind.base.startswith("float")):
                    found[attribute] = read_value(part, f"{path}.{key}", budget)
            elif key not in ignored:
                rule = f"{name} has no such field; it has: {', '.join(wanted) or 'none'}"
                raise ValueError(f"{path}.{shortened(key)[:40].strip(chr(39))}: {rule}")
        for attribute, kind in wanted.items():
            if attribute not in found:
                found[attribute] = default_value(kind)
        return cls(**found) if wanted else default_message(name)

    return read


def _own_kind(name: str, field: Field) -> Kind:
    return next(own.kind for own in fields(name, 2) if own.attribute == field.attribute)


def _value_reader(kind: Kind) -> Reader:
    if kind.length is not None:
        return _array_reader(kind) if kind.base in NUMBERS or kind.base == "bool" else _list_reader(kind)
    if kind.is_message:
        return lambda value, path, budget: _reader(kind.base)(value, path, budget)
    return _scalar_reader(kind)


def _scalar_reader(kind: Kind) -> Reader:
    base = kind.base
    if base in ("string", "wstring"):
        return lambda value, path, _: _read_string(value, path, kind)
    if base == "bool":
        return lambda value, path, _: _read_bool(value, path)
    if base.startswith("float"):
        return lambda value, path, _: _read_float(value, path, base)
    limits = np.iinfo(numpy_type(base))
    low, high = int(limits.min), int(limits.max)
    return lambda value, path, _: _read_int(value, path, base, low, high)


def _read_string(value: Any, path: str, kind: Kind) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{path} = {shortened(value)}: must be a string")
    if kind.limit and len(value) > kind.limit:
        raise ValueError(f"{path}: {len(value)} characters: must be {kind.limit} at most")
    try:
        value.encode()
    except UnicodeEncodeError:
        raise ValueError(f"{path}: a string with half a surrogate pair: must be Unicode text") from None
    return value


def _read_bool(value: Any, path: str) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{path} = {shortened(value)}: must be true or false (bool)")
    return value


def _read_float(value: Any, path: str, base: str) -> float:
    if value is None:
        return math.nan
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{path} = {shortened(value)}: must be a number ({base})")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{path} = {shortened(value)}: must be a number ({base})") from None


def _read_int(value: Any, path: str, base: str, low: int, high: int) -> int:
    whole = value
    if isinstance(value, float) and value.is_integer():
        whole = int(value)  # JavaScript has only floats
    if isinstance(whole, bool) or not isinstance(whole, int) or not low <= whole <= high:
        raise ValueError(f"{path} = {shortened(value)}: must be a whole number in [{low}, {high}] ({base})")
    return whole


def _list_reader(kind: Kind) -> Reader:
    read_one = _value_reader(Kind(kind.base, None, 0))

    def read(value: Any, path: str, budget: Budget) -> list[Any]:
        if not isinstance(value, list):
            raise ValueError(f"{path} = {shortened(value)}: must be a list ({kind.base}[])")
        _check_length(len(value), path, kind)
        if kind.is_message and not kind.length:  # those of a list of fixed length are counted with its message
            budget.charge(kind.base, len(value), path)
        return [read_one(element, f"{path}[{k}]", budget) for k, element in enumerate(value)]

    return read


def _array_reader(kind: Kind) -> Reader:
    element = np.dtype(bool) if kind.base == "bool" else numpy_type(kind.base)

    def read(value: Any, path: str, _: Budget) -> np.ndarray[Any, np.dtype[Any]]:
        if isinstance(value, list):
            _check_length(len(value), path, kind)
            return from_list(value, path)
        array = _bytes_or_array(value, path, kind)
        if array.ndim != 1:
            raise ValueError(f"{path}: must be a flat list of {kind.base}")
        _check_length(len(array), path, kind)
        return convert(array, value, path, 0)

    def from_list(value: list[Any], path: str) -> np.ndarray[Any, np.dtype[Any]]:
        found = np.zeros(len(value), element)
        for start in range(0, len(value), SLICE_NUMBERS):
            part = value[start : start + SLICE_NUMBERS]
            found[start : start + len(part)] = convert(_numbers(part, kind), part, path, start)
        return found

    def convert(
        array: np.ndarray[Any, np.dtype[Any]], value: Any, path: str, start: int
    ) -> np.ndarray[Any, np.dtype[Any]]:
        if not len(array):
            return np.zeros(0, element)
        if kind.base == "bool":
            good = array.dtype.kind == "b"
        elif element.kind == "f":
            good = array.dtype.kind in "fiu"
        else:
            good = _all_in_range(array, element)
        if not good:
            wrong = _first_bad(value, kind, start)
            raise ValueError(f"{path}{wrong}: must be {_rule(element)}, each ({kind.base}[])")
        with np.errstate(over="ignore"):  # values beyond float32 become infinite
            return array.astype(element)

    return read


def _bytes_or_array(value: Any, path: str, kind: Kind) -> np.ndarray[Any, np.dtype[Any]]:
    if isinstance(value, cbor2.CBORTag):
        return typed_array(value)
    if isinstance(value, bytes) and kind.base in (*BYTES, "int8"):
        return np.frombuffer(value, np.int8 if kind.base == "int8" else np.uint8)
    if isinstance(value, str) and kind.base in BYTES:
        try:
            return np.frombuffer(from_base64(value), np.uint8)
        except ValueError:
            raise ValueError(f"{path}: a string of {len(value)} characters: must be base64 ({kind.base}[])") from None
    if isinstance(value, np.ndarray):
        return value
    raise ValueError(f"{path} = {shortened(value)}: must be a list ({kind.base}[])")


def _numbers(value: list[Any], kind: Kind) -> np.ndarray[Any, np.dtype[Any]]:
    """Convert a list to an array of a type chosen by NumPy, or of strings if not all items are numbers."""
    types = set(map(type, value))
    if kind.base.startswith("float") and type(None) in types:
        value = [np.nan if v is None else v for v in value]
        types = types - {type(None)} | {float}
    try:
        # Types are checked first, since NumPy would convert true and false to numbers.
        wrong = not types <= ({bool} if kind.base == "bool" else {int, float})
        return np.array(["no number"] if wrong else value)
    except (ValueError, OverflowError):
        return np.array(["no number"])


def _all_in_range(array: np.ndarray[Any, np.dtype[Any]], element: np.dtype[Any]) -> bool:
    limits = np.iinfo(element)
    if array.dtype.kind == "f":
        if not np.all(np.isfinite(array)) or np.any(array != np.floor(array)):
            return False
    elif array.dtype.kind not in "iu":
        return False
    return bool(int(array.min()) >= limits.min and int(array.max()) <= limits.max)


def _rule(element: np.dtype[Any]) -> str:
    if element.kind in "fb":
        return "a number" if element.kind == "f" else "true or false"
    limits = np.iinfo(element)
    return f"a whole number in [{limits.min}, {limits.max}]"


def _first_bad(value: Any, kind: Kind, start: int) -> str:
    """Return `[index] = value` for the first element that breaks the rule. start: the index at which `value` begins."""
    read_one = _scalar_reader(Kind(kind.base, None, 0))
    for k, element in enumerate(value if isinstance(value, list) else ()):
        try:
            read_one(element, "", Budget(math.inf))
        except ValueError:
            return f"[{start + k}] = {shortened(element)}"
    return ""


def _check_length(length: int, path: str, kind: Kind) -> None:
    if kind.length and length != kind.length:
        raise ValueError(f"{path}: {length} elements: must be {kind.length} ({kind.base}[{kind.length}])")
    if kind.limit and length > kind.limit:
        raise ValueError(f"{path}: {length} elements: must be {kind.limit} at most")
