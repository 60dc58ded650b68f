"""The data a server stores for its clients is bounded in bytes, per client and in total, and freed on disconnect."""

import gc
import json
import logging
import socket
import weakref

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect as websocket

import rosbridge_session
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.rosbridge import Limits
from uwsim.bridges.rosbridge.graph import Graph
from uwsim.bridges.rosbridge.ledger import Ledger
from uwsim.bridges.rosbridge.parameters import LONGEST, MOST_BYTES, Parameters
from uwsim.bridges.rosbridge.session import Session
from waiting import until

MB = 1_000_000
LIMITS = Limits(client_bytes=5 * MB, mailbox_bytes=2 * MB)


class Client(rosbridge_session.Client):
    """A client within these limits."""

    def __init__(self, graph, name, limits=LIMITS):
        super().__init__(graph, name, limits=limits)

    def publish(self, topic, size, **options):
        self.send("advertise", topic=topic, type="std_msgs/String", **options)
        return self.send("publish", topic=topic, msg={"data": "x" * size})

    @property
    def bytes(self):
        return self.session._account.bytes


@pytest.fixture
def graph():
    return Graph(Ledger(12 * MB))


def test_a_topic_has_two_spellings_and_each_client_at_most_two_queues(graph):
    """10,000 spellings (//clock, ///clock, ...) used to create 10,000 queues of one topic and slow the simulator."""
    reader, publisher = Client(graph, "/reader"), Client(graph, "/publisher")
    for name in ("clock", "/clock", *("/" * k + "clock" for k in range(2, 100)), "/clock/", "a//clock"):
        reader.send("subscribe", topic=name, type="std_msgs/String")
    refusals = [json.loads(frame) for frame in reader.frames()]
    assert len(refusals) == 100 and all("without empty parts" in refusal["msg"] for refusal in refusals)
    publisher.publish("/clock", 1)
    assert [json.loads(frame)["topic"] for frame in reader.frames()] == ["clock", "/clock"]


def test_one_topic_s_large_messages_give_way_to_newer_ones(graph):
    reader, publisher = Client(graph, "/reader"), Client(graph, "/publisher")
    reader.send("subscribe", topic="t", type="std_msgs/String", queue_length=100)
    for k in range(50):
        publisher.publish("t", 200_000 + k)
        assert reader.bytes <= LIMITS.mailbox_bytes
    frames = reader.frames()
    assert len(json.loads(frames[-1])["msg"]["data"]) == 200_049 and reader.session.outbox.lost == 50 - len(frames)
    assert not reader.given_up and reader.bytes == 0 and graph.ledger.bytes == 0


def test_a_message_that_is_larger_than_all_that_may_wait_is_sent_alone(graph):
    limits = Limits(client_bytes=100_000, mailbox_bytes=50_000)
    reader, publisher = Client(graph, "/reader", limits), Client(graph, "/publisher")
    reader.send("subscribe", topic="t", type="std_msgs/String")
    for _ in range(3):
        publisher.publish("t", 300_000)
    assert len(reader.frames()) == 1 and not reader.given_up


def test_a_reader_of_many_topics_that_does_not_read_must_go(graph):
    reader, publisher = Client(graph, "/reader"), Client(graph, "/publisher")
    for k in range(20):
        reader.send("subscribe", topic=f"t{k}", type="std_msgs/String")
    for k in range(60):
        publisher.publish(f"t{k % 20}", 300_000)
        assert reader.bytes <= LIMITS.client_bytes + 2 * MB
    assert "wait to be read, of 5 that may: you read too slowly" in reader.given_up
    assert reader.bytes == graph.ledger.bytes == 0 and not publisher.given_up
    publisher.send("status", msg="still here")
    assert reader.send("subscribe", topic="more").frames() == []


def test_answers_are_counted_in_bytes(graph):
    asker = Client(graph, "/asker", Limits(client_bytes=1 * MB, frame_bytes=200_000))
    graph.advertise_service("/us", "echo", "demo/Echo", lambda arguments, reply, caller: reply(True, arguments))
    for _ in range(1100):
        asker.send("call_service", service="echo", args={"a": "x" * 100_000})
        assert asker.bytes <= 1.3 * MB
    assert asker.given_up == "1000 answers are waiting to be read, the maximum" and graph.ledger.bytes == 0


