"""Message classes for rospy that contain only bytes, which uwsim encodes and decodes itself."""

from __future__ import annotations

import importlib
from functools import cache
from typing import Any

import numpy as np

from uwsim.channels.ros.message_types import TIMES, fields, message_text, ros1_typestore, spelled
from uwsim.channels.ros.messages import from_plain


@cache
def raw_type(name: str) -> type:
    """Return a class for a type such as "sensor_msgs/msg/LaserScan", with the name, checksum and definition for rospy.

    Its instances carry `data`, the message as serialised for ROS 1, so the type need not be installed on this side.
    """
    genpy = importlib.import_module("genpy")
    _, checksum = ros1_typestore().generate_msgdef(name, ros_version=1)

    class Raw(genpy.Message):  # type: ignore[misc, name-defined]
        _type = spelled(name, 1)
        _md5sum = checksum
        _full_text = message_text(name, 1)
        _has_header = False  # otherwise rospy would insert a sequence number
        __slots__ = ("data",)
        _slot_types = ("uint8[]",)

        def __init__(self, data: bytes = b"") -> None:
            self.data = data

        def serialize(self, buffer: Any) -> None:
            buffer.write(self.data)

        def deserialize(self, data: bytes) -> Any:
            self.data = bytes(data)
            return self

    return Raw


def read_message(data: bytes, name: str) -> Any:
    """Deserialise a message of a type from ROS 1's format. Raises ValueError."""
    try:
        received = ros1_typestore().deserialize_ros1(data, name)
    except Exception as error:  # generated code may raise anything for damaged bytes
        raise ValueError(f"{name}: {len(data)} bytes that are not a valid serialisation of it ({error})") from None
    return from_plain(name, _plain(received, name))


def _plain(message: Any, name: str) -> dict[str, Any]:
    """Convert a message of a rosbags ROS 1 class to plain values."""
    found: dict[str, Any] = {}
    definitions = ros1_typestore().fielddefs[name][1]
    kinds = {field.name.lower(): field.kind for field in fields(name, 1)}
    for attribute, _ in definitions:
        value = getattr(message, attribute)
        kind = kinds.get(attribute.lower())
        if name in TIMES:
            found[attribute] = int(value)
        elif kind is not None and kind.is_message:
            one = kind.length is None
            found[attribute] = _plain(value, kind.base) if one else [_plain(part, kind.base) for part in value]
        else:
            found[attribute] = value.tolist() if isinstance(value, np.ndarray) else value
    return found
