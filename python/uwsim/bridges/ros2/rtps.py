"""The RTPS 2.2 messages that services need: data, heartbeats, acknowledgements and lists of parameters.

Section numbers refer to the OMG's RTPS 2.5 specification.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

DATA, DATA_FRAG, GAP, HEARTBEAT, ACKNACK, INFO_SRC, INFO_DST = 0x15, 0x16, 0x08, 0x07, 0x06, 0x0C, 0x0E  # section 9.4.5
PL_CDR_LE = b"\x00\x03\x00\x00"
LITTLE, INLINE_QOS, HAS_DATA, HAS_KEY = 0x01, 0x02, 0x04, 0x08
SENTINEL, TOPIC_NAME, DEFAULT_UNICAST, METATRAFFIC_UNICAST = 0x01, 0x05, 0x31, 0x32  # section 9.6.3
PARTICIPANT_GUID, ENDPOINT_GUID, KEY_HASH, STATUS_INFO = 0x50, 0x5A, 0x70, 0x71
DISPOSED_AND_UNREGISTERED = b"\0\0\0\3"  # section 9.6.4.9
RELATED_IDENTITIES = (0x83, 0x800F)  # related sample identity, in DDS-RPC and in earlier versions of Fast DDS
FRAGMENT = 60_000
WINDOW = 256  # maximum size of a set of numbers
UNKNOWN = bytes(4)


class Data(NamedTuple):
    """A sample. qos: the parameters of its inline QoS, by number."""

    reader: bytes
    writer: bytes
    number: int
    qos: Mapping[int, bytes]
    payload: bytes


class Heartbeat(NamedTuple):
    """A heartbeat: the range of samples that a writer can send."""

    reader: bytes
    writer: bytes
    first: int
    last: int
    is_final: bool


class Missing(NamedTuple):
    """An acknowledgement of all samples before `base`, and the samples that a reader lacks."""

    reader: bytes
    writer: bytes
    base: int
    numbers: tuple[int, ...]


class Gap(NamedTuple):
    """Samples that a writer will not send."""

    reader: bytes
    writer: bytes
    numbers: tuple[int, ...]


Submessage = Data | Heartbeat | Missing | Gap


class Received(NamedTuple):
    """A submessage and its sender. prefix: the prefix of the sender's GUID."""

    vendor: bytes
    prefix: bytes
    submessage: Submessage


def header(prefix: bytes, vendor: bytes) -> bytes:
    """Return the header of a message. prefix: the prefix of the sender's GUID."""
    return b"RTPS\x02\x02" + vendor + prefix


def to_participant(prefix: bytes) -> bytes:
    """Return the submessage that names the receiver of the submessages after it."""
    return _submessage(INFO_DST, 0, prefix)


def data(reader: bytes, writer: bytes, number: int, payload: bytes, qos: bytes = b"") -> list[bytes]:
    """Return the submessages of a sample: one, or several fragments if it is long. Each needs a separate message."""
    head = reader + writer + _number(number)
    if len(payload) <= FRAGMENT:
        flags = HAS_DATA | (INLINE_QOS if qos else 0)
        return [_submessage(DATA, flags, struct.pack("<HH", 0, 16) + head + qos + payload)]
    found = []
    for k, start in enumerate(range(0, len(payload), FRAGMENT), start=1):
        part = payload[start : start + FRAGMENT]
        body = struct.pack("<HH", 0, 28) + head + struct.pack("<IHHI", k, 1, FRAGMENT, len(payload))
        flags = INLINE_QOS if qos and k == 1 else 0
        found.append(_submessage(DATA_FRAG, flags, body + (qos if flags else b"") + part))
    return found


def gone(reader: bytes, writer: bytes, number: int, guid: bytes) -> bytes:
    """Return the submessage with which a participant leaves, by disposing of the announcement with its GUID as key."""
    qos = parameters([(KEY_HASH, guid), (STATUS_INFO, DISPOSED_AND_UNREGISTERED)])
    body = struct.pack("<HH", 0, 16) + reader + writer + _number(number) + qos
    return _submessage(DATA, INLINE_QOS | HAS_KEY, body + PL_CDR_LE + parameters([(PARTICIPANT_GUID, guid)]))


def heartbeat(reader: bytes, writer: bytes, first: int, last: int, count: int) -> bytes:
    """Return the submessage that announces the available samples and requests an acknowledgement."""
    return _submessage(HEARTBEAT, 0, reader + writer + _number(first) + _number(last) + struct.pack("<i", count))


