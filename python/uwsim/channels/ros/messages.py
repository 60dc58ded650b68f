"""ROS messages without ROS: message objects, and their conversion to and from JSON, CBOR and ROS serialisations.

A message is an instance of, say, `typestore().types["std_msgs/msg/String"]`. `to_plain(message, ros=1)` returns
{"data": "hello"} for orjson or cbor2; `from_plain("std_msgs/msg/String", plain)` checks such a dict, fills in defaults
and returns the message.
"""

from uwsim.channels.ros.message_in import from_plain, typed_array
from uwsim.channels.ros.message_out import default_message, from_bytes, numbered, to_bytes, to_plain
from uwsim.channels.ros.message_types import Ros, resolve, spelled, typestore

__all__ = [
    "Ros",
    "default_message",
    "from_bytes",
    "from_plain",
    "numbered",
    "resolve",
    "spelled",
    "to_bytes",
    "to_plain",
    "typed_array",
    "typestore",
]
