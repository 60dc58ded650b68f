"""Conversion of a message object to plain values, for JSON (orjson) or CBOR (cbor2), or to a ROS serialisation.

A writer is composed for each type on first use, which avoids inspecting types for every message.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from operator import attrgetter
from typing import Any, Literal

import cbor2
import numpy as np
import orjson

from uwsim.channels.ros.base64_text import to_base64
from uwsim.channels.ros.message_types import (
    EMPTY_PLACEHOLDER,
    Field,
    Kind,
    Ros,
    begins_with_header,
    fields,
    ros1_typestore,
    typestore,
    without_placeholder,
)

Form = Literal["json", "literal", "cbor"]
Writer = Callable[[Any], Any]

# RFC 8746, section 2.1: little-endian arrays.
TYPED_ARRAY_TAGS = {
    "int8": 72, "uint16": 69, "uint32": 70, "uint64": 71, "int16": 77, "int32": 78, "int64": 79,
    "float32": 85, "float64": 86,
}  # fmt: skip
BYTES = ("uint8", "char", "byte")  # arrays of these are base64 in JSON and a byte string in CBOR
NUMBERS = {
    "uint8", "char", "byte", "int8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64",
}  # fmt: skip
DEFAULTS: dict[str, Any] = {"string": "", "wstring": "", "bool": False, "float32": 0.0, "float64": 0.0}


def numpy_type(base: str) -> np.dtype[Any]:
    """Return the element type of an array of primitives, little-endian."""
    return np.dtype("uint8" if base in BYTES else base).newbyteorder("<")


def to_plain(message: Any, ros: Ros = 2, form: Form = "json") -> dict[str, Any]:
    """Return a message as a dict, with the field names that clients of ROS generation `ros` expect.

    form "json": numbers may be NaN, and arrays are NumPy arrays, which orjson writes as null and as lists. uint8[] is
    base64. form "literal": the same, but NaN and infinity become the words NaN, Infinity and -Infinity, as in Python's
    json; rosbridge_server accepts these, and rejects null in place of a number. A header has no seq, which ROS 1's
    publishers count themselves and ROS 2 rejects. form "cbor": arrays of numbers are typed arrays of RFC 8746, and
    uint8[] is bytes.
    """
    return _writer(message.__msgtype__, ros, form)(message)  # type: ignore[no-any-return]


def to_bytes(message: Any, ros: Ros = 2, sequence: int = 0) -> bytes:
    """Serialise a message for ROS 1, or for ROS 2 (little-endian CDR with a four-byte header).

    sequence: the number of earlier messages on the topic, which is header.seq in ROS 1.
    """
    name = message.__msgtype__
    if ros == 2:
        return bytes(typestore().serialize_cdr(message, name))
    data = bytes(ros1_typestore().serialize_ros1(_ros1_maker(name)(message), name))
    return numbered(data, name, sequence) if sequence else data


def numbered(data: bytes | memoryview, name: str, sequence: int) -> bytes:
    """Return a message serialised for ROS 1, with its header.seq (if it begins with a header) set to `sequence`."""
    return struct.pack("<I", sequence & 0xFFFFFFFF) + bytes(data[4:]) if begins_with_header(name) else bytes(data)


def from_bytes(data: bytes, name: str) -> Any:
    """Deserialise a message from ROS 2's format. Raises ValueError if the data are invalid."""
    try:
        return typestore().deserialize_cdr(data, name)
    except Exception as error:  # the generated code raises any error for damaged bytes
        raise ValueError(f"{name}: {len(data)} bytes that are not a valid serialisation of it ({error})") from None


@cache
def _writer(name: str, ros: Ros, form: Form) -> Writer:
    parts = [
        (field.name, _getter(field, ros, form), _value_writer(field.kind, ros, form))
        for field in fields(name, ros)
        if field.attribute is not None or form != "literal"
    ]
    copied = [(field, get) for field, get, write in parts if write is None]
    written = [(field, get, write) for field, get, write in parts if write is not None]
    if not written:
        return lambda message: {field: get(message) for field, get in copied}
    order = {field: None for field, _, _ in parts}

    def write_message(message: Any) -> dict[str, Any]:
        plain: dict[str, Any] = order.copy()
        for field, get in copied:
            plain[field] = get(message)
        for field, get, write in written:
            plain[field] = write(get(message))
        return plain

    return write_message


