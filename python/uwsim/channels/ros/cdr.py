"""ROS 2 serialisation (CDR) and type descriptions, shared by DDS, recordings and Foxglove."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from typing import Any, Literal, NamedTuple

import numpy as np
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

from uwsim.channels.ros.cdr_layout import writer
from uwsim.channels.ros.message_types import typestore
from uwsim.channels.ros.type_hash import type_hash

Distro = Literal["humble", "jazzy"]
"""A ROS 2 distribution. Our messages have Jazzy's fields; Humble lacks a few of them."""

LITTLE_ENDIAN = b"\x00\x01\x00\x00"  # RTPS 2.5, table 10.3: CDR_LE, no options
LARGE_BYTES = 1 << 16  # from this size on, it pays not to zero bytes that will be overwritten
BIG_ENDIAN = b"\x00\x00\x00\x00"
HEADER = LITTLE_ENDIAN if sys.byteorder == "little" else BIG_ENDIAN


class Schema(NamedTuple):
    """A ROS 2 type description. text: the definition, including all nested types, in the "ros2msg" encoding.

    type_hash: RIHS01 (REP 2016), used to distinguish types since ROS 2 Iron.
    """

    name: str
    text: str
    type_hash: str


@cache
def store_of(distro: Distro) -> Typestore:
    """Return the types of a distribution, plus the types of `typestore` that it lacks."""
    if distro == "jazzy":
        return typestore()
    store, ours = get_typestore(Stores.ROS2_HUMBLE), typestore().fielddefs
    store.register({name: ours[name] for name in ours.keys() - store.fielddefs.keys()})
    return store


@cache
def is_as_in_jazzy(name: str, distro: Distro) -> bool:
    """Return whether a type has the same fields, and thus the same serialised form, in Jazzy and in a distribution."""
    return schema(name, distro).text == schema(name).text


def encode(message: Any, distro: Distro = "jazzy") -> memoryview:
    """Encode a message in CDR, with a four-byte header, zero-padded to a multiple of four bytes as in DDS.

    The returned bytes are read-only. Readers ignore the padding.
    """
    store, size_of, write, at_once = _encoder(message.__msgtype__, distro)
    if at_once is not None and (encoded := at_once(message)) is not None:
        return memoryview(encoded)
    size = len(HEADER) + size_of(0, message, store)
    data = _blank(-(-size // 4) * 4, message)
    data[:4] = HEADER
    write(data[4:size], 0, message, store)
    return data.toreadonly()


@cache
def _encoder(
    name: str, distro: Distro
) -> tuple[Typestore, Callable[..., int], Callable[..., int], Callable[[Any], bytes | None] | None]:
    """Return the types of a distribution, and the functions that give a message's size, write it, and do both at once.

    The last is None for types with sequences.
    """
    store = store_of(distro)
    definition = store.get_msgdef(name)
    write = definition.serialize_cdr_le if sys.byteorder == "little" else definition.serialize_cdr_be
    return store, definition.getsize_cdr, write, writer(name, store, HEADER)


def _blank(size: int, message: Any) -> memoryview:
    """Return a buffer for a message that is zeroed except where a large `data` field will be written.

    All other fields are within `rest` bytes of the buffer's ends, regardless of the position of `data`.
    """
    field = getattr(message, "data", None)
    length = field.nbytes if isinstance(field, np.ndarray) else 0
    if length < LARGE_BYTES:
        return memoryview(bytearray(size))
    data, rest = np.empty(size, np.uint8), size - length
    data[:rest] = data[length:] = 0
    return memoryview(data)  # type: ignore[arg-type]  # an array is a buffer


@cache
def schema(name: str, distro: Distro = "jazzy") -> Schema:
    """Return the description of a type such as "sensor_msgs/msg/LaserScan"."""
    store = store_of(distro)
    return Schema(name, store.generate_msgdef(name, ros_version=2)[0], type_hash(store, name))