def missing(reader: bytes, writer: bytes, base: int, numbers: Sequence[int], count: int, more: bool = False) -> bytes:
    """Return an acknowledgement of all samples before `base` that also requests the samples in `numbers`.

    numbers: less than WINDOW beyond `base`. more: whether to request a heartbeat as well.
    """
    bits = max(numbers) - base + 1 if numbers else 0
    words = [0] * -(-bits // 32)
    for number in numbers:
        words[(number - base) // 32] |= 0x8000_0000 >> (number - base) % 32
    body = _number(base) + struct.pack(f"<I{len(words)}I", bits, *words)
    return _submessage(ACKNACK, 0 if numbers or more else 0x02, reader + writer + body + struct.pack("<i", count))


def parameters(values: Sequence[tuple[int, bytes]]) -> bytes:
    """Return a list of parameters that ends with a sentinel."""
    padded = [(number, value + bytes(-len(value) % 4)) for number, value in values]
    return b"".join(struct.pack("<HH", number, len(value)) + value for number, value in padded) + b"\x01\0\0\0"


def text(value: str) -> bytes:
    """Return a string in CDR."""
    encoded = value.encode() + b"\0"
    return struct.pack("<I", len(encoded)) + encoded


def read_parameters(content: bytes, order: str = "<") -> tuple[list[tuple[int, bytes]], int]:
    """Return the parameters at the beginning of `content`, and the length of the list. Raises ValueError."""
    found: list[tuple[int, bytes]] = []
    at = 0
    while True:
        number, length = _unpack(f"{order}HH", content, at)
        at += 4
        if number == SENTINEL:
            return found, at
        found.append((number, content[at : at + length]))
        at += length


def read(packet: bytes, ours: bytes) -> list[Received]:
    """Return a message's submessages for the participant `ours`, with their senders. Raises ValueError."""
    if packet[:4] != b"RTPS" or len(packet) < 20:
        raise ValueError(f"{len(packet)} bytes: no RTPS message")
    return list(_read(packet, ours))


def _read(packet: bytes, ours: bytes) -> Iterator[Received]:
    vendor, prefix = packet[6:8], packet[8:20]
    at, is_for_us = 20, True
    while at + 4 <= len(packet):
        kind, flags = packet[at], packet[at + 1]
        order = "<" if flags & LITTLE else ">"
        (length,) = _unpack(f"{order}H", packet, at + 2)
        body = packet[at + 4 : at + 4 + length] if length else packet[at + 4 :]
        at += 4 + len(body)
        if kind == INFO_SRC and len(body) >= 20:  # participants of one process share messages
            vendor, prefix = body[6:8], body[8:20]
        elif kind == INFO_DST:
            is_for_us = body[:12] in (ours, bytes(12))
        elif is_for_us and (found := _submessage_of(kind, flags, order, body)) is not None:
            yield Received(vendor, prefix, found)


def _submessage_of(kind: int, flags: int, order: str, body: bytes) -> Submessage | None:
    if kind == DATA:
        return _read_data(body, flags, order)
    if kind == HEARTBEAT:
        first, last = _read_number(body, 8, order), _read_number(body, 16, order)
        return Heartbeat(body[:4], body[4:8], first, last, bool(flags & 0x02))
    if kind == ACKNACK:
        return Missing(body[:4], body[4:8], *_read_set(body, 8, order))
    if kind == GAP:
        start, (base, numbers) = _read_number(body, 8, order), _read_set(body, 16, order)
        return Gap(body[:4], body[4:8], (*range(start, min(base, start + WINDOW)), *numbers))
    return None


def _read_data(body: bytes, flags: int, order: str) -> Data:
    (to_qos,) = _unpack(f"{order}H", body, 2)
    at, qos = 4 + to_qos, {}
    if flags & INLINE_QOS:
        found, length = read_parameters(body[at:], order)
        qos, at = dict(found), at + length
    return Data(body[4:8], body[8:12], _read_number(body, 12, order), qos, body[at:])


def _submessage(kind: int, flags: int, body: bytes) -> bytes:
    body += bytes(-len(body) % 4)
    return struct.pack("<BBH", kind, flags | LITTLE, len(body)) + body


def _number(number: int) -> bytes:
    return struct.pack("<iI", number >> 32, number & 0xFFFF_FFFF)


def _read_number(body: bytes, at: int, order: str) -> int:
    high, low = _unpack(f"{order}iI", body, at)
    return int(high << 32 | low)


def _read_set(body: bytes, at: int, order: str) -> tuple[int, tuple[int, ...]]:
    base, (bits,) = _read_number(body, at, order), _unpack(f"{order}I", body, at + 8)
    if bits > WINDOW:
        raise ValueError(f"a set of {bits} numbers: must be {WINDOW} at most")
    words = _unpack(f"{order}{-(-bits // 32)}I", body, at + 12)
    return base, tuple(base + k for k in range(bits) if words[k // 32] & 0x8000_0000 >> k % 32)


def _unpack(form: str, content: bytes, at: int) -> tuple[int, ...]:
    try:
        return struct.unpack_from(form, content, at)
    except struct.error as error:
        raise ValueError(f"an RTPS message ends too early: {error}") from None
