"""Encodes messages for subscribers, once per encoding, when the first subscriber needs it."""

from __future__ import annotations

import base64
import binascii
import io
import math
import sys
from collections.abc import Callable
from typing import Any, Literal

import cbor2
import numpy as np
import orjson
from PIL import Image

from uwsim.bridges.doors.conversation import Frame
from uwsim.channels.ros.base64_text import to_base64
from uwsim.channels.ros.message_types import begins_with_header
from uwsim.channels.ros.messages import Ros, to_bytes, to_plain

Compression = Literal["none", "cbor", "cbor-raw", "png"]
JSON_OPTIONS = orjson.OPT_SERIALIZE_NUMPY
LARGE_BYTES = 1 << 16
"""Larger messages are encoded off the network thread, and store only one encoding at a time."""
NUMBER_BYTES, OBJECT_BYTES = 32, 200  # the second: of an object, list or array without its parts
SLICE_NUMBERS = 1 << 16  # array elements written per call
CBOR_ARRAY, CBOR_MAP = 4, 5  # major types, RFC 8949, section 3.1


def to_json(operation: dict[str, Any]) -> str:
    """Encode an operation as JSON. Raises ValueError if JSON cannot represent a value."""
    try:
        return orjson.dumps(operation, default=_plain, option=JSON_OPTIONS).decode()
    except TypeError as error:
        raise ValueError(f"cannot be written as JSON: {error}") from None


def _plain(value: Any) -> Any:
    if isinstance(value, bytes):  # from a client's CBOR
        return to_base64(value)
    if isinstance(value, np.ndarray) and not value.dtype.isnative:
        return value.astype(value.dtype.newbyteorder("="))
    if hasattr(value, "tolist"):  # a type that orjson does not write
        return value.tolist()
    raise TypeError(f"Type is not JSON serializable: {type(value).__name__}")


def _in_slices(value: Any) -> Any:
    """Write an array in a large message in chunks, so that no call takes long."""
    if not isinstance(value, np.ndarray) or value.ndim != 1:
        return orjson.Fragment(orjson.dumps(value, default=_plain, option=JSON_OPTIONS))
    starts = range(0, max(1, len(value)), SLICE_NUMBERS)
    slices = (np.ascontiguousarray(value[start : start + SLICE_NUMBERS]) for start in starts)
    return orjson.Fragment(b"[" + b",".join(orjson.dumps(part, option=JSON_OPTIONS)[1:-1] for part in slices) + b"]")


def _cbor_in_pieces(plain: dict[str, Any]) -> bytes:
    """Write a large message as CBOR value by value, so that no call takes long."""
    buffer = io.BytesIO()
    encoder = cbor2.CBOREncoder(buffer)

    def write(value: Any) -> None:
        if isinstance(value, dict):
            encoder.encode_length(CBOR_MAP, len(value))
            for key, part in value.items():
                encoder.encode(key)
                write(part)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            encoder.encode_length(CBOR_ARRAY, len(value))
            for part in value:
                write(part)
        else:
            encoder.encode(value)

    write(plain)
    return buffer.getvalue()