def test_what_is_kept_for_all_is_bounded_and_the_largest_goes(graph):
    limits = Limits(client_bytes=100 * MB, mailbox_bytes=100 * MB)
    readers = [Client(graph, f"/reader{k}", limits) for k in range(4)]
    publisher = Client(graph, "/publisher", limits)
    for k, reader in enumerate(readers):
        reader.send("subscribe", topic=f"t{k}", type="std_msgs/String", queue_length=1000)
    for k in range(200):
        publisher.publish(f"t{(0, 1, 1, 2, 3)[k % 5]}", 300_000)  # the second client gets the most
        assert graph.ledger.bytes <= graph.ledger.limit + 1 * MB
    assert "of them are yours" in readers[1].given_up and not publisher.given_up


def test_a_message_for_many_is_in_memory_once(graph):
    readers = [Client(graph, f"/reader{k}").send("subscribe", topic="t", type="std_msgs/String") for k in range(20)]
    Client(graph, "/publisher").publish("t", 500_000)
    assert graph.ledger.bytes < 2 * MB < sum(reader.bytes for reader in readers)
    for reader in readers:
        reader.frames()
    assert graph.ledger.bytes == 0


def test_latched_messages_are_bounded_and_go_with_their_owner(graph):
    publisher = Client(graph, "/publisher")
    for k in range(50):
        publisher.publish(f"t{k}", 300_000, latch=True)
        assert publisher.bytes <= LIMITS.client_bytes
    assert "no room to latch it" in publisher.frames()[0]
    other = Client(graph, "/other").send("advertise", topic="t0", type="std_msgs/String", latch=True)
    publisher.session.close()
    assert graph.topics["t0"].latched is None and graph.ledger.bytes == 0
    other.session.close()


def test_unanswered_calls_are_bounded_and_go_with_their_caller(graph):
    server, caller = Client(graph, "/server"), Client(graph, "/caller")
    server.send("advertise_service", service="never", type="demo/Never")
    for k in range(100):
        caller.send("call_service", service="never", id=str(k), args={"a": "x" * 300_000})
        server.frames()
        assert caller.bytes <= LIMITS.client_bytes + 1 * MB
    assert "no room to keep the call" in caller.frames()[0]
    caller.session.close()
    assert server.session._calls._received == {} and server.bytes == graph.ledger.bytes == 0


