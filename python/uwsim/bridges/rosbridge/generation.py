"""Generation: which generation of ROS a rosbridge_server is of, as the server itself shows.

Its generations refuse each other's messages: ROS 2 has no header.seq, and spells the fields of a time otherwise. A
server is asked in turn for what it has: rosapi's time, whose fields it spells; rosapi's version; and a Header of ours
without a time, which it sends back with all of its fields.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from uwsim.channels.ros.messages import Ros

TURN_S = 2.0
"""How long to wait for an answer before the next question [s]."""
HEADERS = 3
"""How often the Header is sent, since a graph may take a while to connect a topic's two ends."""
TOPIC, HEADER = "/uwsim_asks", "std_msgs/Header"

Operation = dict[str, Any]


class Generation:
    """The questions to one server, and what its answers show.

    mark: a unique word, with which the id of each question begins. ros: the generation, or None as long as no answer
    has shown it.
    """

    def __init__(self, mark: str) -> None:
        self._mark = mark
        self._has_topic = False
        self.ros: Ros | None = None

    def questions(self) -> Iterator[list[Operation]]:
        """Yield the operations of each question; ask the next one if the answer shows nothing, or none comes."""
        for service in ("get_time", "get_ros_version"):
            name = f"/rosapi/{service}"
            yield [{"op": "call_service", "service": name, "id": f"{self._mark} {service}", "args": {}}]
        self._has_topic = True
        sent = {"op": "publish", "topic": TOPIC, "msg": {"frame_id": self._mark}}
        both = {"topic": TOPIC, "type": HEADER}
        yield [{"op": "advertise", **both}, {"op": "subscribe", **both}, sent]
        for _ in range(HEADERS - 1):
            yield [sent]

    def ends(self) -> list[Operation]:
        """Return the operations that remove what was asked for."""
        return [{"op": op, "topic": TOPIC} for op in ("unsubscribe", "unadvertise")] if self._has_topic else []

    def read(self, operation: Operation) -> bool:
        """Return whether an operation answers a question, and learn from it."""
        if operation.get("op") == "service_response" and str(operation.get("id")).startswith(self._mark):
            values = operation.get("values")
            if isinstance(values, dict):
                self.ros = self.ros or _of_version(values.get("version")) or _of_time(values.get("time"))
            return True
        if operation.get("op") == "publish" and str(operation.get("topic")).strip("/") == TOPIC.strip("/"):
            header = operation.get("msg")
            if isinstance(header, dict):
                self.ros = self.ros or _of_time(header.get("stamp"))
            return True
        return False


def chosen(shown: Ros | None, given: Ros | None) -> tuple[Ros, str]:
    """Return the generation to use, and a remark for the log unless it is as expected.

    shown: by the server, which knows best. given: by the user, or None.
    """
    if shown is None:
        why = "it does not show whether it is of ROS 1 or 2"
        return given or 1, "" if given else f"{why}: used as ROS 1; --ros 2 changes that"
    return shown, f"it is of ROS {shown}: ROS {given}, as given, is not used" if given not in (None, shown) else ""


def _of_version(version: object) -> Ros | None:
    return 1 if version == 1 else 2 if version == 2 else None


def _of_time(time: object) -> Ros | None:
    """Return the generation that spells the fields of a time as these."""
    if not isinstance(time, dict):
        return None
    return 2 if "sec" in time else 1 if "secs" in time else None
