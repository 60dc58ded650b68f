"""A message on its way to subscribers: encoded when the first of them needs it, once for each encoding."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Callable
from typing import Any, Literal

import cbor2
import orjson
from PIL import Image

from uwsim.channels.messages import Ros, to_bytes, to_plain

Compression = Literal["none", "cbor", "cbor-raw", "png"]
Frame = str | bytes
"""A frame of a WebSocket: str as text, bytes as binary."""
JSON_OPTIONS = orjson.OPT_SERIALIZE_NUMPY


def to_json(operation: dict[str, Any]) -> str:
    """Encode an operation as JSON. Raises ValueError if a value has no place in JSON."""
    try:
        return orjson.dumps(operation, default=_plain, option=JSON_OPTIONS).decode()
    except TypeError as error:
        raise ValueError(f"cannot be written as JSON: {error}") from None


def _plain(value: Any) -> Any:
    if isinstance(value, bytes):  # of a client's CBOR
        return base64.b64encode(value).decode("ascii")
    if hasattr(value, "tolist"):  # an array that orjson does not write, such as a big-endian one
        return value.tolist()
    raise TypeError(f"Type is not JSON serializable: {type(value).__name__}")


def to_png(text: str) -> str:
    """Hide an operation's JSON in the pixels of a PNG, as rosbridge's compression "png" does."""
    data = text.encode()
    width = max(1, math.isqrt(len(data) // 3))
    height = math.ceil(len(data) / 3 / width)
    pixels = data.ljust(3 * width * height, b"\n")
    buffer = io.BytesIO()
    Image.frombytes("RGB", (width, height), pixels).save(buffer, "PNG", compress_level=1)
    return to_json({"op": "png", "data": base64.b64encode(buffer.getvalue()).decode("ascii")})


class Sample:
    """One message of a topic, and the frames that were made of it. time_ns: when it was received, for cbor-raw."""

    __slots__ = ("_frames", "message", "time_ns")
    builds_up = False

    def __init__(self, message: Any, time_ns: int = 0) -> None:
        self.message = message
        self.time_ns = time_ns
        self._frames: dict[Any, Any] = {}

    @property
    def is_taken(self) -> bool:
        """Whether anybody was ready for it."""
        return bool(self._frames)

    def after(self, cursor: Any) -> tuple[Sample, Any]:
        """Return what a subscriber is to get who has got everything up to a cursor, and its next cursor."""
        return self, None

    def frame(self, topic: str, ros: Ros, compression: Compression) -> Frame:
        """Return the operation "publish" under the topic's name as the subscriber wrote it."""
        key = (topic, ros, compression)
        frame: Frame | None = self._frames.get(key)
        if frame is None:
            frame = self._frames[key] = self._encode(topic, ros, compression)
        return frame

    def _encode(self, topic: str, ros: Ros, compression: Compression) -> Frame:
        if compression in ("cbor", "cbor-raw"):
            return b"".join((_cbor_head(topic), self._body(ros, compression)))
        text = f'{{"op":"publish","topic":{to_json_string(topic)},"msg":{self._body(ros, "none")}}}'
        return to_png(text) if compression == "png" else text

    def _body(self, ros: Ros, compression: Compression) -> Any:
        """Encode the message alone: topics have several spellings, such as with a slash and without."""
        key = (ros, compression)
        body = self._frames.get(key)
        if body is None:
            body = self._frames[key] = self._encode_body(ros, compression)
        return body

    def _encode_body(self, ros: Ros, compression: Compression) -> Any:
        if compression == "none":
            return orjson.dumps(to_plain(self.message, ros), option=JSON_OPTIONS).decode()
        if compression == "cbor":
            return cbor2.dumps(to_plain(self.message, ros, "cbor"))
        secs, nsecs = divmod(self.time_ns, 10**9)
        return cbor2.dumps({"secs": secs, "nsecs": nsecs, "bytes": to_bytes(self.message, ros)})


class Growing(Sample):
    """News of a topic whose messages build on each other: each subscriber gets one with all that it does not have.

    catch_up: returns the message for a cursor (None: has nothing), and the next cursor.
    """

    __slots__ = ("_catch_up",)
    builds_up = True

    def __init__(self, catch_up: Callable[[Any], tuple[Any, Any]], time_ns: int = 0) -> None:
        super().__init__(None, time_ns)
        self._catch_up = catch_up

    def after(self, cursor: Any) -> tuple[Sample, Any]:
        """Put together all since the cursor."""
        message, following = self._catch_up(cursor)
        return Sample(message, self.time_ns), following


def to_json_string(text: str) -> str:
    """Quote a string."""
    return orjson.dumps(text).decode()


def _cbor_head(topic: str) -> bytes:
    """Begin a map of three: op, topic, and msg, whose value follows."""
    op, name, msg = (cbor2.dumps(text) for text in ("op", "topic", "msg"))
    return b"\xa3" + op + cbor2.dumps("publish") + name + cbor2.dumps(topic) + msg