def test_fragments_are_bounded_with_all_else_and_go_with_their_client(graph):
    client = Client(graph, "/client", Limits(client_bytes=1 * MB))
    for k in range(20):
        client.send("fragment", id=str(k % 4), num=k // 4, total=9, data="x" * 300_000)
        assert client.bytes <= 1 * MB
    assert "no room to keep them" in client.frames()[0]
    client.session.close()
    assert graph.ledger.bytes == 0


def test_ids_are_short_and_few(graph):
    client = Client(graph, "/client")
    client.send("subscribe", topic="t", type="std_msgs/String", id="x" * 257)
    assert json.loads(client.frames()[0])["msg"] == "id: 257 characters: must be 256 at most"
    for k in range(200):
        client.send("subscribe", topic="t", type="std_msgs/String", id=str(k))
    assert (
        len(client.session._topics._names.subscriptions["t"].ids) == LIMITS.ids and "the maximum" in client.frames()[0]
    )


def test_parameters_are_bounded_in_bytes():
    parameters = Parameters({})
    text = json.dumps("x" * (LONGEST - 2))
    with pytest.raises(ValueError, match=f"must be {MOST_BYTES} at most"):
        for k in range(10_000):
            parameters.set_json(str(k), text)
    count = len(parameters.names())
    assert count < MOST_BYTES / LONGEST
    parameters.set_json("0", "1")
    parameters.set_json("more", "1")
    for name in parameters.names():
        parameters.delete(name)
    assert parameters._bytes == 0
    with pytest.raises(ValueError, match="decoded"):
        parameters.set_json("deep", f"[{','.join(['{}'] * 15_000)}]")


def test_a_session_is_freed_when_it_ends(graph):
    """No reference cycle keeps the session and its data alive until the garbage collector runs."""
    gc.collect()
    gc.disable()
    try:
        other = Client(graph, "/other").send("advertise_service", service="never", type="demo/Never")
        ended = []
        for given_up in (False, True):
            session = Session(graph, "/client", limits=LIMITS)
            for operation in (
                {"op": "advertise", "topic": "t", "type": "std_msgs/String", "latch": True},
                {"op": "publish", "topic": "t", "msg": {"data": "x"}},
                {"op": "subscribe", "topic": "t"},
                {"op": "advertise_service", "service": "own", "type": "demo/Own"},
                {"op": "call_service", "service": "never", "id": "1", "args": {}},
                {"op": "fragment", "id": "1", "num": 0, "total": 2, "data": "x"},
                {"op": "nonsense"},
            ):
                session.receive(json.dumps(operation))
            other.send("call_service", service="own", id="2", args={})
            if given_up:
                session._account.give_up("slow")
            session.close()
            ended.append(weakref.ref(session))
            del session
        assert [reference() for reference in ended] == [None, None]
        assert graph.ledger.accounts == {other.session._account}
    finally:
        gc.enable()


def sessions():
    return sum(type(each) is Session for each in gc.get_objects())


def test_a_server_s_sessions_are_freed_when_their_clients_leave():
    with RosbridgeServer(None) as server:
        until(lambda: not server.sessions)
        gc.collect()
        gc.disable()
        try:
            before = sessions()
            for _ in range(20):
                with websocket(server.url) as client:
                    client.send('{"op":"subscribe","topic":"/t","type":"std_msgs/String"}')
                    client.send("nonsense")
                    client.recv(10.0)
            until(lambda: not server.sessions and sessions() <= before)
        finally:
            gc.enable()


def test_a_slow_reader_is_told_why_it_must_go(caplog):
    """The reason is logged and sent in the close frame, which the client reads after messages already in transit."""
    caplog.set_level(logging.WARNING)
    limits = Limits(client_bytes=4 * MB, mailbox_bytes=1 * MB)
    with RosbridgeServer(None, limits=limits) as server, websocket(server.url, max_size=None) as publisher:
        with websocket(server.url, max_queue=1, max_size=None, ping_interval=None) as reader:
            for k in range(20):
                reader.send(json.dumps({"op": "subscribe", "topic": f"/t{k}", "type": "std_msgs/String"}))
            until(lambda: sum(len(topic.sinks) for topic in server.graph.topics.values() if topic.name[0] == "t") >= 20)
            for k in range(20):
                publisher.send(json.dumps({"op": "advertise", "topic": f"/t{k}", "type": "std_msgs/String"}))
            for k in range(60):
                publisher.send(json.dumps({"op": "publish", "topic": f"/t{k % 20}", "msg": {"data": "x" * 1_000_000}}))
                if "you read too slowly" in caplog.text:
                    break
            until(lambda: "you read too slowly" in caplog.text)
            with pytest.raises(ConnectionClosed) as closed:
                while True:
                    reader.recv(10.0)
            if closed.value.rcvd is not None:  # absent if the connection had to be cut
                assert closed.value.rcvd.code == 1008 and "you read too slowly" in closed.value.rcvd.reason
        until(lambda: len(server.sessions) == 1 and server.graph.ledger.bytes == 0)


def test_a_message_in_very_many_frames_is_refused():
    """Each frame of a fragmented message is an object, even an empty one."""
    with RosbridgeServer(None) as server, websocket(server.url) as client:
        with pytest.raises(ConnectionClosed) as closed:
            client.send("" for _ in range(5000))
            client.recv(10.0)
        assert closed.value.rcvd is not None and "more than 1000 frames" in closed.value.rcvd.reason


def test_pongs_that_nobody_reads_are_bounded():
    handshake = (
        "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    ping = b"\x89\xfd" + bytes(4) + b"x" * 125
    with RosbridgeServer(None) as server, socket.create_connection(("127.0.0.1", server.port)) as client:
        client.settimeout(60.0)
        client.sendall(handshake.encode())
        until(lambda: len(server.sessions) == 1)
        with pytest.raises(ConnectionError):
            for _ in range(400):
                client.sendall(ping * 1000)
        until(lambda: not server.sessions)
