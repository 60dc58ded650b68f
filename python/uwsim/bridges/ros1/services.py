"""Services for ROS 1. Trigger and SetBool are native; others use JSON on a topic, since ROS lacks their types."""

from __future__ import annotations

import importlib
import json
import struct
from functools import cache
from typing import Any

from uwsim.base.texts.json_text import json_object
from uwsim.bridges.answers import outcome
from uwsim.bridges.bridge import Bridge
from uwsim.bridges.ros1.raw_types import raw_type
from uwsim.channels import Service

TRIGGER, SET_BOOL = "std_srvs/srv/Trigger", "std_srvs/srv/SetBool"
CHECKSUMS = {TRIGGER: "937c9679a518e3a18d831e57125ea522", SET_BOOL: "09fb03525b03e7ea1fd3992bafd87e16"}
ANSWER_TEXT = "bool success\nstring message\n"


def offer_service(rospy: Any, bridge: Bridge, service: Service) -> Any:
    """Register a ROS service handled on rospy's threads; return the rospy.Service or Subscriber that owns it."""
    name = f"/{service.name}"

    def answer(request: Any) -> Any:
        arguments = {"data": request.on} if service.type == SET_BOOL else {}
        succeeded, found = outcome(lambda: bridge.respond(service, arguments), bridge.log)
        values = found if succeeded else {"success": False, "message": found}
        return _parts(service.type)[2](bool(values["success"]), str(values.get("message", "")))

    def report(received: Any) -> None:
        succeeded, found = outcome(lambda: bridge.respond(service, _request(received.data)), bridge.log)
        if succeeded:
            rospy.loginfo(f"{name}: {json.dumps(found, default=str)}")
        else:
            rospy.logwarn(f"{name}: {found}")

    if service.type in CHECKSUMS:
        return rospy.Service(name, _parts(service.type)[0], answer)
    return rospy.Subscriber(name, raw_type("std_msgs/msg/String"), report)


def _request(data: bytes) -> dict[str, Any]:
    """Parse a request, sent as JSON in a std_msgs/String. Raises ValueError."""
    text = data[4:].decode(errors="replace")
    return json_object(text or "{}", f"data = {text!r:.60}")


@cache
def _parts(kind: str) -> tuple[type, type, type]:
    """Return the classes of a service, its request and its response, as genpy would generate them for std_srvs."""
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
