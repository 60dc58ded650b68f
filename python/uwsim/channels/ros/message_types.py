"""The ROS message types in use: names, fields and classes, from the typestores of `rosbags`.

For every client, a message is an instance of `typestore().types[name]`, a ROS 2 Jazzy class, and type names are spelled
as in Jazzy ("sensor_msgs/msg/LaserScan"). `fields(name, ros)` returns the fields of a type in the spelling of ROS 1
(Noetic: a header has `seq`, times are `secs` and `nsecs`, camera matrices are `K`) or ROS 2.
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any, Literal, NamedTuple

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from uwsim.channels.ros.own_types import OWN_TYPES

Ros = Literal[1, 2]
"""The generation of ROS that a client uses."""

ADDED = {
    **OWN_TYPES,
    # https://github.com/OctoMap/octomap_msgs
    "octomap_msgs/msg/Octomap": "std_msgs/Header header\nbool binary\nstring id\nfloat64 resolution\nint8[] data\n",
    "octomap_msgs/msg/OctomapWithPose": (
        "std_msgs/Header header\ngeometry_msgs/Pose origin\noctomap_msgs/Octomap octomap\n"
    ),
    # From the published simulator, for `decodedDepth` and `rovParameters`
    "misc/msg/floatarray": "float32[] data\n",
    # https://github.com/RobotWebTools/tf2_web_republisher, for tf clients of rosbridge
    "tf2_web_republisher/msg/TFArray": "geometry_msgs/TransformStamped[] transforms\n",
    "tf2_web_republisher/msg/TFSubscriptionGoal": (
        "string[] source_frames\nstring target_frame\nfloat32 angular_thres\nfloat32 trans_thres\nfloat32 rate\n"
    ),
    "tf2_web_republisher/msg/TFSubscriptionFeedback": "geometry_msgs/TransformStamped[] transforms\n",
    "tf2_web_republisher/msg/TFSubscriptionActionGoal": (
        "std_msgs/Header header\nactionlib_msgs/GoalID goal_id\ntf2_web_republisher/TFSubscriptionGoal goal\n"
    ),
    "tf2_web_republisher/msg/TFSubscriptionActionFeedback": (
        "std_msgs/Header header\nactionlib_msgs/GoalStatus status\n"
        "tf2_web_republisher/TFSubscriptionFeedback feedback\n"
    ),
    # https://github.com/apl-ocean-engineering/marine_msgs
    "marine_acoustic_msgs/msg/Dvl": (
        "uint8 DVL_MODE_BOTTOM=1\nuint8 DVL_MODE_WATER=2\nuint8 DVL_TYPE_PISTON=0\nuint8 DVL_TYPE_PHASED_ARRAY=1\n"
        "std_msgs/Header header\nuint8 velocity_mode\nuint8 dvl_type\ngeometry_msgs/Vector3 velocity\n"
        "float64[9] velocity_covar\nfloat64 altitude\nfloat64 course_gnd\nfloat64 speed_gnd\nuint8 num_good_beams\n"
        "float32 sound_speed\nbool beam_ranges_valid\nbool beam_velocities_valid\n"
        "geometry_msgs/Vector3[4] beam_unit_vec\nfloat64[4] range\nfloat32[4] range_covar\nfloat32[4] beam_quality\n"
        "float32[4] beam_velocity\nfloat32[4] beam_velocity_covar\n"
    ),
    # https://github.com/paagutie/dvl_msgs, of the driver of Water Linked's DVL A50
    "dvl_msgs/msg/DVLBeam": ("int64 id\nfloat64 velocity\nfloat64 distance\nfloat64 rssi\nfloat64 nsd\nbool valid\n"),
    "dvl_msgs/msg/DVL": (
        "std_msgs/Header header\nfloat64 time\ngeometry_msgs/Vector3 velocity\nfloat64 fom\nfloat64[] covariance\n"
        "float64 altitude\ndvl_msgs/DVLBeam[] beams\nbool velocity_valid\nint64 status\nint64 time_of_validity\n"
        "int64 time_of_transmission\nstring form\n"
    ),
    "marine_acoustic_msgs/msg/PingInfo": (
        "float32 frequency\nfloat32 sound_speed\nfloat32[] tx_beamwidths\nfloat32[] rx_beamwidths\n"
    ),
    "marine_acoustic_msgs/msg/SonarImageData": (
        "bool is_bigendian\nuint32 DTYPE_UINT8=0\nuint32 DTYPE_INT8=1\nuint32 DTYPE_UINT16=2\nuint32 DTYPE_INT16=3\n"
        "uint32 DTYPE_UINT32=4\nuint32 DTYPE_INT32=5\nuint32 DTYPE_UINT64=6\nuint32 DTYPE_INT64=7\n"
        "uint32 DTYPE_FLOAT32=8\nuint32 DTYPE_FLOAT64=9\n"
        "uint32 dtype\nuint32 beam_count\nuint8[] data\n"
    ),
    "marine_acoustic_msgs/msg/ProjectedSonarImage": (
        "std_msgs/Header header\nmarine_acoustic_msgs/PingInfo ping_info\ngeometry_msgs/Vector3[] beam_directions\n"
        "float32[] ranges\nmarine_acoustic_msgs/SonarImageData image\n"
    ),
}
"""Types that neither typestore contains, as .msg definitions. Add further types here, with their source."""

NEWEST_ONLY = frozenset(
    {
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/CompressedImage",
        "sensor_msgs/msg/PointCloud2",
        "octomap_msgs/msg/Octomap",
        "octomap_msgs/msg/OctomapWithPose",
    }
)
"""Types with large messages: slow readers receive only the latest message instead of the last ten."""

TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
EMPTY_PLACEHOLDER = "structure_needs_at_least_one_member"  # the placeholder field of messages without fields in ROS 2
_NAME = re.compile(r"([A-Za-z]\w*)/(?:(msg)/)?([A-Za-z]\w*)")


class Kind(NamedTuple):
    """The type of a field.

    base: the name of a primitive ("float32") or a message type ("std_msgs/msg/Header"). length: None for a single
    value, 0 for a list of any length, or else the fixed length. limit: the maximum length of a sequence or a string, or
    0 for no limit.
    """

    base: str
    length: int | None
    limit: int

    @property
    def is_message(self) -> bool:
        """Whether the field contains messages."""
        return "/" in self.base


class Field(NamedTuple):
    """A field. name: as spelled by the client.

    attribute: its name in the message object, or None if it has no such field.
    """

    name: str
    attribute: str | None
    kind: Kind


@cache
def typestore() -> Typestore:
    """Return all types: those of ROS 2 Jazzy, those that exist only in ROS 1 Noetic, and ADDED."""
    store = get_typestore(Stores.ROS2_JAZZY)
    noetic = get_typestore(Stores.ROS1_NOETIC).fielddefs
    store.register({name: noetic[name] for name in noetic.keys() - store.fielddefs.keys()})
    _add(store)
    return store


@cache
def ros1_typestore() -> Typestore:
    """Return the types used for ROS 1 serialisation: those of Noetic, plus those that Noetic lacks."""
    store = get_typestore(Stores.ROS1_NOETIC)
    jazzy = get_typestore(Stores.ROS2_JAZZY).fielddefs
    missing = {name: jazzy[name] for name in jazzy.keys() - store.fielddefs.keys()}
    store.register({name: (consts, without_placeholder(parts)) for name, (consts, parts) in missing.items()})
    _add(store)
    return store


def _add(store: Typestore) -> None:
    for name, text in ADDED.items():
        store.register(get_types_from_msg(text, name))


def without_placeholder(parts: Any) -> Any:
    """Return the fields of a definition from rosbags, without the placeholder of types without fields."""
    return [part for part in parts if part[0] != EMPTY_PLACEHOLDER]


def resolve(name: object) -> tuple[str, Ros | None]:
    """Return a type's ROS 2 name, and the ROS generation that uses this spelling, or None if both do.

    Both generations use "sensor_msgs/LaserScan", but only ROS 2 uses "sensor_msgs/msg/LaserScan". Raises ValueError for
    an invalid name.
    """
    match = _NAME.fullmatch(name) if isinstance(name, str) and len(name) < 200 else None
    if match is None:
        raise ValueError(f"type = {shortened(name)}: must be the name of a message type, such as 'std_msgs/String'")
    full = f"{match[1]}/msg/{match[3]}"
    if full not in typestore().fielddefs:
        raise ValueError(f"type = '{name}': unknown message type")
    return full, 2 if match[2] else None


def spelled(name: str, ros: Ros) -> str:
    """Return a type's full name in the spelling of a ROS generation."""
    return name if ros == 2 else name.replace("/msg/", "/", 1)


