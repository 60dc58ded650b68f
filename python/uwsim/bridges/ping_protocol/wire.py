"""Messages of Blue Robotics' ping protocol (docs.bluerobotics.com/ping-protocol), as the maker's library defines them.

The bytes are made and found here: the library makes no `nack`, and its parser prints what strangers send, and waits for
as many bytes as they state.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from brping.definitions import payload_dict_common, payload_dict_ping1d, payload_dict_ping360

START = b"BR"
HEADER, CHECKSUM = struct.Struct("<2sHHBB"), struct.Struct("<H")
READ_MAX = 64
"""The longest payload that is read: the longest command has 16 bytes."""
MESSAGES: Mapping[int, Mapping[str, Any]] = {**payload_dict_common, **payload_dict_ping1d, **payload_dict_ping360}
"""The messages of both devices: of all of them in one table, other devices' would have some of the same numbers."""


class Message(NamedTuple):
    """A message that was received. payload: its bytes. source: the device that sent it."""

    number: int
    payload: bytes
    source: int

    @property
    def values(self) -> dict[str, Any]:
        """The fields by name. Raises ValueError for an unknown message, or a payload of another length."""
        if self.number not in MESSAGES:
            raise ValueError("unknown message")
        layout = MESSAGES[self.number]
        if len(self.payload) != layout["payload_length"]:
            raise ValueError(f"{len(self.payload)} bytes: must be {layout['payload_length']}")
        return dict(zip(layout["field_names"], struct.unpack(f"<{layout['format']}", self.payload), strict=True))


def encoded(number: int, values: Mapping[str, Any], *, source: int) -> bytes:
    """Return a message as bytes. values: its fields by name."""
    layout = MESSAGES[number]
    fields = [values[name] for name in layout["field_names"]]
    tail = bytes(fields.pop()) if len(fields) > len(layout["format"]) else b""
    payload = struct.pack(f"<{layout['format']}", *fields) + tail
    data = HEADER.pack(START, len(payload), number, source, 0) + payload
    return data + CHECKSUM.pack(sum(data) & 0xFFFF)


class Reader:
    """Finds messages in a stream of bytes. What is not one is left out: wrong checksums, and payloads over READ_MAX."""

    def __init__(self) -> None:
        self._data = bytearray()

    def read(self, data: bytes) -> Iterator[Message]:
        """Yield the messages that these bytes complete."""
        self._data += data
        at = 0
        while (at := self._data.find(START, at)) >= 0 and len(self._data) - at >= HEADER.size:
            _, length, number, source, _ = HEADER.unpack_from(self._data, at)
            end = at + HEADER.size + length
            if length <= READ_MAX and len(self._data) < end + CHECKSUM.size:
                break
            is_whole = (
                length <= READ_MAX and CHECKSUM.unpack_from(self._data, end)[0] == sum(self._data[at:end]) & 0xFFFF
            )
            if is_whole:
                yield Message(number, bytes(self._data[at + HEADER.size : end]), source)
            at = end + CHECKSUM.size if is_whole else at + len(START)
        del self._data[: at if at >= 0 else max(0, len(self._data) - 1)]
