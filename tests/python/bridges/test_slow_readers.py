"""A slow reader gets new messages: little is under way to it, and its queues are as long as it asks."""

import json

import pytest

from client_socket import connect as websocket
from client_socket import receive, send
from rosbridge_session import Client
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.doors.conversation import MOST_UNDER_WAY, UNDER_WAY_S, Pace
from uwsim.bridges.rosbridge.graph import Graph
from waiting import until

STRING = "std_msgs/String"
COUNT = 400


@pytest.mark.parametrize("message_s", [0.001, 0.02, 0.1, 0.4, 3.0])
def test_what_is_under_way_to_a_reader_is_read_within_a_quarter_of_a_second_or_is_one_message(message_s: float) -> None:
    now_s = 0.0
    pace = Pace(lambda: now_s)
    for _ in range(12):  # answers to pings
        count = 0
        while not pace.is_full:
            pace.sent()
            count += 1
        assert pace.is_due
        pace.asked()
        now_s += count * message_s
        pace.answered()
    assert count == max(1, int(UNDER_WAY_S / message_s + 1e-9))


def test_a_fast_reader_is_seldom_asked_and_one_that_stops_gets_nothing_more() -> None:
    now_s, pings = 0.0, 0
    pace = Pace(lambda: now_s)
    for _ in range(100_000):
        assert not pace.is_full
        pace.sent()
        now_s += 1e-5
        if pace.is_due:
            pace.asked()
            pace.answered()
            pings += 1
    assert pings < 100_000 / (MOST_UNDER_WAY / 4)
    pace.sent()
    pace.asked()
    now_s += 2 * UNDER_WAY_S
    assert pace.is_full


def test_with_a_queue_of_one_a_reader_that_pauses_then_gets_the_newest_message() -> None:
    """The system would hold megabytes of old messages for it."""
    with (
        RosbridgeServer(None) as server,
        websocket(server.url) as publisher,
        websocket(server.url, max_queue=1) as reader,
    ):
        send(reader, "subscribe", topic="/t", type=STRING, queue_length=1)
        until(lambda: "t" in server.graph.topics and server.graph.topics["t"].sinks)
        send(publisher, "advertise", topic="/t", type=STRING)
        for number in range(COUNT):
            send(publisher, "publish", topic="/t", msg={"data": f"{number} {'x' * 2000}"})
        send(publisher, "call_service", service="/rosapi/get_time", id="all is published")
        receive(publisher, id="all is published")
        numbers = [-1]
        while numbers[-1] < COUNT - 1:
            numbers.append(int(json.loads(reader.recv(60.0))["msg"]["data"].split()[0]))
    assert numbers == sorted(numbers) and len(numbers) < COUNT // 4  # a busy machine reads more than the first ones


def test_a_topic_whose_messages_are_replaced_keeps_its_turn() -> None:
    graph = Graph()
    reader, publisher = Client(graph, "/reader"), Client(graph, "/publisher")
    for topic in ("slow", "fast"):
        publisher.send("advertise", topic=topic, type=STRING)
        reader.send("subscribe", topic=topic, type=STRING, queue_length=1)
    for topic in ("fast", "slow", "fast", "fast"):
        publisher.send("publish", topic=topic, msg={"data": topic})
    assert [frame["topic"] for frame in reader.received()] == ["fast", "slow"]