def message_text(name: str, ros: Ros) -> str:
    """Return a type's definition, including all nested types, in the format of rosbags and `rosmsg show`."""
    return (typestore() if ros == 2 else ros1_typestore()).generate_msgdef(name, ros_version=ros)[0]


@cache
def fields(name: str, ros: Ros) -> tuple[Field, ...]:
    """Return a type's fields as clients of `ros` see them."""
    attributes = {_folded(field): field for field, _ in typestore().fielddefs[name][1]}
    definitions = (typestore() if ros == 2 else ros1_typestore()).fielddefs[name][1]
    found = []
    for field, description in without_placeholder(definitions):
        spelling = {"sec": "secs", "nanosec": "nsecs"}.get(field, field) if ros == 1 and name in TIMES else field
        found.append(Field(spelling, attributes.get(_folded(field)), kind_of(description)))
    return tuple(found)


@cache
def begins_with_header(name: str) -> bool:
    """Return whether a type's first field is a header."""
    return any(field.kind.base == "std_msgs/msg/Header" for field in fields(name, 1)[:1])


def _folded(field: str) -> str:
    return field.lower()


def kind_of(description: Any) -> Kind:
    """Return a field's kind from its rosbags description: (node type, argument)."""
    node, argument = int(description[0]), description[1]
    if node == 1:  # a primitive
        return Kind(argument[0], None, argument[1])
    if node == 2:  # a message
        return Kind(argument, None, 0)
    inner = kind_of(argument[0])
    return Kind(inner.base, argument[1], 0) if node == 3 else Kind(inner.base, 0, argument[1])


def is_unicode(text: str) -> bool:
    """Return whether a text is valid Unicode. In JSON or CBOR, a client may send an unpaired surrogate."""
    return not any("\ud800" <= character <= "\udfff" for character in text)


def shortened(value: object) -> str:
    """Return a value, shortened for an error message."""
    if isinstance(value, str):
        value = value[:61]  # otherwise repr would format the whole text first
    text = repr(value) if isinstance(value, str | int | float | bool | None) else type(value).__name__
    return text if len(text) <= 60 else f"{text[:57]}..."
