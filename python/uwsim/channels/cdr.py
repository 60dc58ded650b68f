"""ROS 2's own bytes (CDR) and what describes them: for DDS, recordings and Foxglove, which all carry the same."""

from __future__ import annotations

import sys
from functools import cache
from typing import Any, NamedTuple

from uwsim.channels.message_types import message_text, typestore

LITTLE_ENDIAN = b"\x00\x01\x00\x00"  # RTPS 2.5, table 10.3: CDR_LE, no options
BIG_ENDIAN = b"\x00\x00\x00\x00"


class Schema(NamedTuple):
    """A type as ROS 2 describes it. text: its definition with all that it contains, encoding "ros2msg".

    type_hash: RIHS01 (REP 2016), by which ROS 2 from Iron on tells types apart.
    """

    name: str
    text: str
    type_hash: str


def encode(message: Any) -> memoryview:
    """Return a message in CDR, with its header of four bytes, padded with zeros to a multiple of four as DDS has it.

    The bytes are read-only. Readers ignore the padding.
    """
    store, name = typestore(), message.__msgtype__
    definition = store.get_msgdef(name)
    size = len(LITTLE_ENDIAN) + definition.getsize_cdr(0, message, store)
    data = memoryview(bytearray(-(-size // 4) * 4))
    if sys.byteorder == "little":
        data[:4], write = LITTLE_ENDIAN, definition.serialize_cdr_le
    else:
        data[:4], write = BIG_ENDIAN, definition.serialize_cdr_be
    write(data[4:size], 0, message, store)
    return data.toreadonly()


@cache
def schema(name: str) -> Schema:
    """Return the description of a type, "sensor_msgs/msg/LaserScan"."""
    return Schema(name, message_text(name, 2), typestore().hash_rihs01(name))
