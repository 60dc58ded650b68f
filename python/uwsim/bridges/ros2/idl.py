"""ROS types as Cyclone DDS classes, generated on demand."""

from __future__ import annotations

from functools import cache
from typing import Any

from cyclonedds.idl import IdlStruct, make_idl_struct
from cyclonedds.idl import types as idl

from uwsim.channels.ros.cdr import Distro, store_of
from uwsim.channels.ros.message_types import Kind, kind_of

PRIMITIVES: dict[str, Any] = {
    "bool": bool, "byte": idl.uint8, "octet": idl.uint8, "char": idl.uint8, "string": str, "wstring": str,
    **{name: getattr(idl, name) for name in (
        "uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float32", "float64",
    )},
}  # fmt: skip


@cache
def idl_type(name: str, distro: Distro) -> type[IdlStruct]:
    """Return the Cyclone DDS class for a ROS type; "sensor_msgs/msg/Imu" is sensor_msgs::msg::dds_::Imu_ in DDS.

    Cyclone DDS checks all messages against this class, even those that are read and written as bytes.
    """
    package, group, short = name.split("/")
    definition = store_of(distro).fielddefs[name][1]
    fields = {field: _field(kind_of(description), distro) for field, description in definition}
    made: type[IdlStruct] = make_idl_struct(f"{short}_", f"{package}.{group}.dds_.{short}_", fields)
    return made


def _field(kind: Kind, distro: Distro) -> Any:
    one = idl_type(kind.base, distro) if kind.is_message else PRIMITIVES[kind.base]
    if kind.length is None:
        return idl.bounded_str[kind.limit] if kind.base == "string" and kind.limit else one
    if kind.length:
        return idl.array[one, kind.length]
    return idl.sequence[one, kind.limit] if kind.limit else idl.sequence[one]
