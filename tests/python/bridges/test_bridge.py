"""Rules common to all bridges: each reading is taken once, each call is answered once, and everything is cleaned up."""

import itertools
import json
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from client_socket import connect
from foxglove_client import FoxgloveClient
from ros2_tools import PATIENCE_S, until
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.bridge import Bridge
from uwsim.bridges.foxglove import FoxgloveServer
from uwsim.channels import Channel, Delivery, Service
from uwsim.channels.delivery.feed import Feed, Reading
from uwsim.channels.ros.build import message, text
from uwsim.live import LiveSimulator, NotRunningError

NUMBER = "std_msgs/msg/UInt32"


@pytest.fixture
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator("pool", paused=True, speed="max") as live:
        yield live


class Kept(Bridge):
    """A bridge that stores what it receives."""

    def __init__(self, live: LiveSimulator | None, channels: list[Channel], *options: Any) -> None:
        self.taken: list[Reading] = []
        super().__init__("test", live, channels, *options)

    def take(self, reading: Reading) -> None:
        self.taken.append(reading)


def counted(rate_hz: float | None = 10.0, *, latched: bool = False) -> Channel:
    """Return a channel whose messages count the readings taken before them."""
    numbers = itertools.count()
    return Channel(
        "counted", NUMBER, "out", "", rate_hz=rate_hz, delivery=Delivery(latched),
        read=lambda sim: message(NUMBER, data=next(numbers)),
    )  # fmt: skip


def test_a_reading_is_taken_once_for_rosbridge_foxglove_and_all_other_sinks(live: LiveSimulator) -> None:
    channel, feed, others = counted(), Feed(live), list[Reading]()
    with (
        RosbridgeServer(live, channels=[channel], feed=feed) as rosbridge,
        FoxgloveServer(live, [channel], port=0, feed=feed) as foxglove,
        connect(rosbridge.url) as client,
        FoxgloveClient(foxglove.url) as app,
    ):
        feed.listen(channel, others.append)
        until(lambda: others)  # while paused, each new sink triggers a first reading for itself
        client.send(json.dumps({"op": "subscribe", "topic": "/counted", "queue_length": 100}))
        client.recv(PATIENCE_S)
        app.subscribe("/counted")
        app.next("/counted")
        live.step(200)  # one second
        seen = [json.loads(client.recv(PATIENCE_S))["msg"]["data"] for _ in range(10)]
        times_ns, data = app.next("/counted")
    read = [reading.message.data for reading in others]
    assert read == sorted(set(read)) and len(read) == 11
    assert seen == read[1:], "rosbridge got the same ones"
    assert data in {bytes(reading.cdr) for reading in others if reading.time_ns == times_ns}


def test_while_paused_a_second_client_of_a_topic_gets_a_reading_too(live: LiveSimulator) -> None:
    with (
        RosbridgeServer(live, channels=[counted()], feed=Feed(live)) as server,
        connect(server.url) as first,
        connect(server.url) as second,
    ):
        for client in (first, second):
            client.send(json.dumps({"op": "subscribe", "topic": "/counted"}))
            assert json.loads(client.recv(PATIENCE_S))["topic"] == "/counted"


def test_a_channel_is_read_while_a_peer_demands_it_and_not_after_the_end(live: LiveSimulator) -> None:
    with Kept(live, [counted()]) as bridge:
        live.step(100)
        assert not bridge.taken
        bridge.demand("counted", True)
        bridge.demand("counted", True)
        live.step(100)
        count = len(bridge.taken)
        assert 5 <= count <= 6
        bridge.demand("counted", False)
        live.step(100)
        assert len(bridge.taken) == count
        bridge.demand("counted", True)
    assert bridge.close() is False, "it is closed already"
    count = len(bridge.taken)
    live.step(100)
    bridge.demand("counted", True)
    assert len(bridge.taken) == count and not bridge.is_read("counted")


def test_a_channel_without_a_rate_is_read_anew_when_a_first_sink_comes_and_shared_by_later_ones(
    live: LiveSimulator,
) -> None:
    channel, feed = counted(None, latched=True), Feed(live)
    first, second = Kept(live, [channel], (), feed), Kept(live, [channel], (), feed)
    first.listen("counted")
    until(lambda: first.taken)
    second.listen("counted")
    assert second.taken == first.taken
    first.close()
    second.leave("counted")
    second.listen("counted")
    until(lambda: len(second.taken) == 2)
    assert [reading.message.data for reading in second.taken] == [0, 1]
    second.close()


def test_calls_are_answered_once_and_a_vital_one_waits_for_no_other(live: LiveSimulator) -> None:
    going_on, answers = threading.Event(), dict[str, list[tuple[bool, Any]]]()

    def wait(live: LiveSimulator, request: dict[str, Any]) -> dict[str, Any]:
        if not going_on.wait(PATIENCE_S):
            raise ValueError("it waited in vain")
        if request:
            raise RuntimeError
        return {"success": True}

    kind = "std_srvs/srv/Trigger"
    busy, vital = Service("busy", kind, wait), Service("stop", kind, lambda *_: {"success": True}, is_vital=True)
    with Kept(live, [], [busy, vital]) as bridge:

        def call(service: Service, name: str, **request: Any) -> None:
            found = answers.setdefault(name, [])
            bridge.call(service, request, lambda succeeded, values: found.append((succeeded, values)))

        for number in range(12):
            call(busy, f"busy {number}")
        call(busy, "fails", why="none")
        call(vital, "vital")
        until(lambda: answers["vital"])
        assert not any(found for name, found in answers.items() if name != "vital")
        going_on.set()
        until(lambda: all(answers.values()))
    assert answers.pop("fails") == [(False, "RuntimeError")]
    assert all(found == [(True, {"success": True})] for found in answers.values())


def test_the_calls_that_wait_for_an_answer_are_bounded(live: LiveSimulator) -> None:
    going_on, answers = threading.Event(), list[bool]()
    busy = Service("busy", "std_srvs/srv/Trigger", lambda *_: {"success": going_on.wait(PATIENCE_S)})

    class Bounded(Kept):
        def __init__(self) -> None:
            Bridge.__init__(self, "test", live, [], [busy], open_calls=6)

    with Bounded() as bridge:
        for _ in range(6):
            bridge.call(busy, {}, lambda succeeded, values: answers.append(succeeded))
        with pytest.raises(ValueError, match="6 calls are already waiting"):
            bridge.call(busy, {}, lambda succeeded, values: None)
        going_on.set()
        until(lambda: len(answers) == 6)
        bridge.call(busy, {}, lambda succeeded, values: answers.append(succeeded))
        until(lambda: len(answers) == 7)


def test_what_cannot_be_commanded_is_reported_and_never_raised(live: LiveSimulator) -> None:
    refused: list[str] = []

    class Reporting(Kept):
        def refuse(self, reason: str) -> None:
            refused.append(reason)

    def apply(live: LiveSimulator, message: Any) -> None:
        raise ValueError("t = 'x': must be a number")

    def decode(data: bytes, kind: str) -> Any:
        return text(data.decode())

    channel = Channel("t", "std_msgs/msg/String", "in", "", apply=apply)
    with Reporting(live, [channel]) as bridge:
        bridge.receive(channel, b"x", decode)
        bridge.receive(channel, bytes((1 << 20) + 1), decode)
    assert refused == ["/t: t = 'x': must be a number", "/t: 1048577 bytes: must be 1048576 at most"]
    with pytest.raises(NotRunningError):
        Kept(None, [])
