"""MOOS's messages as bytes: packets of notifications between a MOOSDB and its clients.

A packet is its length (int32, with itself), the number of messages (int32), a byte 0, and the messages. A message is
its length (int32, with itself), a number (int32), its kind and the kind of its value (a byte each), source, further
source, community and name (texts), time, value and further value (float64) and the value as a text. A text is its
length (int32) and its bytes. All numbers are little-endian.

Source: MOOS core, release of July 2024 (MOOSMsg.cpp, MOOSCommPkt.cpp; Newman 2008, "MOOS - Mission Orientated Operating
Suite"), whose clients and databases all speak this version since 2010.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from typing import NamedTuple

PROTOCOL = b"ELKS CAN'T DANCE 2/8/10".ljust(32, b"\0")
"""The first bytes of a client: the protocol's name."""
NOTIFY, REGISTER, DATA, WELCOME, POISON, TIMING, NOTHING = "N", "R", "i", "W", "K", "T", "."
"""The kinds of messages that matter here. POISON: a refusal."""
PACKET_BYTES_MAX = 1 << 24
"""Larger packets are refused. A MOOSDB may send all that was published since the last one."""

_HEAD = struct.Struct("<iiB")
_START = struct.Struct("<iicc")
_NUMBERS = struct.Struct("<ddd")
_LENGTH = struct.Struct("<i")


class MoosError(ValueError):
    """Raised for bytes that are no packet, and for a refusal by the MOOSDB."""


class Message(NamedTuple):
    """A message. kind: see NOTIFY. value: a number, or a text as bytes. time_s: MOOS time [s]. further: a number."""

    kind: str
    name: str
    value: float | bytes
    time_s: float = 0.0
    source: str = ""
    community: str = ""
    further: float = -1.0


def encoded(messages: Iterable[Message]) -> bytes:
    """Return a packet of messages."""
    parts = [_message(each) for each in messages]
    return _HEAD.pack(_HEAD.size + sum(map(len, parts)), len(parts), 0) + b"".join(parts)


def _message(message: Message) -> bytes:
    is_text = isinstance(message.value, bytes)
    texts = (_bytes(message.source), b"", _bytes(message.community), _bytes(message.name))
    value = -1.0 if isinstance(message.value, bytes) else message.value
    text = message.value if isinstance(message.value, bytes) else b""
    body = b"".join((
        *(_LENGTH.pack(len(each)) + each for each in texts),
        _NUMBERS.pack(message.time_s, value, message.further), _LENGTH.pack(len(text)), text,
    ))  # fmt: skip
    start = _START.pack(_START.size + len(body), -1, message.kind.encode("latin-1"), b"S" if is_text else b"D")
    return start + body


class PacketReader:
    """Converts the bytes of a connection to messages, however the bytes were divided."""

    def __init__(self) -> None:
        self._kept = bytearray()

    def read(self, data: bytes) -> Iterator[Message]:
        """Yield the messages of all packets that are now complete. Raises MoosError."""
        self._kept += data
        while len(self._kept) >= _LENGTH.size:
            (length,) = _LENGTH.unpack_from(self._kept)
            if not _HEAD.size <= length <= PACKET_BYTES_MAX:
                raise MoosError(f"a packet of {length} bytes: must have {_HEAD.size} to {PACKET_BYTES_MAX}")
            if len(self._kept) < length:
                return
            packet = bytes(self._kept[:length])
            del self._kept[:length]
            yield from decoded(packet)


def decoded(packet: bytes) -> list[Message]:
    """Return the messages of a whole packet. Raises MoosError."""
    try:
        length, count, compressed = _HEAD.unpack_from(packet)
        if length != len(packet) or compressed or count < 0:
            raise MoosError(f"a packet of {len(packet)} bytes with {count} messages: its head is damaged")
        found, at = [], _HEAD.size
        for _ in range(count):
            message, after = _read_message(packet, at)
            found.append(message)
            at = after
    except struct.error as error:
        raise MoosError(f"a packet of {len(packet)} bytes: {error}") from None
    if at != len(packet):
        raise MoosError(f"a packet of {len(packet)} bytes: {len(packet) - at} bytes are left over")
    return found


def _read_message(packet: bytes, start: int) -> tuple[Message, int]:
    length, _, kind, of_value = _START.unpack_from(packet, start)
    at, end = start + _START.size, start + length
    if not at <= end <= len(packet):
        raise MoosError(f"a message of {length} bytes at byte {start} of a packet of {len(packet)}")

    def text() -> bytes:
        nonlocal at
        (size,) = _LENGTH.unpack_from(packet, at)
        at += _LENGTH.size
        if not 0 <= size <= end - at:
            raise MoosError(f"a text of {size} bytes at byte {at} of a packet of {len(packet)}")
        at += size
        return packet[at - size : at]

    source, _, community, name = (text() for _ in range(4))
    time_s, value, further = _NUMBERS.unpack_from(packet, at)
    at += _NUMBERS.size
    written = text()
    if at != end:
        raise MoosError(f"a message of {length} bytes at byte {start}: {end - at} bytes are left over")
    return Message(
        kind.decode("latin-1"), _text(name), value if of_value == b"D" else written, time_s, _text(source),
        _text(community), further,
    ), end  # fmt: skip


def _bytes(text: str) -> bytes:
    return text.encode("utf-8", "surrogateescape")


def _text(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")
