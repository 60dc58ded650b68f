"""Topics that call services, for peers that cannot call ROS 2 services.

A std_msgs/Empty on a topic of the same name calls a std_srvs/Trigger, a std_msgs/Bool calls a std_srvs/SetBool, and a
std_msgs/String containing the request in JSON calls any other service. The response is published on /rosout.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import orjson

from uwsim.base.texts.json_text import json_object
from uwsim.bridges.answers import Answer
from uwsim.bridges.ros2.rosout import INFO, WARN
from uwsim.channels import Channel, Service
from uwsim.live import LiveSimulator

Report = Callable[[int, str], None]
Request = dict[str, Any]
Call = Callable[[Service, Request, Answer], None]
EMPTY, BOOL, STRING = "std_msgs/msg/Empty", "std_msgs/msg/Bool", "std_msgs/msg/String"
MESSAGE_OF = {"std_srvs/srv/Trigger": EMPTY, "std_srvs/srv/SetBool": BOOL}


def service_channels(services: Sequence[Service], call: Call, report: Report) -> list[Channel]:
    """Return channels whose messages call services through `call`; `report` reports the responses."""
    return [_channel(service, call, report) for service in services]


def _channel(service: Service, call: Call, report: Report) -> Channel:
    kind = MESSAGE_OF.get(service.type, STRING)

    def answer(succeeded: bool, values: Any) -> None:
        if succeeded:
            level, text = INFO if values.get("success", True) else WARN, orjson.dumps(values, default=str).decode()
        else:
            level, text = WARN, values
        report(level, f"/{service.name}: {text}")

    def apply(live: LiveSimulator, message: Any) -> None:
        call(service, _request(kind, message), answer)

    return Channel(service.name, kind, "in", service.description, apply=apply)


def _request(kind: str, message: Any) -> Request:
    """Return the request that a message contains. Raises ValueError."""
    if kind == EMPTY:
        return {}
    if kind == BOOL:
        return {"data": bool(message.data)}
    return json_object(message.data or "{}", f"data = {message.data!r:.60}")