def to_png(text: str) -> str:
    """Encode an operation's JSON as the pixels of a PNG, as in rosbridge's "png" compression."""
    data = text.encode()
    width = max(1, math.isqrt(len(data) // 3))
    height = math.ceil(len(data) / 3 / width)
    pixels = data.ljust(3 * width * height, b"\n")
    buffer = io.BytesIO()
    Image.frombytes("RGB", (width, height), pixels).save(buffer, "PNG", compress_level=1)
    return f'{{"op":"png","data":"{to_base64(buffer.getvalue())}"}}'


def from_png(data: str, size_max: int) -> str:
    """Decode the operation in a PNG's pixels, as rosbridge's clients send it. Raises ValueError.

    size_max: limit on the decoded size, which is known before anything is decoded.
    """
    try:
        picture = Image.open(io.BytesIO(base64.b64decode(data, validate=True)), formats=("PNG",))
        size = picture.width * picture.height * len(picture.getbands())
        if size > size_max:
            raise ValueError(f"png: {size} bytes of pixels: must be {size_max} at most")
        return picture.tobytes().decode()
    except (OSError, SyntaxError, UnicodeDecodeError, binascii.Error) as error:
        raise ValueError(f"png.data: not a PNG of text in base64 ({error})") from None


def publication(message: Any, topic: str, ros: Ros, identity: str = "") -> str:
    """Return a "publish" operation as a client sends it to a rosbridge_server, with literal NaN and Infinity.

    identity: its id, which the server repeats if it refuses the message.
    """
    named = {"id": identity} if identity else {}
    operation = {"op": "publish", **named, "topic": topic, "msg": to_plain(message, ros, "literal")}
    return orjson.dumps(operation, option=JSON_OPTIONS).decode()


def held_bytes(value: Any) -> int:
    """Return the approximate memory of a message or of plain values [bytes]."""
    if value is None or isinstance(value, int | float | np.generic):
        return NUMBER_BYTES
    if isinstance(value, np.ndarray):
        return OBJECT_BYTES + value.nbytes
    if isinstance(value, str | bytes):
        return sys.getsizeof(value)
    if isinstance(value, cbor2.CBORTag):
        return OBJECT_BYTES + held_bytes(value.value)
    parts = value if isinstance(value, list) else (value if isinstance(value, dict) else vars(value)).values()
    return OBJECT_BYTES + sum(map(held_bytes, parts))


class Sample:
    """A message on a topic, and the frames that encode it. time_ns: time of receipt, for cbor-raw.

    sequence: the message's header.seq in ROS 1, which is the number of earlier messages on the topic.
    """

    __slots__ = ("_frames", "_size", "message", "sequence", "time_ns")
    builds_up = False

    def __init__(self, message: Any, time_ns: int = 0) -> None:
        self.message = message
        self.time_ns = time_ns
        self.sequence = 0
        self._size: int | None = None
        self._frames: dict[Any, Any] = {}

    @property
    def size(self) -> int:
        """The approximate size in memory [bytes]: twice the size of the message, to allow for its encodings."""
        if self._size is None:
            self._size = 2 * held_bytes(self.message)
        return self._size

    @property
    def is_large(self) -> bool:
        """Whether encoding takes long."""
        return self.size > LARGE_BYTES

    @property
    def is_taken(self) -> bool:
        """Whether the message has been encoded for any subscriber."""
        return bool(self._frames)

    def after(self, cursor: Any) -> tuple[Sample, Any]:
        """Return the message for a subscriber that has everything up to a cursor, and its next cursor."""
        return self, None

    def frame(self, topic: str, ros: Ros, compression: Compression) -> Frame:
        """Return the frame for a "publish" operation, with the topic name as spelled by the subscriber."""
        key = (topic, ros, compression)
        frame: Frame | None = self._frames.get(key)
        if frame is None:
            frame = self._encode(topic, ros, compression)
            if self.is_large:
                self._frames.clear()  # subscribers may use many different spellings
            self._frames[key] = frame
        return frame

    def _encode(self, topic: str, ros: Ros, compression: Compression) -> Frame:
        if compression in ("cbor", "cbor-raw"):
            return b"".join((_cbor_head(topic), self._body(ros, compression)))
        head = f'{{"op":"publish","topic":{to_json_string(topic)},"msg":'.encode()
        text = b"".join((head, self._body(ros, "none"), b"}")).decode()
        return to_png(text) if compression == "png" else text

    def _body(self, ros: Ros, compression: Compression) -> bytes:
        """Encode the message without its topic, which subscribers may spell differently (with or without a slash)."""
        if self.is_large:
            return self._encode_body(ros, compression)
        key = (ros, compression)
        body: bytes | None = self._frames.get(key)
        if body is None:
            body = self._frames[key] = self._encode_body(ros, compression)
        return body

    def _encode_body(self, ros: Ros, compression: Compression) -> bytes:
        if compression == "none":
            plain = self._plain(ros, "json")
            if self.is_large:
                return orjson.dumps(plain, default=_in_slices)
            text = orjson.dumps(plain, option=JSON_OPTIONS)
            return bytes(memoryview(text))  # a copy, since orjson's result keeps a buffer up to ten times as large
        if compression == "cbor":
            plain = self._plain(ros, "cbor")
            return _cbor_in_pieces(plain) if self.is_large else cbor2.dumps(plain)
        secs, nsecs = divmod(self.time_ns, 10**9)
        return cbor2.dumps({"secs": secs, "nsecs": nsecs, "bytes": to_bytes(self.message, ros, self.sequence)})

    def _plain(self, ros: Ros, form: Literal["json", "cbor"]) -> dict[str, Any]:
        plain = to_plain(self.message, ros, form)
        if ros == 1 and begins_with_header(self.message.__msgtype__):
            plain[next(iter(plain))]["seq"] = self.sequence
        return plain


class Growing(Sample):
    """A change to a topic whose messages build on each other. Subscribers receive the changes that they lack as one.

    catch_up: returns the message for a cursor (None: the subscriber has nothing) and the next cursor.
    """

    __slots__ = ("_catch_up",)
    builds_up = True

    def __init__(self, catch_up: Callable[[Any], tuple[Any, Any]], time_ns: int = 0) -> None:
        super().__init__(None, time_ns)
        self._catch_up = catch_up

    def after(self, cursor: Any) -> tuple[Sample, Any]:
        """Combine all changes made since the cursor."""
        message, following = self._catch_up(cursor)
        sample = Sample(message, self.time_ns)
        sample.sequence = self.sequence
        return sample, following


def to_json_string(text: str) -> str:
    """Encode a string as JSON."""
    return orjson.dumps(text).decode()


def _cbor_head(topic: str) -> bytes:
    """Return the start of a CBOR map with entries op, topic and msg, which ends before the value of msg."""
    op, name, msg = (cbor2.dumps(text) for text in ("op", "topic", "msg"))
    return b"\xa3" + op + cbor2.dumps("publish") + name + cbor2.dumps(topic) + msg
