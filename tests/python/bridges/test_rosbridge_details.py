"""Details of the rosbridge protocol: ids, compression, stamps, calls whose provider goes."""

import base64
import io
import json

import pytest
from PIL import Image

from rosbridge_session import Client
from uwsim.bridges.rosbridge.encoding import to_png
from uwsim.bridges.rosbridge.graph import Graph


@pytest.fixture
def graph():
    return Graph()


@pytest.fixture
def pair(graph):
    return Client(graph, "/one"), Client(graph, "/two")


def texts(client):
    return [operation["msg"]["data"] for operation in client.received()]


def test_only_the_subscription_with_the_id_ends_and_without_an_id_all_do(pair):
    one, two = pair
    one.send("advertise", topic="t", type="std_msgs/UInt8")
    for identity in ("a", "b"):
        two.send("subscribe", topic="t", id=identity)
    assert "no subscription with id 'c'" in two.send("unsubscribe", topic="t", id="c").complaint()
    one.send("publish", topic="t", msg={"data": 1})
    assert texts(two) == [1]
    two.send("unsubscribe", topic="t")
    one.send("publish", topic="t", msg={"data": 2})
    assert texts(two) == []


def test_operations_may_come_as_png_whole_or_in_fragments(pair):
    one, two = pair
    two.send("subscribe", topic="t", type="std_msgs/String")
    one.send("advertise", topic="t", type="std_msgs/String")

    def data(text):
        return json.loads(to_png(json.dumps({"op": "publish", "topic": "t", "msg": {"data": text}})))["data"]

    one.send("png", data=data("whole"))
    whole = data("in pieces")
    for number, part in enumerate((whole[:50], whole[50:])):
        one.send("png", id="x", data=part, num=number, total=2)
    assert texts(two) == ["whole", "in pieces"]
    assert "not a PNG" in one.send("png", data="bm90IGEgUE5H").complaint()
    bomb = io.BytesIO()
    Image.new("RGB", (2000, 2000)).save(bomb, "PNG")
    assert len(bomb.getvalue()) < 100_000
    assert "12000000 bytes of pixels" in one.send("png", data=base64.b64encode(bomb.getvalue()).decode()).complaint()


def test_a_header_without_a_stamp_gets_the_present_time(graph):
    graph.time_ns = lambda: 7_000_000_005
    publisher = Client(graph, "/p").send("advertise", topic="t", type="geometry_msgs/PoseStamped")
    reader = Client(graph, "/r").send("subscribe", topic="t")
    for header in ({"frame_id": "map"}, {"stamp": {"secs": 1, "nsecs": 2}}):
        publisher.send("publish", topic="t", msg={"header": header})
    stamps = [operation["msg"]["header"]["stamp"] for operation in reader.received()]
    assert stamps == [{"secs": 7, "nsecs": 5}, {"secs": 1, "nsecs": 2}]


def test_an_open_call_fails_when_its_provider_unadvertises_the_service(pair):
    one, two = pair
    one.send("advertise_service", service="/add", type="std_srvs/Trigger")
    two.send("call_service", service="/add", id="1")
    (request,) = one.received()
    one.send("unadvertise_service", service="add")
    (answer,) = two.received()
    assert answer["result"] is False and "ceased to offer it" in answer["values"]
    assert "no such call is waiting" in one.send("service_response", id=request["id"], service="/add").complaint()


def test_the_level_is_set_by_either_name(pair):
    one, _ = pair
    for op in ("set_level", "set_status_level"):
        one.send(op, level="none").send("nonsense")
        assert one.received() == []
        one.send(op, level="error").send("nonsense")
        assert "unknown" in one.complaint()