def _getter(field: Field, ros: Ros, form: Form) -> Callable[[Any], Any]:
    if field.attribute is not None:
        return attrgetter(field.attribute)
    default = default_value(field.kind)  # such as a header's seq, which ROS 2 dropped
    return lambda message: default


def _value_writer(kind: Kind, ros: Ros, form: Form) -> Writer | None:
    """Return a function that converts a field to plain values, or None if the field is already plain."""
    if kind.is_message:
        write = _writer(kind.base, ros, form)
        return write if kind.length is None else lambda values: [write(value) for value in values]
    if kind.length is None:
        return _scalar_writer(kind.base, form)
    if kind.base not in NUMBERS:
        return (lambda values: [bool(v) for v in values]) if kind.base == "bool" else list
    return _array_writer(kind.base, form)


def _scalar_writer(base: str, form: Form) -> Writer | None:
    if form == "literal" and base.startswith("float"):
        return lambda value: value if np.isfinite(value) else orjson.Fragment(_word(value))
    if form != "cbor" or base in ("string", "wstring"):
        return None
    if base == "bool":
        return bool
    return float if base.startswith("float") else int  # cbor2 does not support NumPy numbers


def _array_writer(base: str, form: Form) -> Writer:
    element = numpy_type(base)

    def contiguous(values: Any) -> np.ndarray[Any, np.dtype[Any]]:
        return np.ascontiguousarray(values, element)

    if base in BYTES:
        if form == "cbor":
            return lambda values: contiguous(values).tobytes()
        return lambda values: to_base64(contiguous(values).data)
    if form == "cbor":
        tag = TYPED_ARRAY_TAGS[base]
        return lambda values: cbor2.CBORTag(tag, contiguous(values).tobytes())
    if form == "literal" and base.startswith("float"):
        return lambda values: _literal_array(contiguous(values))
    return contiguous


def _literal_array(values: np.ndarray[Any, np.dtype[Any]]) -> Any:
    """Return a value that orjson writes as a list of numbers in which words replace NaN and infinity."""
    words = [_word(value) for value in values[~np.isfinite(values)]]
    if not words:
        return values
    parts = orjson.dumps(values, option=orjson.OPT_SERIALIZE_NUMPY).split(b"null")
    return orjson.Fragment(parts[0] + b"".join(word + part for word, part in zip(words, parts[1:], strict=True)))


def _word(value: float) -> bytes:
    return b"NaN" if np.isnan(value) else b"Infinity" if value > 0 else b"-Infinity"


def default_value(kind: Kind) -> Any:
    """Return ROS's default for an unset field: zero, "", an empty or zero-filled array, or a default message."""
    if kind.length is None:
        return default_message(kind.base) if kind.is_message else DEFAULTS.get(kind.base, 0)
    if kind.base in NUMBERS:
        return np.zeros(kind.length, numpy_type(kind.base))
    if kind.base == "bool":
        return np.zeros(kind.length, bool)
    return [default_value(Kind(kind.base, None, 0)) for _ in range(kind.length)]


def default_message(name: str) -> Any:
    """Return a new message of a type, with all fields at their defaults."""
    cls = typestore().types[name]
    values = {field.attribute: default_value(field.kind) for field in fields(name, 2) if field.attribute}
    return cls(**values) if values or not _has_placeholder(cls) else cls(**{EMPTY_PLACEHOLDER: 0})


def _has_placeholder(cls: type) -> bool:
    return bool(getattr(cls, "__dataclass_fields__", {}))


@cache
def _ros1_maker(name: str) -> Writer:
    """Return a factory for the ROS 1 class, whose fields differ slightly."""
    cls = ros1_typestore().types[name]
    parts = []
    originals = without_placeholder(ros1_typestore().fielddefs[name][1])
    placeholder = {} if originals or not _has_placeholder(cls) else {EMPTY_PLACEHOLDER: 0}
    for field, original in zip(fields(name, 1), originals, strict=True):
        parts.append((original[0], _getter(field, 1, "json"), _ros1_value(field.kind)))

    def make(message: Any) -> Any:
        return cls(**placeholder, **{attribute: convert(get(message)) for attribute, get, convert in parts})

    return make


def _ros1_value(kind: Kind) -> Writer:
    if kind.is_message:
        make = _ros1_maker(kind.base)
        return make if kind.length is None else lambda values: [make(value) for value in values]
    if kind.length is not None and kind.base in NUMBERS:
        element = numpy_type(kind.base)
        return lambda values: np.ascontiguousarray(values, element)
    return lambda value: value
