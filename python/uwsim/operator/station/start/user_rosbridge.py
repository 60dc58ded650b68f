"""The user's rosbridge, a server named on the start screen that a session joins as `uwsim ros connect` does."""

from __future__ import annotations

import re
from dataclasses import dataclass

from uwsim.base.arguments import is_within
from uwsim.bridges.doors.endpoint import ROSBRIDGE_PORT
from uwsim.bridges.rosbridge.client import Client
from uwsim.channels.ros.messages import Ros

HOST = re.compile(r"(wss?://)?([A-Za-z0-9][A-Za-z0-9_.-]*|\[[0-9A-Fa-f:.]+\])")
STATION_ANSWERS_S = 1.0


@dataclass(frozen=True)
class UserRosbridge:
    """The address of a rosbridge server, and its ROS generation if it does not show it."""

    url: str
    ros: Ros | None

    def require_reachable(self) -> None:
        """Try to connect. Raises ValueError if the server cannot be reached, or is a uwsim station."""
        client = Client(self.url, keeps=False)
        try:
            client.start()
            values = client.ask("/station/catalog", patience_s=STATION_ANSWERS_S).get("values")  # only stations have it
            if isinstance(values, dict) and "scenarios" in values:
                hint = "run one of the two on another port, such as uwsim station --port 9091"
                raise ValueError(f"{self.url}: this is a uwsim station, not your rosbridge: {hint}")
            if client.trouble:
                raise ValueError(f"{self.url}: the server closed the connection")
        except OSError as error:
            raise ValueError(f"{self.url}: {error}") from None
        finally:
            client.close()


def checked_host(value: object) -> str:
    """Return the address, with its scheme. Raises ValueError."""
    found = HOST.fullmatch(value.strip()) if isinstance(value, str) else None
    if found is None:
        rule = "must be a name or an address, such as localhost or ws://192.168.1.7, without the port"
        raise ValueError(f"rosbridge_host = {str(value)[:60]!r}: {rule}")
    return (found[1] or "ws://") + found[2]


def checked_port(value: object) -> int:
    """Return the port, which for None is rosbridge_server's default. Raises ValueError."""
    if value is None:
        return ROSBRIDGE_PORT
    if not is_within(value, 1, 65535, whole=True):
        raise ValueError(f"rosbridge_port = {str(value)[:40]}: must be a whole number in [1, 65535]")
    return int(value)


def checked_ros(value: object) -> Ros | None:
    """Return the generation of ROS, or None. Raises ValueError."""
    if value is not None and (isinstance(value, bool) or value not in (1, 2)):
        raise ValueError(f"rosbridge_ros = {str(value)[:40]}: must be 1 or 2")
    return None if value is None else 2 if value == 2 else 1
