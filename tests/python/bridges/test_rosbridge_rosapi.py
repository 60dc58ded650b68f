"""rosapi: client queries about the graph, its types and its parameters."""

import json

import pytest

from uwsim.bridges.rosbridge.parameters import Parameters
from uwsim.bridges.rosbridge.rosapi import offer_rosapi
from uwsim.bridges.rosbridge.session import Session


def send(session, op, **fields):
    session.receive(json.dumps({"op": op, **fields}))
    return session


@pytest.fixture
def ask(graph):
    """Return a function that calls a rosapi service and returns the response's values."""
    offer_rosapi(graph, Parameters({}), 1, lambda: 12_000_000_034)
    asker = Session(graph, "/asker")

    def call(query, expected=True, **args):
        send(asker, "call_service", service=f"/rosapi/{query}", args=args)
        answer = json.loads(asker.outbox.take()[0])
        assert answer["result"] is expected
        return answer["values"]

    return call


def test_rosapi_knows_the_graph(ask, graph):
    send(Session(graph, "/p"), "advertise", topic="t", type="std_msgs/String")
    other = send(Session(graph, "/s"), "subscribe", topic="t")
    send(other, "advertise_service", service="go", type="demo/Go")
    assert ask("topics") == {"topics": ["/rosout", "/t"], "types": ["rosgraph_msgs/Log", "std_msgs/String"]}
    assert ask("topic_type", topic="t") == {"type": "std_msgs/String"}
    assert ask("topics_for_type", type="std_msgs/msg/String") == {"topics": ["/t"]}
    assert ask("publishers", topic="/t") == {"publishers": ["/p"]}
    assert ask("subscribers", topic="/t") == {"subscribers": ["/s"]}
    assert {"/p", "/s", "/rosapi"} <= set(ask("nodes")["nodes"])
    assert ask("node_details", node="/s") == {"subscribing": ["/t"], "publishing": [], "services": ["/go"]}
    assert {"/go", "/rosapi/topics"} <= set(ask("services")["services"])
    assert ask("service_type", service="/go") == {"type": "demo/Go"}
    assert ask("services_for_type", type="demo/Go") == {"services": ["/go"]}
    for service in ("demo/Go", "/go"):
        assert ask("service_providers", service=service) == {"providers": ["/s"]}
    assert {"std_msgs/String", "demo/Go", "rosapi/Topics"} <= set(ask("interfaces")["interfaces"])
    assert ask("get_ros_version") == {"version": 1, "distro": "noetic"}
    assert ask("service_type", service="/rosapi/get_ros_version") == {"type": "rosapi/GetROSVersion"}
    assert ask("get_time") == {"time": {"secs": 12, "nsecs": 34}}
    assert "string data" in ask("topics_and_raw_types")["typedefs_full_text"][1]


def test_what_is_refused_is_in_the_graphs_log(ask, graph):
    reader = send(Session(graph, "/reader"), "subscribe", topic="/rosout")
    send(Session(graph, "/p"), "publish", topic="t", msg={})
    line = json.loads(reader.outbox.take()[0])["msg"]
    assert (line["level"], line["msg"]) == (4, "/p: topic 't': advertise it first, because its type is unknown")


def test_arguments_may_be_a_list(graph):
    offer_rosapi(graph, Parameters({"depth": 3}), 1, lambda: 0)
    asker = Session(graph, "/asker")

    def call(query, args):
        send(asker, "call_service", service=f"/rosapi/{query}", args=args)
        return json.loads(asker.outbox.take()[0])

    assert call("has_param", ["/depth"])["values"] == {"exists": True}
    refused = call("has_param", ["/depth", 2])
    assert not refused["result"] and "service 'rosapi/has_param': 2 args: must be 1 at most: name" in refused["values"]


def test_rosapi_knows_types(ask):
    first, *inner = ask("message_details", type="sensor_msgs/LaserScan")["typedefs"]
    assert first["type"] == "sensor_msgs/LaserScan"
    assert first["fieldnames"][:2] == ["header", "angle_min"] and first["fieldnames"][-2] == "ranges"
    assert first["fieldarraylen"][-2:] == [0, 0] and first["fieldarraylen"][0] == -1
    assert inner[0]["type"] == "std_msgs/Header"
    (trigger,) = ask("service_response_details", type="std_srvs/Trigger")["typedefs"]
    assert trigger["fieldnames"] == ["success", "message"]
    assert "unknown message type" in ask("message_details", expected=False, type="demo/Nothing")


def test_parameters_are_json_and_a_missing_one_is_null(ask):
    assert ask("get_param", name="/gain") == {"value": "null"}
    assert ask("get_param", name="gain", default="2.5") == {"value": "2.5"}
    ask("set_param", name="/gain", value='{"p": 1.5}')
    assert json.loads(ask("get_param", name="gain")["value"]) == {"p": 1.5}
    assert ask("has_param", name="gain") == {"exists": True}
    assert ask("get_param_names") == {"names": ["/gain"]}
    assert "not JSON" in ask("set_param", expected=False, name="gain", value="{")
    ask("delete_param", name="gain")
    assert ask("get_param_names") == {"names": []}
