"""Messages of Blue Robotics' ping protocol as bytes, with the names of its documentation.

A message is "BR", the payload's length, its number, the devices that send and receive it, the payload, and the sum of
all bytes before, little-endian (docs.bluerobotics.com/ping-protocol).
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

START = b"BR"
HEADER, CHECKSUM = struct.Struct("<2sHHBB"), struct.Struct("<H")
READ_MAX = 64
"""The longest payload that is read: the longest command has 16 bytes."""
LONGEST = HEADER.size + READ_MAX + CHECKSUM.size

ACK, NACK, DEVICE_INFORMATION, PROTOCOL_VERSION, GENERAL_REQUEST, SET_DEVICE_ID = 1, 2, 4, 5, 6, 100
_SETTINGS = {
    1002: ("I", "speed_of_sound"), 1003: ("B", "mode_auto"), 1004: ("H", "ping_interval"), 1005: ("B", "gain_setting"),
    1006: ("B", "ping_enabled"),
}  # fmt: skip
_ECHO = "distance confidence transmit_duration ping_number scan_start scan_length gain_setting"
_TRANSMIT = "transmit_duration sample_period transmit_frequency"
_SECTOR = "start_angle stop_angle num_steps delay"
LAYOUTS: Mapping[int, tuple[str, str]] = {
    ACK: ("H", "acked_id"), NACK: ("H", "nacked_id nack_message"), GENERAL_REQUEST: ("H", "requested_id"),
    DEVICE_INFORMATION: (
        "6B",
        "device_type device_revision firmware_version_major firmware_version_minor firmware_version_patch reserved",
    ),
    PROTOCOL_VERSION: ("4B", "version_major version_minor version_patch reserved"),
    SET_DEVICE_ID: ("B", "device_id"),
    # Ping1D
    1000: ("B", "device_id"), 1001: ("II", "scan_start scan_length"), **_SETTINGS,
    1200: ("BBHH", "device_type device_model firmware_version_major firmware_version_minor"),
    1201: ("B", "device_id"), 1202: ("H", "voltage_5"), 1203: ("I", "speed_of_sound"),
    1204: ("II", "scan_start scan_length"), 1205: ("B", "mode_auto"), 1206: ("H", "ping_interval"),
    1207: ("I", "gain_setting"), 1208: ("H", "transmit_duration"),
    1210: ("4HBB", "firmware_version_major firmware_version_minor voltage_5 ping_interval gain_setting mode_auto"),
    1211: ("IB", "distance confidence"), 1212: ("IHHIIII", _ECHO), 1213: ("H", "processor_temperature"),
    1214: ("H", "pcb_temperature"), 1215: ("B", "ping_enabled"),
    1300: ("IHHIIIIH", f"{_ECHO} profile_data_length profile_data"),
    1400: ("H", "id"), 1401: ("H", "id"),
    # Ping360
    2000: ("BB", "id reserved"),
    2300: ("BB6H", f"mode gain_setting angle {_TRANSMIT} number_of_samples data_length data"),
    2301: (
        "BB6HBBHH",
        f"mode gain_setting angle {_TRANSMIT} {_SECTOR} number_of_samples data_length data",
    ),
    2600: ("BB", "bootloader reserved"),
    2601: ("BB5HBB", f"mode gain_setting angle {_TRANSMIT} number_of_samples transmit reserved"),
    2602: ("BB6HBB", f"mode gain_setting {_TRANSMIT} number_of_samples {_SECTOR}"),
    2903: ("", ""),
}  # fmt: skip
"""The payload of each message: its format, as in `struct`, and its fields. TAILED end with a field of bytes."""
TAILED = (NACK, 1300, 2300, 2301)


class Message(NamedTuple):
    """A message that was received. payload: its bytes. source: the device that sent it."""

    number: int
    payload: bytes
    source: int

    @property
    def values(self) -> dict[str, Any]:
        """The fields by name. Raises ValueError for an unknown message, or a payload of another length."""
        if self.number not in LAYOUTS:
            raise ValueError("unknown message")
        form, names = LAYOUTS[self.number]
        if len(self.payload) != struct.calcsize(f"<{form}"):
            raise ValueError(f"{len(self.payload)} bytes: must be {struct.calcsize(f'<{form}')}")
        return dict(zip(names.split(), struct.unpack(f"<{form}", self.payload), strict=True))


def encoded(number: int, values: Mapping[str, Any], *, source: int, to: int = 0) -> bytes:
    """Return a message as bytes. values: its fields by name."""
    form, names = LAYOUTS[number]
    fields = [values[name] for name in names.split()]
    tail = bytes(fields.pop()) if number in TAILED else b""
    payload = struct.pack(f"<{form}", *fields) + tail
    data = HEADER.pack(START, len(payload), number, source, to) + payload
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
