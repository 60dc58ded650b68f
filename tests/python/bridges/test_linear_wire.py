"""Readers of the network work in proportion to what they are sent: k, 2k and 4k of one element, counted in lines run.

IMC's reader has its own test. NMEA reads nothing; MAVLink and TCPROS are read by pymavlink and rospy.
"""

import json
from collections.abc import Callable
from typing import Any

import cbor2
import pytest

from counted_work import assert_linear
from uwsim.bridges.doors.waiting import Room
from uwsim.bridges.moos import wire as moos
from uwsim.bridges.ping_protocol import wire as ping
from uwsim.bridges.rosbridge.encoding import to_json
from uwsim.bridges.rosbridge.fragments import Fragments, split
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.parse import read
from uwsim.channels.ros.messages import from_plain

LIMITS = Limits()
PART = 64


def in_parts(data: bytes) -> None:
    """Read a MOOSDB's packets as a connection divides them."""
    reader = moos.PacketReader()
    assert [m for k in range(0, len(data), PART) for m in reader.read(data[k : k + PART])]


def pinged(data: bytes) -> None:
    """Read messages of the ping protocol as a serial port divides them."""
    reader = ping.Reader()
    assert [m for k in range(0, len(data), PART) for m in reader.read(data[k : k + PART])]


def fragments(count: int) -> list[dict[str, Any]]:
    text = to_json({"op": "publish", "msg": "x" * count})
    found = [json.loads(each) for each in split(text, 1, "f", count)]
    return [*found[:-1], found[0], found[-1]]  # one comes again


def assembled(operations: list[dict[str, Any]]) -> None:
    kept = Fragments(LIMITS, Room())
    assert [kept.add(each) for each in operations][-1] is not None


def notified(count: int) -> list[moos.Message]:
    return [moos.Message(moos.NOTIFY, "NAV_X", float(k)) for k in range(count)]


def publication(count: int) -> dict[str, Any]:
    transforms = [{"transform": {"rotation": {"w": 1.0}}, "child_frame_id": f"f{k}"} for k in range(count)]
    return {"op": "publish", "topic": "/tf", "msg": {"transforms": transforms}}


READERS: dict[str, tuple[Callable[[Any], object], Callable[[int], Any]]] = {
    "moos, messages": (in_parts, lambda count: moos.encoded(notified(count))),
    "moos, packets": (in_parts, lambda count: moos.encoded(notified(1)) * count),
    "ping, messages": (pinged, lambda count: ping.encoded(6, {"requested_id": 5}, source=0) * count),
    "ping, starts": (pinged, lambda count: b"BR" * 6 * count + ping.encoded(6, {"requested_id": 5}, source=0)),
    "rosbridge, fragments": (assembled, fragments),
    "rosbridge, JSON": (lambda frame: read(frame, LIMITS), lambda count: to_json(publication(count))),
    "rosbridge, CBOR": (lambda frame: read(frame, LIMITS), lambda count: cbor2.dumps(publication(count))),
    "rosbridge, messages": (
        lambda plain: from_plain("tf2_msgs/msg/TFMessage", plain), lambda count: publication(count)["msg"]
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", READERS)
def test_the_work_is_in_proportion_to_the_number_of_elements(name: str) -> None:
    call, made = READERS[name]
    assert_linear(call, made, 60)
