"""The server's rosbridge extensions: credit, cumulative topics, guests, a change of simulator, admission."""

import json
from concurrent.futures import Future

import pytest
from websockets.datastructures import Headers

from client_socket import connect
from rosbridge_session import Client
from uwsim import Simulator
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.doors.admission import Door
from uwsim.bridges.rosbridge.encoding import Growing
from uwsim.bridges.rosbridge.graph import Graph
from uwsim.channels import Table
from uwsim.channels.guest import GuestService, GuestTopic
from uwsim.channels.ros.build import text
from uwsim.live import LiveSimulator


def test_no_more_messages_are_on_their_way_than_the_credit():
    graph = Graph()
    reader = Client(graph, "/r").send("subscribe", topic="t", type="std_msgs/String", queue_length=100, credit=2)
    writer = Client(graph, "/w").send("advertise", topic="t", type="std_msgs/String")
    for k in range(5):
        writer.send("publish", topic="t", msg={"data": str(k)})
    assert reader.texts() == ["0", "1"]
    assert reader.send("ack", topic="t").texts() == ["2"]
    assert reader.send("ack", topic="t", count=2).texts() == ["3", "4"]
    assert "do not subscribe" in reader.send("ack", topic="other").complaint()
    assert "must be in [1, 100]" in reader.send("ack", topic="t", count=-1).complaint()
    assert "credit" in Client(graph, "/x").send("subscribe", topic="t", credit=0).complaint()


def test_a_slow_reader_of_a_topic_that_builds_up_misses_nothing():
    graph, said = Graph(), []
    reader = Client(graph, "/r").send("subscribe", topic="t", type="std_msgs/String", credit=1)
    topic = graph.advertise("/uwsim", "t", "std_msgs/String", latch=True)

    def catch_up(cursor):
        return text("".join(said[cursor or 0 :])), len(said)

    heard = ""
    for k in range(9):
        said.append(str(k))
        graph.publish(topic, Growing(catch_up), latch=True)
        heard += "".join(reader.texts())
        if k % 3 == 2:
            reader.send("ack", topic="t")
    assert heard + "".join(reader.texts()) == "012345678"
    late = Client(graph, "/late").send("subscribe", topic="t")
    assert late.texts() == ["012345678"]


class Parrot:
    name = "/parrot"

    def __init__(self):
        self.gone = []
        self.services = [
            GuestService("parrot/repeat", "demo/Repeat", self.repeat),
            GuestService("parrot/later", "demo/Later", self.later, is_brief=True),
        ]

    def connect(self, node):
        self.node = node
        node.offer_topics([GuestTopic("parrot/says", "std_msgs/msg/String", latched=True)])

    def demanded(self):
        pass

    def left(self, client):
        self.gone.append(client)

    def repeat(self, caller, request):
        if not request:
            raise ValueError("nothing to repeat")
        self.node.publish("parrot/says", text(request["what"]))
        return {"to": caller}

    def later(self, caller, request):
        answer = Future()
        answer.set_result({"to": caller})
        return answer


def ask(client, op, **fields):
    client.send(json.dumps({"op": op, "id": "?", **fields}))
    while (answer := json.loads(client.recv(60.0))).get("id") != "?":
        pass
    return answer


def test_a_guest_knows_who_calls_and_who_leaves():
    parrot = Parrot()
    with RosbridgeServer(None, guests=[parrot]) as server, connect(server.url) as client:
        name = ask(client, "call_service", service="/parrot/later")["values"]["to"]
        assert list(server.sessions) == [name]
        answer = ask(client, "call_service", service="/parrot/repeat", args={"what": "hello"})
        assert answer["values"] == {"to": name}
        assert ask(client, "call_service", service="/parrot/repeat")["values"] == "nothing to repeat"
        client.send(json.dumps({"op": "subscribe", "topic": "/parrot/says"}))
        assert json.loads(client.recv(60.0))["msg"] == {"data": "hello"}
        assert parrot.node.is_wanted("parrot/says") and parrot.node.is_awaited("parrot/says")
    assert parrot.gone == [name]


def test_clients_stay_subscribed_when_another_simulator_comes():
    with RosbridgeServer(None) as server, connect(server.url) as client:
        client.send(json.dumps({"op": "subscribe", "topic": "/clock"}))
        for _ in range(2):
            sim = Simulator("pool")
            with LiveSimulator(sim, speed=5.0) as live:
                table = Table(sim)
                server.show(live, table.channels, table.services)
                assert json.loads(client.recv(60.0))["topic"] == "/clock"
                server.show(None, [], [])
                offered = ask(client, "call_service", service="/rosapi/services")["values"]["services"]
                assert not [name for name in offered if "simulation" in name]


@pytest.mark.parametrize(
    ("host", "origin", "is_socket", "status"),
    [
        ("127.0.0.1:9090", None, False, None),
        ("localhost", "http://localhost:8080", True, None),
        ("[::1]:9090", "http://[::1]:9090", True, None),
        ("192.168.0.7:9090", "http://192.168.0.7:9090", True, None),  # the server's own page, opened by IP address
        ("lab.example", "https://lab.example", True, None),
        ("simulator:9090", None, True, None),  # a program in a container, not a browser
        ("simulator:9090", None, False, 403),
        ("evil.example", "http://evil.example", True, 403),  # a hostile name that resolves to this machine
        ("127.0.0.1:9090", "http://evil.example", True, 403),
        ("127.0.0.1:9090", "null", True, 403),
        ("127.0.0.1:9090", "http://evil.example", False, 403),
    ],
)
def test_the_door(host, origin, is_socket, status):
    headers = Headers([("Host", host), *([("Origin", origin)] if origin else [])])
    door = Door(["https://lab.example"], "127.0.0.1")
    refusal = door.refusal(headers, names_matter=not is_socket)
    assert (refusal and refusal[0].value) == status
