"""A server's memory is bounded: a frame's by its size, a queue's by number and bytes, all of it by equal shares.

It is freed when a client leaves. What is decoded is traced; the whole is measured as a process's memory.
"""

import gc
import json
import logging
import socket
import subprocess
import sys
import time
import tracemalloc
import weakref
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

import cbor2
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect as websocket

import rosbridge_session
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.doors.conversation import PIECE
from uwsim.bridges.rosbridge import Limits
from uwsim.bridges.rosbridge.encoding import held_bytes
from uwsim.bridges.rosbridge.graph import Graph
from uwsim.bridges.rosbridge.limits import DECODED
from uwsim.bridges.rosbridge.parameters import LONGEST, MOST_BYTES, Parameters
from uwsim.bridges.rosbridge.parse import walk_cbor
from uwsim.bridges.rosbridge.session import Session
from uwsim.channels.ros.message_in import messages_in
from uwsim.channels.ros.messages import default_message, typestore
from waiting import until

MB = 1_000_000
LIMITS = Limits(client_bytes=10 * MB, total_bytes=24 * MB)
FRAME = Limits().frame_bytes
MESSAGE_BYTES = 3500  # of a message with empty lists, for each of the messages in it


class Client(rosbridge_session.Client):
    """A client within these limits."""

    def __init__(self, graph, name, limits=LIMITS):
        super().__init__(graph, name, limits=limits)

    def publish(self, topic, size, **options):
        self.send("advertise", topic=topic, type="std_msgs/String", **options)
        return self.send("publish", topic=topic, msg={"data": "x" * size})

    @property
    def bytes(self):
        return self.session.outbox.room.bytes + self.session.outbox.kept.bytes


