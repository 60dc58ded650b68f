"""Messages of /rosout: what ROS 2's consoles show."""

from __future__ import annotations

from typing import Any

from uwsim.channels import build

LOG, LOG_TOPIC = "rcl_interfaces/msg/Log", "rosout"
LOG_DEPTH = 100  # messages that a console gets that is opened later
INFO, WARN = 20, 30  # of rcl_interfaces/Log


def log_message(stamp_ns: int, node: str, level: int, text: str) -> Any:
    """Return a message of /rosout."""
    return build.message(LOG, stamp=build.time(stamp_ns), level=level, name=node, msg=text)
