"""Log messages on /rosout, for display in ROS 2 consoles."""

from __future__ import annotations

from typing import Any

from uwsim.channels.ros import build

LOG, LOG_TOPIC = "rcl_interfaces/msg/Log", "rosout"
LOG_DEPTH = 100  # number of past messages received by a console that joins late
INFO, WARN = 20, 30  # levels of rcl_interfaces/Log


def log_message(stamp_ns: int, node: str, level: int, text: str) -> Any:
    """Return a message for /rosout."""
    return build.message(LOG, stamp=build.time(stamp_ns), level=level, name=node, msg=text)
