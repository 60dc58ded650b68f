"""Services of ROS 1: std_srvs/Trigger and SetBool as such; others by JSON on a topic, for their types are our own."""

from __future__ import annotations

import importlib
import json
import struct
from functools import cache
from typing import Any

from uwsim.bridges.ros1.raw_types import raw_type
from uwsim.channels import Service
from uwsim.live import LiveSimulator

TRIGGER, SET_BOOL = "std_srvs/srv/Trigger", "std_srvs/srv/SetBool"
CHECKSUMS = {TRIGGER: "937c9679a518e3a18d831e57125ea522", SET_BOOL: "09fb03525b03e7ea1fd3992bafd87e16"}
ANSWER_TEXT = "bool success\nstring message\n"


def offer_service(rospy: Any, live: LiveSimulator, service: Service) -> Any:
    """Offer a service to ROS; returns what keeps it: a rospy.Service or a Subscriber."""
    if service.type in CHECKSUMS:
        return rospy.Service(
            "/" + service.name, _service_class(service.type), lambda request: _serve(live, service, request)
        )
    return rospy.Subscriber(
        "/" + service.name, raw_type("std_msgs/msg/String"), lambda received: _call(rospy, live, service, received.data)
    )


def _serve(live: LiveSimulator, service: Service, request: Any) -> Any:
    _, _, answer = _parts(service.type)
    arguments = {"data": request.on} if service.type == SET_BOOL else {}
    try:
        found = service.call(live, arguments)
    except (ValueError, RuntimeError) as error:
        found = {"success": False, "message": str(error)}
    return answer(bool(found["success"]), str(found.get("message", "")))


def _call(rospy: Any, live: LiveSimulator, service: Service, data: bytes) -> None:
    """Call a service by a std_msgs/String that holds its request in JSON; the answer is said on /rosout."""
    try:
        text = data[4:].decode()
        request = json.loads(text or "{}")
        if not isinstance(request, dict):
            raise ValueError(f"data = {text!r:.60}: must be an object in JSON")
        rospy.loginfo(f"/{service.name}: {json.dumps(service.call(live, request), default=str)}")
    except (ValueError, RuntimeError) as error:
        rospy.logwarn(f"/{service.name}: {error}")


def _service_class(kind: str) -> type:
    return _parts(kind)[0]


@cache
def _parts(kind: str) -> tuple[type, type, type]:
    """Return the classes of a service, its request and its answer, as genpy would make them of std_srvs."""
    genpy = importlib.import_module("genpy")
    takes_bool, name = kind == SET_BOOL, kind.replace("/srv/", "/")

    class Request(genpy.Message):  # type: ignore[misc, name-defined]
        _type, _md5sum, _full_text = name + "Request", CHECKSUMS[kind], "bool data\n" if takes_bool else ""
        _has_header = False
        __slots__ = ("on",)
        _slot_types = ("bool",)

        def __init__(self, on: bool = False) -> None:
            self.on = on

        def serialize(self, buffer: Any) -> None:
            buffer.write(struct.pack("<B", self.on) if takes_bool else b"")

        def deserialize(self, data: bytes) -> Any:
            self.on = bool(data[0]) if takes_bool else False
            return self

    class Answer(genpy.Message):  # type: ignore[misc, name-defined]
        _type, _md5sum, _full_text = name + "Response", CHECKSUMS[kind], ANSWER_TEXT
        _has_header = False
        __slots__ = ("message", "success")
        _slot_types = ("string", "bool")

        def __init__(self, success: bool = False, message: str = "") -> None:
            self.success, self.message = success, message

        def serialize(self, buffer: Any) -> None:
            text = self.message.encode()
            buffer.write(struct.pack(f"<BI{len(text)}s", self.success, len(text), text))

        def deserialize(self, data: bytes) -> Any:
            self.success, self.message = bool(data[0]), data[5:].decode()
            return self

    class Kind:
        _type, _md5sum, _request_class, _response_class = name, CHECKSUMS[kind], Request, Answer

    return Kind, Request, Answer