def full(element, head='{"op":"publish","topic":"t","msg":{"a":[', tail="]}}"):
    """Return the largest frame of JSON that consists of these elements."""
    return head + ",".join([element] * ((FRAME - len(head) - len(tail)) // (len(element) + 1))) + tail


def cbor_array(item, count):
    """Return {"a": [item, ...]}, for which cbor2 itself would take seconds."""
    return b"\xa1\x61a\x9a" + count.to_bytes(4) + item * count


def keys(form):
    return "{" + ",".join(f"{form % k}:0" for k in range(FRAME // (len(form % 0) + 8))) + "}"


MARKERS, POSES = (f'{{"op":"publish","topic":"{name}","msg":{{"{name}":[' for name in ("markers", "poses"))
HOSTILE = {
    "lists": (full("[]"), "lists and objects: must"),
    "objects": (full('{"x":1}'), "lists and objects: must"),
    "lists within the limit": (full("[]", '{"a":[')[: 3 * 19_000].rstrip(",") + "]}", "op = None"),
    "numbers": (full("0"), "advertise it first"),
    "fractions": (full("1.5"), "advertise it first"),
    "empty texts": (full('""'), "advertise it first"),
    "short texts": (full('"ab"'), "advertise it first"),
    "keys": (keys('"%x"'), "op = None"),
    "long keys": (keys('"%070x"'), "op = None"),
    "deep": ('{"a":' + "[" * 100_000 + "]" * 100_000 + "}", "lists and objects: must"),
    "deep within the limit": ('{"a":' + "[" * 900 + "]" * 900 + "}", "nested more than 32 deep"),
    "deeper than the decoder": ('{"a":' + "[" * 9000 + "]" * 9000 + "}", "not JSON"),
    "many words": (full("NaN"), "bytes with NaN or Infinity: must be 200000 at most"),
    "markers": (full("{}", MARKERS), "lists and objects: must"),
    "markers within the limit": (full("{}", MARKERS)[: 3 * 19_000].rstrip(",") + "]}}", "a message of more than 20000"),
    "poses": (full("{}", POSES)[: 3 * 2500].rstrip(",") + "]}}", None),
    "CBOR lists": (cbor_array(b"\x80", 1_900_000), "more than 100000 items"),
    "CBOR numbers": (cbor_array(b"\x00", 1_900_000), "more than 100000 items"),
    "CBOR lists in lists": (b"\xa1\x61a" + b"\x81" * 1000 + b"\x80", "nested more than 32"),
    "CBOR tags": (cbor_array(b"\xd8\x40\x40", 90_000), "more than 100000 items"),
    "CBOR of no end": (b"\xa1\x61a\x9f" + b"\x00" * 100, "indefinite length"),
}
"""Frames of which a client can expect more memory than they have bytes, and what the server answers."""


def publisher(name="t", kind="nav_msgs/Path"):
    session = Session(Graph(), "/one")
    session.receive(json.dumps({"op": "advertise", "topic": name, "type": kind}))
    return session


@pytest.mark.parametrize("what", HOSTILE)
def test_a_frame_takes_a_bounded_multiple_of_its_size(what):
    frame, error = HOSTILE[what]
    session = publisher("poses")
    session.receive(json.dumps({"op": "advertise", "topic": "markers", "type": "visualization_msgs/MarkerArray"}))
    session.receive(frame[:100])  # triggers lazy imports
    session.outbox.take()
    tracemalloc.start()
    session.receive(frame)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most <= DECODED * len(frame) + MESSAGE_BYTES * LIMITS.objects
    answer, _ = session.outbox.take()
    assert answer is None if error is None else error in json.loads(answer)["msg"]


def test_a_message_of_any_type_takes_little_memory_for_each_of_those_in_it():
    for name in sorted(typestore().fielddefs):
        made = [default_message(name) for _ in range(50)]  # the first instances of a class have separate dicts
        tracemalloc.start()
        made = [default_message(name) for _ in range(50)]
        held = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
        assert held / 50 <= MESSAGE_BYTES * messages_in(name), name
        assert held / 50 <= 1.3 * held_bytes(made[0]) + 100, name


def test_a_walk_over_cbor_ends_where_it_holds_too_much():
    """Refusing a frame of two million empty lists used to take 2.7 s."""

    class Counted(bytes):
        looks = 0

        def __getitem__(self, index):
            Counted.looks += 1
            return super().__getitem__(index)

    for data in (cbor2.dumps([[]] * 200_000), b"\x81" * 3 + cbor2.dumps([[[]] * 10] * 20_000)):
        Counted.looks = 0
        with pytest.raises(ValueError, match="more than"):
            walk_cbor(Counted(data), 32, 100_000)
        assert Counted.looks < 300_000


POINT, TURN = {"x": 1.25, "y": 2.5, "z": 3.75}, {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
HEADER = {"stamp": {"secs": 1, "nsecs": 2}, "frame_id": "odom"}
POSE = {"header": HEADER, "pose": {"position": POINT, "orientation": TURN}}
POINTS = np.linspace(1.0, 2.0, 500_000, dtype="<f4").tobytes()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("sensor_msgs/msg/Image", {"data": "AAAA" * 500_000}),
        ("sensor_msgs/msg/Image", {"data": b"\0" * 2_000_000}),
        ("sensor_msgs/msg/Image", {"data": [0] * 900_000}),
        ("sensor_msgs/msg/PointCloud2", {"data": "AAAA" * 500_000}),
        ("sensor_msgs/msg/LaserScan", {"ranges": cbor2.CBORTag(85, POINTS)}),
        ("sensor_msgs/msg/LaserScan", {"ranges": [1.25] * 400_000}),
        ("nav_msgs/msg/OccupancyGrid", {"data": [-1] * 300_000}),
        ("nav_msgs/msg/Path", {"poses": [POSE] * 1500}),
        ("std_msgs/msg/String", {"data": "é" * 900_000}),
        ("std_msgs/msg/String", {"data": "1e5.," * 300_000}),
    ],
)
def test_large_messages_are_taken(name, message):
    operation = {"op": "publish", "topic": "t", "msg": message}
    is_binary = isinstance(next(iter(message.values())), bytes | cbor2.CBORTag)
    text = json.dumps(operation, separators=(",", ":"), ensure_ascii=False) if not is_binary else ""
    session = publisher("t", name)
    session.receive(cbor2.dumps(operation) if is_binary else text)
    assert session.outbox.take() == (None, None)


def test_fragments_are_held_to_the_same():
    session, frame = publisher(), full("[]")
    for k in range(4):
        part = frame[k * len(frame) // 4 : (k + 1) * len(frame) // 4]
        session.receive(json.dumps({"op": "fragment", "id": "f", "num": k, "total": 4, "data": part}))
    assert "lists and objects: must be 20000" in json.loads(session.outbox.take()[0])["msg"]


SERVER = """
from pathlib import Path
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.rosbridge import Limits

def most():
    return int(Path("/proc/self/status").read_text().partition("VmHWM:")[2].split()[0]) << 10

limits = Limits(connections=4, total_bytes=16 << 20, bytes_per_s=1e9, messages_per_s=1e6, work_share=10.0)
with RosbridgeServer(None, limits=limits) as server:
    before = most()
    input(f"{server.url}\\n")
    print(most() - before, limits.most_bytes)
"""


def attack(url):
    with websocket(url, max_queue=1, ping_interval=None, close_timeout=0.1) as foe, suppress(ConnectionClosed):
        for op in ("subscribe", "advertise"):
            foe.send(json.dumps({"op": op, "topic": "poses", "type": "nav_msgs/Path", "queue_length": 1000}))
        for frame, error in (*HOSTILE.values(), *40 * [HOSTILE["poses"]]):
            if "lists and objects" not in str(error):
                foe.send(frame)
        time.sleep(1.0)


def test_hostile_clients_together_take_no_more_memory_than_is_stated():
    command = [sys.executable, "-c", SERVER]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        url = server.stdout.readline().strip()
        with ThreadPoolExecutor() as foes:
            list(foes.map(attack, 4 * [url]))
        grown, stated = map(int, server.communicate("\n")[0].split())
    assert 0 < grown <= stated, f"{grown / 1e6:.0f} MB of {stated / 1e6:.0f}"


@pytest.mark.parametrize("data", ["x" * 1_500_000, b"\x07" * 1_500_000])
def test_a_large_message_is_sent_in_several_frames_so_that_no_write_is_long(data):
    kind = "std_msgs/String" if isinstance(data, str) else "std_msgs/UInt8MultiArray"
    with (
        RosbridgeServer(None) as server,
        websocket(server.url, max_size=None) as reader,
        websocket(server.url) as writer,
    ):
        reader.send(json.dumps({"op": "subscribe", "topic": "t", "type": kind, "compression": "cbor"}))
        writer.send(json.dumps({"op": "advertise", "topic": "t", "type": kind}))
        writer.send(cbor2.dumps({"op": "publish", "topic": "t", "msg": {"data": data}}))
        parts = list(reader.recv_streaming())
    assert max(map(len, parts)) <= PIECE
    assert cbor2.loads(b"".join(parts))["msg"]["data"] == data


def test_a_topic_has_two_spellings_and_each_client_at_most_two_queues(graph):
    """10,000 spellings (//clock, ///clock, ...) used to create 10,000 queues of one topic and slow the simulator."""
    reader, publisher = Client(graph, "/reader"), Client(graph, "/publisher")
    for name in ("clock", "/clock", *("/" * k + "clock" for k in range(2, 100)), "/clock/", "a//clock"):
        reader.send("subscribe", topic=name, type="std_msgs/String")
    refusals = [json.loads(frame) for frame in reader.frames()]
    assert len(refusals) == 100 and all("without empty parts" in refusal["msg"] for refusal in refusals)
    publisher.publish("/clock", 1)
    assert [json.loads(frame)["topic"] for frame in reader.frames()] == ["clock", "/clock"]


@pytest.mark.parametrize("topics", [1, 20])
def test_a_reader_that_does_not_read_loses_its_oldest_messages(graph, topics):
    reader, publisher = Client(graph, "/reader"), Client(graph, "/publisher")
    for k in range(topics):
        reader.send("subscribe", topic=f"t{k}", type="std_msgs/String", queue_length=100)
    for k in range(60):
        publisher.publish(f"t{k % topics}", 300_000 + k)
        assert reader.bytes <= LIMITS.client_bytes
    frames = reader.frames()
    assert [len(json.loads(frame)["msg"]["data"]) - 300_000 for frame in frames] == list(range(60 - len(frames), 60))
    assert len(frames) > 5 and reader.session.outbox.lost == 60 - len(frames)
    assert reader.bytes == 0 and not reader.given_up


def test_a_message_that_is_larger_than_all_that_may_wait_is_sent_alone(graph):
    reader, publisher = Client(graph, "/reader", Limits(client_bytes=100_000)), Client(graph, "/publisher")
    reader.send("subscribe", topic="t", type="std_msgs/String")
    for _ in range(3):
        publisher.publish("t", 300_000)
    assert len(reader.frames()) == 1 and not reader.given_up


def test_answers_are_counted_in_bytes(graph):
    asker = Client(graph, "/asker", Limits(client_bytes=1 * MB, frame_bytes=200_000))
    graph.advertise_service("/us", "echo", "demo/Echo", lambda arguments, reply, caller: reply(True, arguments))
    for _ in range(20):
        asker.send("call_service", service="echo", args={"a": "x" * 100_000})
        assert asker.bytes <= 1 * MB
    assert asker.given_up == "4 answers of 0.4 MB are waiting to be read: you read too slowly" and asker.bytes == 0


def test_all_clients_have_equal_shares_of_what_is_kept_in_total(graph):
    publisher, readers = Client(graph, "/publisher"), []
    for n in range(8):
        readers.append(Client(graph, f"/reader{n}"))
        readers[-1].send("subscribe", topic=f"t{n}", type="std_msgs/String", queue_length=1000)
        for _ in range(20):
            publisher.publish(f"t{n}", 150_000)
        assert sum(reader.bytes for reader in readers) <= LIMITS.total_bytes
    assert not any(client.given_up for client in (publisher, *readers)) and all(reader.bytes for reader in readers)
    for reader in readers[1:]:
        reader.session.close()
    for _ in range(30):
        publisher.publish("t0", 150_000)
    assert 4 * MB < readers[0].bytes <= LIMITS.client_bytes, "the others have left"


def test_a_client_that_keeps_more_than_its_share_is_disconnected_when_others_come(graph):
    keeper = Client(graph, "/keeper")
    keeper.publish("t", 1_900_000, latch=True)
    others = [Client(graph, f"/other{k}") for k in range(3)]
    assert "3.8 MB are kept for you, too much for one of 4 clients" in keeper.given_up and len(others) == 3


def test_a_message_for_many_is_in_memory_once(graph):
    readers = [Client(graph, f"/reader{k}").send("subscribe", topic="t", type="std_msgs/String") for k in range(20)]
    Client(graph, "/publisher").publish("t", 50_000)
    waiting = [reader.session.outbox._mailboxes["t"].samples.oldest[1] for reader in readers]
    assert len({id(sample) for sample in waiting}) == 1


KEPT = {
    "no room to latch it": lambda k, data: {"op": "publish", "topic": f"t{k}", "latch": True, "msg": {"data": data}},
    "no room to keep the call": lambda k, data: {"op": "call_service", "service": "never", "id": k, "args": [data]},
    "no room to keep them": lambda k, data: {"op": "fragment", "id": k % 9, "num": k // 9, "total": 99, "data": data},
}


@pytest.mark.parametrize("refusal", KEPT)
def test_what_is_kept_for_a_client_is_bounded_and_goes_with_it(graph, refusal):
    server = Client(graph, "/server").send("advertise_service", service="never", type="demo/Never")
    limits = Limits(client_bytes=1 * MB, frame_bytes=200_000, fragmented_messages=9)
    client = Client(graph, "/client", limits)
    for k in range(50):
        client.send("advertise", topic=f"t{k}", type="std_msgs/String", latch=True)
        client.send(**KEPT[refusal](k, "x" * 40_000))
        server.frames()
        assert client.bytes <= 1 * MB
    assert refusal in client.frames()[0]
    client.session.close()
    assert server.session._calls._received == {} and server.bytes == 0
    assert all(topic.latched is None for topic in graph.topics.values())


def test_ids_are_short_and_few(graph):
    client = Client(graph, "/client")
    client.send("subscribe", topic="t", type="std_msgs/String", id="x" * 257)
    assert json.loads(client.frames()[0])["msg"] == "id: 257 characters: must be 256 at most"
    for k in range(200):
        client.send("subscribe", topic="t", type="std_msgs/String", id=str(k))
    subscription = client.session._topics._names.subscriptions["t"]
    assert len(subscription.ids) == LIMITS.ids and "the maximum" in client.frames()[0]


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
    with pytest.raises(ValueError, match="lists and objects"):
        parameters.set_json("deep", f"[{','.join(['{}'] * 25_000)}]")


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
                session.outbox._give_up("slow")
            session.close()
            ended.append(weakref.ref(session))
            del session
        assert [reference() for reference in ended] == [None, None]
        assert graph.outboxes == {other.session.outbox}
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


def test_who_asks_and_does_not_read_is_told_why_it_must_go(caplog):
    """The reason is logged and sent in the close frame, which the client reads after messages already in transit."""
    caplog.set_level(logging.WARNING)
    question = {"op": "call_service", "service": "/rosapi/get_param", "args": {"name": "/no", "default": "x" * 90_000}}
    with RosbridgeServer(None, limits=Limits(client_bytes=1 * MB)) as server, websocket(server.url) as witness:
        with websocket(server.url, max_queue=1, max_size=None, ping_interval=None) as asker:
            for _ in range(2000):
                asker.send(json.dumps(question))
                if "you read too slowly" in caplog.text:
                    break
            until(lambda: "you read too slowly" in caplog.text)
            with pytest.raises(ConnectionClosed) as closed:
                while True:
                    asker.recv(10.0)
            if closed.value.rcvd is not None:  # absent if the connection had to be cut
                assert closed.value.rcvd.code == 1008 and "you read too slowly" in closed.value.rcvd.reason
        until(lambda: len(server.sessions) == 1)
        witness.send(json.dumps(question))
        assert json.loads(witness.recv(60.0))["result"]


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
