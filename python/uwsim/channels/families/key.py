"""The `key` message of the paper's keyboard node: a function code, and efforts with sway and yaw to starboard."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from uwsim.channels.ros import build

POSE = "geometry_msgs/msg/Pose"


class Function(IntEnum):
    """The function that a message requests, in orientation.w."""

    NONE = 0
    RELEASE = 1
    FRONT_OFF = 2
    FRONT_ON = 3
    DOWN_OFF = 4
    DOWN_ON = 5
    TILT_DOWN = 6
    TILT_HOLD = 7
    TILT_UP = 8


def key_message(efforts: Mapping[str, float], function: Function = Function.NONE) -> Any:
    """Return the message for efforts by axis (REP 103) and a function."""
    turn = efforts["pitch"], efforts["roll"], -efforts["yaw"]
    return build.pose((efforts["surge"], -efforts["sway"], efforts["heave"]), (*turn, float(function)))


def key_efforts(message: Any) -> dict[str, float]:
    """Return a message's efforts by axis (REP 103)."""
    ahead, turn = message.position, message.orientation
    return {"surge": ahead.x, "sway": -ahead.y, "heave": ahead.z, "roll": turn.y, "pitch": turn.x, "yaw": -turn.z}
