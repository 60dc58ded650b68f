"""The rosbridge protocol without a transport: frames in, frames out."""

import base64
import io
import json
import math

import cbor2
import numpy as np
import pytest
from PIL import Image

from rosbridge_session import Client
from uwsim.bridges.rosbridge.encoding import Sample
from uwsim.bridges.rosbridge.graph import Graph
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels.ros.message_types import ros1_typestore
from uwsim.channels.ros.messages import default_message, typed_array


def test_clients_talk_to_each_other_and_slashes_do_not_matter(pair):
    one, two = pair
    two.send("subscribe", topic="/chatter", type="std_msgs/String")
    one.send("advertise", topic="chatter", type="std_msgs/msg/String")
    one.send("publish", topic="chatter", msg={"data": "hello"})
    assert two.received() == [{"op": "publish", "topic": "/chatter", "msg": {"data": "hello"}}]
    two.send("unsubscribe", topic="/chatter")
    one.send("publish", topic="chatter", msg={"data": "again"})
    assert two.received() == one.received() == []


def test_a_subscriber_gets_the_spelling_of_the_ros_that_its_type_is_of(graph):
    publisher = Client(graph, "/p").send("advertise", topic="odom", type="nav_msgs/Odometry")
    old = Client(graph, "/old").send("subscribe", topic="odom", type="nav_msgs/Odometry")
    new = Client(graph, "/new").send("subscribe", topic="odom", type="nav_msgs/msg/Odometry")
    new_by_default = Client(graph, "/default", ros=2).send("subscribe", topic="odom")
    publisher.send("publish", topic="odom", msg={"header": {"stamp": {"secs": 1, "nsecs": 2}}})
    assert old.received()[0]["msg"]["header"] == {"seq": 0, "stamp": {"secs": 1, "nsecs": 2}, "frame_id": ""}
    for client in (new, new_by_default):
        assert client.received()[0]["msg"]["header"] == {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": ""}


def test_latched_messages_reach_those_who_come_later(pair):
    one, two = pair
    one.send("advertise", topic="map", type="std_msgs/String", latch=True)
    one.send("publish", topic="map", msg={"data": "old"}).send("publish", topic="map", msg={"data": "new"})
    two.send("subscribe", topic="map")
    assert two.texts() == ["new"]
    one.session.close()
    two.send("unsubscribe", topic="map").send("subscribe", topic="map")
    assert two.texts() == []


def test_a_full_queue_loses_its_oldest_messages_and_no_other_queue_does(graph):
    publisher = Client(graph, "/p").send("advertise", topic="t", type="std_msgs/UInt8")
    slow = Client(graph, "/slow").send("subscribe", topic="t", queue_length=3)
    quick = Client(graph, "/quick").send("subscribe", topic="t", queue_length=3)
    heard = []
    for k in range(20):
        publisher.send("publish", topic="t", msg={"data": k})
        heard += quick.texts()
    assert heard == list(range(20))
    assert slow.texts() == [17, 18, 19]
    assert (slow.session.outbox.lost, quick.session.outbox.lost) == (17, 0)


def test_of_images_only_the_newest_waits(pair):
    one, two = pair
    two.send("subscribe", topic="image", type="sensor_msgs/CompressedImage")
    one.send("advertise", topic="image", type="sensor_msgs/CompressedImage")
    for name in ("old", "new"):
        one.send("publish", topic="image", msg={"format": name})
    assert [operation["msg"]["format"] for operation in two.received()] == ["new"]


def test_throttle_drops_without_a_queue_and_delays_with_one(graph):
    publisher = Client(graph, "/p").send("advertise", topic="t", type="std_msgs/UInt8")
    dropping = Client(graph, "/d").send("subscribe", topic="t", throttle_rate=125)
    queueing = Client(graph, "/q").send("subscribe", topic="t", throttle_rate=125, queue_length=2)
    heard = {dropping: [], queueing: []}
    for k in range(13):
        if k < 10:
            publisher.send("publish", topic="t", msg={"data": k})
        for client, values in heard.items():
            values += client.texts()
            client.now_s += 0.0625
    assert heard[dropping] == [0, 2, 4, 6, 8]  # every 125 ms, from messages that arrive every 62.5 ms
    assert len(heard[queueing]) == 7 and heard[queueing][-2:] == [8, 9]  # two are still queued when the messages stop
    publisher.send("publish", topic="t", msg={"data": 99})
    queueing.now_s -= 0.01
    frame, delay_s = queueing.session.outbox.take()
    assert frame is None and 0 < delay_s <= 0.125


def test_the_ids_of_a_subscription_share_the_shortest_throttle_and_end_one_by_one(pair):
    one, two = pair
    one.send("advertise", topic="t", type="std_msgs/UInt8")
    two.send("subscribe", topic="t", id="slow", throttle_rate=1250).send("subscribe", topic="t", id="fast")
    for k in range(3):
        one.send("publish", topic="t", msg={"data": k})
    assert two.texts() == [0, 1, 2]  # each message once
    two.send("unsubscribe", topic="t", id="fast")
    for k in range(3):
        one.send("publish", topic="t", msg={"data": k})
        two.texts()
    two.send("unsubscribe", topic="t", id="slow")
    assert two.send("unsubscribe", topic="t").complaint() == "topic 't': you do not subscribe to it"


def scan():
    message = default_message("sensor_msgs/msg/LaserScan")
    message.ranges = np.array([1.5, math.inf, 2.0], np.float32)
    return message


@pytest.fixture
def compressed(graph):
    """Return a function that returns the frame a subscriber with a given compression receives for a scan."""

    def frame(compression, **options):
        client = Client(graph, f"/{compression}", **options)
        client.send("subscribe", topic="/scan", type="sensor_msgs/LaserScan", compression=compression)
        graph.publish(graph.topics["scan"], Sample(scan(), 5_000_000_007))
        (found,) = client.frames()
        return found

    return frame


def test_compressions(compressed):
    plain = json.loads(compressed("none"))
    assert plain["msg"]["ranges"] == [1.5, None, 2.0]
    packed = cbor2.loads(compressed("cbor"))
    assert (packed["op"], packed["topic"]) == ("publish", "/scan")
    np.testing.assert_array_equal(typed_array(packed["msg"]["ranges"]), scan().ranges)
    raw = cbor2.loads(compressed("cbor-raw"))["msg"]
    assert (raw["secs"], raw["nsecs"]) == (5, 7)
    read = ros1_typestore().deserialize_ros1(raw["bytes"], "sensor_msgs/msg/LaserScan")
    np.testing.assert_array_equal(read.ranges, scan().ranges)
    png = json.loads(compressed("png"))
    pixels = Image.open(io.BytesIO(base64.b64decode(png["data"]))).tobytes()
    plain["msg"]["header"]["seq"] = 3  # the fourth message on its topic
    assert png["op"] == "png" and json.loads(pixels) == plain


def test_a_message_is_encoded_once_for_all_subscribers(graph, monkeypatch):
    clients = [Client(graph, f"/{k}").send("subscribe", topic="/t", type="std_msgs/UInt8") for k in range(5)]
    graph.publish(graph.topics["t"], Sample(default_message("std_msgs/msg/UInt8")))
    frames = [client.frames()[0] for client in clients]
    assert all(frame is frames[0] for frame in frames)


def test_roslibpy_gets_neither_png_nor_unasked_status(compressed, graph):
    agent = "AutobahnPython/25.1"
    assert json.loads(compressed("png", agent=agent))["op"] == "publish"
    client = Client(graph, "/roslibpy", agent=agent).send("nonsense")
    assert client.received() == []
    assert "unknown" in client.send("set_level", level="error").send("nonsense").complaint()


def test_a_message_in_cbor_and_one_with_nan_are_taken(pair):
    one, two = pair
    two.send("subscribe", topic="scan", type="sensor_msgs/LaserScan")
    one.send("advertise", topic="scan", type="sensor_msgs/LaserScan")
    ranges = cbor2.CBORTag(85, np.array([1.0, 2.0], "<f4").tobytes())
    one.session.receive(cbor2.dumps({"op": "publish", "topic": "scan", "msg": {"ranges": ranges}}))
    one.session.receive('{"op": "publish", "topic": "scan", "msg": {"ranges": [NaN, Infinity, 3]}}')
    assert [operation["msg"]["ranges"] for operation in two.received()] == [[1.0, 2.0], [None, None, 3.0]]


def test_fragments_are_put_together(pair):
    one, two = pair
    two.send("subscribe", topic="t", type="std_msgs/String")
    whole = json.dumps({"op": "publish", "topic": "t", "msg": {"data": "in three parts"}})
    parts = [whole[:10], whole[10:30], whole[30:]]
    for number in (2, 0, 1):
        one.send("fragment", id="f", data=parts[number], num=number, total=3)
    assert two.texts() == ["in three parts"]


def test_services_between_clients(pair):
    server, caller = pair
    server.send("advertise_service", service="/add", type="demo/Add")
    caller.send("call_service", service="add", id="call:1", args={"a": 1, "b": 2})
    (request,) = server.received()
    assert (request["op"], request["service"], request["args"]) == ("call_service", "/add", {"a": 1, "b": 2})
    server.send("service_response", service="/add", id=request["id"], values={"sum": 3}, result=True)
    assert caller.received() == [
        {"op": "service_response", "id": "call:1", "service": "add", "values": {"sum": 3}, "result": True}
    ]
    server.send("service_response", service="/add", id=request["id"], values={}, result=True)
    assert "no such call is waiting" in server.complaint()


def test_a_missing_service_and_one_whose_server_leaves_answer_false(pair):
    server, caller = pair
    caller.send("call_service", service="/nothing", id="1")
    server.send("advertise_service", service="slow", type="demo/Slow")
    caller.send("call_service", service="slow", id="2")
    server.session.close()
    caller.send("call_service", service="slow", id="3")
    answers = caller.received()
    assert [(answer["id"], answer["result"]) for answer in answers] == [("1", False), ("2", False), ("3", False)]
    assert "has left" in answers[1]["values"]


def test_a_service_cannot_be_taken_over(pair):
    one, two = pair
    one.send("advertise_service", service="mine", type="demo/Mine")
    assert two.send("advertise_service", service="/mine", type="demo/Mine").complaint() == (
        "service 'mine': /one offers it already"
    )
    one.send("unadvertise_service", service="mine")
    assert two.send("advertise_service", service="/mine", type="demo/Mine").received() == []


@pytest.mark.parametrize(
    ("frame", "complaint"),
    [
        ("", "not JSON"),
        ("[]", "must be a JSON object"),
        ("{}", "op = None: unknown"),
        ('{"op": ["publish"]}', "op = "),
        ('{"op": "publish", "topic": 3}', "topic = 3: must be a name"),
        ('{"op": "publish", "topic": "t", "msg": {}}', "its type is unknown"),
        ('{"op": "advertise", "topic": "t", "type": "nonsense"}', "type = 'nonsense': must be the name"),
        ('{"op": "advertise", "topic": "a b", "type": "std_msgs/String"}', "name without spaces"),
        ('{"op": "subscribe", "topic": "t", "compression": "zip"}', "compression = 'zip': must be one of"),
        ('{"op": "subscribe", "topic": "t", "throttle_rate": -1}', "throttle_rate = -1 ms"),
        ('{"op": "subscribe", "topic": "t", "throttle_rate": NaN}', "throttle_rate = nan"),
        ('{"op": "subscribe", "topic": "t", "id": {}}', "id = dict: must be a string"),
        ('{"op": "fragment", "id": "1", "data": "x", "num": 5, "total": 2}', "fragment.num = 5"),
        ('{"op": "fragment", "id": "1", "data": "x", "num": 0, "total": 1000000000}', "fragment.total"),
        ('{"op": "set_level", "level": "loud"}', "level = 'loud'"),
        ('{"op": "x", "a": ' + "[" * 40 + "]" * 40 + "}", "nested more than 32 deep"),
        ("[" * 3000, "not JSON"),
        ("NaN" + "[" * 3000, "not JSON"),
        ("[" * 100_000, "100000 lists and objects: must be 20000 at most"),
        (cbor2.dumps([1]), "must be a JSON object, or a CBOR map"),
        (b"\x9b" + b"\xff" * 8, "more items than it has bytes"),
        (b"\x5b" + b"\xff" * 8, "truncated CBOR"),
        (b"\xc2\x5b" + b"\x7f" * 8, "CBOR tag 2"),
        (b"\xc5\x82\x1b\x7f\xff\xff\xff\xff\xff\xff\xff\x01", "CBOR tag 5"),
        (b"\x81" * 200 + b"\x01", "nested more than 32 deep"),
        (b"\x9f\xff", "indefinite length"),
        ('{"op": "status", "id": "\\ud800", "a": NaN}', "half a surrogate pair"),
        ('{"op": "publish", "topic": "t", "a": [' + "NaN," * 60_000 + "1]}", "NaN or Infinity: must be 200000 at most"),
        (b"\x01\x01", "followed by further bytes"),
        (b"\xd8\x55\x43abc", "CBOR"),
        (b"", "truncated CBOR"),
    ],
)
def test_what_is_wrong_is_said(graph, frame, complaint):
    client = Client(graph)
    client.session.receive(frame)
    assert complaint in client.complaint()
    client.send("call_service", service="rosapi/none", id="1")
    assert client.received()[0]["result"] is False  # the session continues


def test_types_must_agree(pair):
    one, two = pair
    one.send("advertise", topic="t", type="std_msgs/String")
    assert two.send("subscribe", topic="t", type="std_msgs/UInt8").complaint() == (
        "topic 't' is std_msgs/String, not std_msgs/UInt8"
    )
    assert "msg.data = 3: must be a string" in one.send("publish", topic="t", msg={"data": 3}).complaint()


def test_status_carries_the_id_and_levels_are_kept(graph):
    client = Client(graph).send("publish", id="publish:1", topic="t", msg={})
    assert client.received()[0]["id"] == "publish:1"
    assert client.send("set_level", level="none").send("nonsense").received() == []


def test_limits_hold(graph):
    client = Client(graph, limits=Limits(names=2, fragmented_messages=2, frame_bytes=1000, replies=3))
    client.send("subscribe", topic="a").send("subscribe", topic="b")
    assert "you have 2 topics" in client.send("subscribe", topic="c").complaint()
    for identity in range(50):  # started, never finished
        client.send("fragment", id=str(identity), data="x" * 500, num=0, total=3)
    assert len(client.session._fragments._begun) == 2
    client.send("fragment", id="49", data="x" * 501, num=1, total=3)
    assert "more than 1000 bytes" in client.complaint()
    assert "must be 1000 at most" in client.send(frame="x" * 1001).complaint()
    for _ in range(10):
        client.send("call_service", service="none")
    assert (
        client.given_up == "3 answers of 0.0 MB are waiting to be read: you read too slowly" and client.received() == []
    )


def test_who_leaves_leaves_nothing_behind(graph):
    client = Client(graph)
    client.send("advertise", topic="a", type="std_msgs/String", latch=True).send("publish", topic="a", msg={})
    client.send("subscribe", topic="b").send("advertise_service", service="c", type="demo/C")
    client.session.close()
    assert (graph.topics, graph.services, graph.nodes) == ({}, {}, {})


def test_demand_is_told_when_it_begins_and_ends():
    demand = []
    graph = Graph()
    graph.on_demand.append(lambda name, wanted: demand.append((name, wanted)))
    one, two = Client(graph, "/1"), Client(graph, "/2")
    for client in (one, two):
        client.send("subscribe", topic="/t")
    one.send("unsubscribe", topic="/t")
    assert demand == [("t", True)]
    two.session.close()
    assert demand == [("t", True), ("t", False)]
