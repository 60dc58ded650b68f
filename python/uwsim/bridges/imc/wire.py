"""IMC's messages as bytes: packets of LSTS's Inter-Module Communication protocol, from a connection or a datagram.

A packet is a header of 20 bytes, the message's fields, and a CRC-16-IBM (polynomial 0x8005, reflected) of both. The
header: synchronization 0xFE54, the message's number and the size of its fields (uint16 each), the time [s since 1970]
(float64), source system (uint16) and entity (uint8), destination system (uint16) and entity (uint8). All numbers have
the byte order of their sender, which the synchronization reveals; here packets are written little-endian. A text or raw
data is its length (uint16) and its bytes; an inline message its number (uint16; 65535: none) and its fields; a list of
messages its length (uint16) and inline messages.

Source: LSTS, "IMC: Inter-Module Communication Protocol", version 5.4 (IMC.xml); Martins et al. 2009, "IMC: A
communication protocol for networked vehicles and sensors", OCEANS 2009.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from uwsim.bridges.imc.crc import after_zeros, crc16, sums

NO_SYSTEM, UNKNOWN_ENTITY = 0xFFFF, 0xFF
"""The system that is none in particular, and the entity: as a source, the receiver puts its own; or for all."""
SYNC, SWAPPED = b"\x54\xfe", b"\xfe\x54"
"""The first bytes of a packet, of a sender that is little-endian and of one that is not."""
GARBAGE_BYTES_MAX = 1 << 17
"""More bytes than these without a packet, which has at most 65557, are no IMC."""
DEPTH_MAX = 16
"""Levels of inline messages."""

Sent = tuple[str, str, dict[str, Any]]
"""The label of the entity that sends, the name of the message and its fields."""
Format = tuple[tuple[str, str], ...]
"""Fields: name, and the kind as in `struct`; "s": a text; "r": raw data; "m": a message or None; "l": messages."""


def fields(text: str) -> Format:
    """Return a format from "kind name ...", such as "d lat d lon f height"."""
    words = text.split()
    return tuple(zip(words[1::2], words[::2], strict=True))


_STATE = "d lat d lon f height f x f y f z f phi f theta f psi f u f v f w"
FORMATS: dict[str, tuple[int, Format]] = {
    "EntityState": (1, fields("B state B flags s description")),
    "EntityList": (5, fields("B op s list")),
    "SimulatedState": (50, fields(f"{_STATE} f p f q f r f svx f svy f svz")),
    "Heartbeat": (150, ()),
    "Announce": (151, fields("s sys_name B sys_type H owner d lat d lon f height s services")),
    "Rpm": (250, fields("h value")),
    "GpsFix": (253, fields(
        "H validity B type H utc_year B utc_month B utc_day f utc_time d lat d lon f height B satellites f cog f sog "
        "f hdop f vdop f hacc f vacc"
    )),
    "EulerAngles": (254, fields("d time d phi d theta d psi d psi_magnetic")),
    "AngularVelocity": (256, fields("d time d x d y d z")),
    "Acceleration": (257, fields("d time d x d y d z")),
    "GroundVelocity": (259, fields("B validity d x d y d z")),
    "WaterVelocity": (260, fields("B validity d x d y d z")),
    "Distance": (262, fields("B validity l location l beam_config f value")),
    "Temperature": (263, fields("f value")),
    "Pressure": (264, fields("d value")),
    "Depth": (265, fields("f value")),
    "SonarData": (276, fields(
        "B type I frequency H min_range H max_range B bits_per_point f scale_factor l beam_config r data"
    )),
    "ServoPosition": (281, fields("B id f value")),
    "DeviceState": (282, fields("f x f y f z f phi f theta f psi")),
    "BeamConfig": (283, fields("f beam_width f beam_height")),
    "SetThrusterActuation": (301, fields("B id f value")),
    "SetServoPosition": (302, fields("B id f value")),
    "EstimatedState": (350, fields(f"{_STATE} f vx f vy f vz f p f q f r f depth f alt")),
}  # fmt: skip
"""The messages that are read and written, with their numbers; others are read without their fields."""

_NAMES: dict[int, str] = {number: name for name, (number, _) in FORMATS.items()}
_HEADERS = {byte_order: struct.Struct(byte_order + "HHHdHBHB") for byte_order in "<>"}
_HEADER_BYTES, _CRC_BYTES = 20, 2
_ANY_SYNC = re.compile(re.escape(SYNC) + b"|" + re.escape(SWAPPED))


def define(name: str, number: int, of: Format) -> None:
    """Let a further message be read and written."""
    FORMATS[name], _NAMES[number] = (number, of), name


class ImcError(ValueError):
    """Raised for bytes that are no packet, and for fields that do not fit a message."""


class Message(NamedTuple):
    """A message. name: of FORMATS, or its number as a text. content: its fields by name. time_s: since 1970 [s]."""

    name: str
    content: Mapping[str, Any]
    source: int = NO_SYSTEM
    entity: int = UNKNOWN_ENTITY
    time_s: float = 0.0
    destination: int = NO_SYSTEM
    to_entity: int = UNKNOWN_ENTITY


def encoded(message: Message) -> bytes:
    """Return the packet of a message. Missing fields are 0 or empty. Raises ImcError."""
    number, body = _written(message.name, message.content)
    if len(body) > 0xFFFF:
        raise ImcError(f"{message.name}: {len(body)} bytes of fields: must be at most 65535")
    try:
        head = _HEADERS["<"].pack(
            0xFE54, number, len(body), message.time_s, message.source, message.entity, message.destination,
            message.to_entity,
        )  # fmt: skip
    except struct.error as error:
        raise ImcError(f"{message.name}: {error}") from None
    packet = head + body
    return packet + struct.pack("<H", crc16(packet))


def _written(name: str, content: Mapping[str, Any]) -> tuple[int, bytes]:
    if name not in FORMATS:
        raise ImcError(f"message '{name[:40]}': must be one of {', '.join(FORMATS)}")
    number, of = FORMATS[name]
    if unknown := content.keys() - {each for each, _ in of}:
        raise ImcError(f"{name}: has no field {', '.join(sorted(unknown))}")
    parts = []
    for field, kind in of:
        if kind in "sr":
            value = content.get(field, b"")
            data = value.encode("utf-8", "surrogateescape") if isinstance(value, str) else bytes(value)
            if len(data) > 0xFFFF:
                raise ImcError(f"{name}.{field}: {len(data)} bytes: must be at most 65535")
            parts.append(struct.pack("<H", len(data)) + data)
        elif kind == "m":
            inline = content.get(field)
            parts.append(_inline(inline))
        elif kind == "l":
            inlines = content.get(field, ())
            parts.append(struct.pack("<H", len(inlines)) + b"".join(map(_inline, inlines)))
        else:
            try:
                parts.append(struct.pack("<" + kind, content.get(field, 0)))
            except (struct.error, OverflowError) as error:
                raise ImcError(f"{name}.{field} = {str(content.get(field))[:40]}: {error}") from None
    return number, b"".join(parts)


def _inline(inline: tuple[str, Mapping[str, Any]] | None) -> bytes:
    if inline is None:
        return struct.pack("<H", NO_SYSTEM)
    number, body = _written(*inline)
    return struct.pack("<H", number) + body


def decoded(packet: bytes) -> Message:
    """Return the message of a whole packet, as of a datagram. Raises ImcError."""
    if len(packet) < _HEADER_BYTES:
        raise ImcError(f"a packet of {len(packet)} bytes: must have at least {_HEADER_BYTES}")
    order = _order(packet)
    end = _HEADER_BYTES + _HEADERS[order].unpack_from(packet)[2]
    if len(packet) != end + _CRC_BYTES:
        raise ImcError(f"a packet of {len(packet)} bytes: must have {end + _CRC_BYTES}")
    if struct.unpack_from(order + "H", packet, end)[0] != crc16(packet[:end]):
        raise ImcError(f"a packet of {len(packet)} bytes: its check sum is wrong")
    return _message(packet[:end], order)


def _message(packet: bytes, order: str) -> Message:
    """Return the message of a packet without its check sum. Raises ImcError."""
    _, number, _, time_s, source, entity, destination, to_entity = _HEADERS[order].unpack_from(packet)
    name = _NAMES.get(number)
    content: dict[str, Any] = {}
    if name is not None:
        content, at = _Read(packet, order).message(name, _HEADER_BYTES, 0)
        if at != len(packet):
            raise ImcError(f"{name}: {len(packet) - at} bytes are left over")
    return Message(name or str(number), content, source, entity, time_s, destination, to_entity)


def _order(packet: bytes) -> str:
    if packet[:2] not in (SYNC, SWAPPED):
        raise ImcError(f"a packet of {len(packet)} bytes: must begin with 0xFE54")
    return "<" if packet[:2] == SYNC else ">"


class _Read:
    """The fields of a packet. Methods return what they read and where it ends. Raise ImcError."""

    def __init__(self, packet: bytes, order: str) -> None:
        self._packet, self._order = packet, order

    def message(self, name: str, at: int, depth: int) -> tuple[dict[str, Any], int]:
        found: dict[str, Any] = {}
        for field, kind in FORMATS[name][1]:
            if kind in "sr":
                length, at = self._number("H", at)
                data = self._packet[at : at + length]
                if len(data) != length:
                    raise ImcError(f"{name}.{field}: {length} bytes at byte {at} of {len(self._packet)}")
                at += length
                found[field] = data if kind == "r" else data.decode("utf-8", "surrogateescape")
            elif kind == "m":
                found[field], at = self._inline(at, depth)
            elif kind == "l":
                count, at = self._number("H", at)
                found[field] = []
                for _ in range(count):
                    each, at = self._inline(at, depth)
                    found[field].append(each)
            else:
                found[field], at = self._number(kind, at)
        return found, at

    def _inline(self, at: int, depth: int) -> tuple[tuple[str, dict[str, Any]] | None, int]:
        number, at = self._number("H", at)
        if number == NO_SYSTEM:
            return None, at
        name = _NAMES.get(number)
        if name is None or depth >= DEPTH_MAX:
            raise ImcError(f"an inline message {number} at byte {at}: {'unknown' if name is None else 'too deep'}")
        content, at = self.message(name, at, depth + 1)
        return (name, content), at

    def _number(self, kind: str, at: int) -> tuple[Any, int]:
        try:
            (value,) = struct.unpack_from(self._order + kind, self._packet, at)
        except struct.error:
            raise ImcError(f"a number at byte {at} of {len(self._packet)}") from None
        return value, at + struct.calcsize("<" + kind)


class PacketReader:
    """Converts the bytes of a connection to messages, however the bytes were divided; resumes after damaged ones.

    Any two bytes may look like the beginning of a packet. The work is nevertheless proportional to the bytes: the check
    sum of each stretch follows from those of all bytes up to its beginning and up to its end.
    """

    def __init__(self) -> None:
        self._kept = bytearray()
        self._sums = [0]  # of the first k bytes kept, after what was before them
        self.skipped = 0

    def read(self, data: bytes) -> Iterator[Message]:
        """Yield the messages of all packets that are now complete. Raises ImcError for too many bytes that are none."""
        self._kept += data
        self._sums += sums(data, self._sums[-1])
        begin = 0
        try:
            while len(self._kept) - begin >= _HEADER_BYTES:
                sync = _ANY_SYNC.search(self._kept, begin)
                start = len(self._kept) - 1 if sync is None else sync.start()
                if start != begin:
                    begin = self._skipped_to(start, begin)
                    continue
                order = _order(bytes(self._kept[begin : begin + 2]))
                end = begin + _HEADER_BYTES + struct.unpack_from(order + "H", self._kept, begin + 4)[0]
                if len(self._kept) < end + _CRC_BYTES:
                    return
                crc = self._sums[end] ^ after_zeros(self._sums[begin], end - begin)
                if struct.unpack_from(order + "H", self._kept, end)[0] != crc:
                    begin = self._skipped_to(begin + 1, begin)
                    continue
                try:
                    message = _message(bytes(self._kept[begin:end]), order)
                except ImcError:  # of a packet that arrived as it was sent, so that no other begins within it
                    begin = self._skipped_to(end + _CRC_BYTES, begin)
                    continue
                begin, self.skipped = end + _CRC_BYTES, 0
                yield message
        finally:
            del self._kept[:begin], self._sums[:begin]

    def _skipped_to(self, end: int, begin: int) -> int:
        self.skipped += end - begin
        if self.skipped > GARBAGE_BYTES_MAX:
            raise ImcError(f"{self.skipped} bytes without a packet: is it IMC?")
        return end
