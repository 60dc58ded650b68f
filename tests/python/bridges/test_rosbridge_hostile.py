"""Hostile input results in an error status or a closed connection; the server keeps running and forgets the client."""

import json
import logging
import socket
import ssl
import time
import warnings
from contextlib import ExitStack

import cbor2
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect as websocket

from certificate import first_frame, write_certificate
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.rosbridge import Limits
from uwsim.bridges.rosbridge.graph import Graph
from uwsim.bridges.rosbridge.session import Session
from waiting import until

PATIENCE_S = 180.0
QUICK = Limits(connections=40, frame_bytes=100_000, messages_per_s=300, replies=50)


@pytest.fixture(scope="module")
def server():
    with RosbridgeServer(None, limits=QUICK) as server:
        yield server


def connect(server, **options):
    return websocket(server.url, compression=None, open_timeout=PATIENCE_S, close_timeout=0.1, **options)


REQUEST = '{"op": "call_service", "service": "/rosapi/topics", "id": "still there?"}'


def works(client):
    """Return True if the server still answers this client, in order."""
    client.send(REQUEST)
    while (answer := json.loads(client.recv(PATIENCE_S))).get("id") != "still there?":
        pass
    return answer["result"]


@pytest.mark.parametrize(
    "damage", [b"\x00" * 1000, b"GET / HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 10_000, b""]
)
def test_what_is_no_websocket_is_closed(server, damage):
    with connect(server) as witness, socket.create_connection(("127.0.0.1", server.port)) as stranger:
        stranger.settimeout(PATIENCE_S)
        try:
            stranger.sendall(damage)
            stranger.shutdown(socket.SHUT_WR)
            while stranger.recv(4096):
                pass
        except ConnectionError:
            pass  # the server closed the connection while we were still sending
        assert works(witness)


def test_a_disconnect_in_the_middle_of_a_frame(server):
    until(lambda: not server.sessions)  # sessions left by other tests have ended
    with connect(server) as client:
        until(lambda: server.sessions)
        client.socket.sendall(b"\x81\xfe\x10\x00mask{")  # announces a payload of 4,096 bytes
        client.socket.shutdown(socket.SHUT_RDWR)
        until(lambda: not server.sessions)
    with connect(server) as witness:
        assert works(witness)


def test_a_huge_frame_closes_the_connection(server):
    with connect(server) as client, connect(server) as witness:
        client.send('{"op":"' + "x" * QUICK.frame_bytes + '"}')
        with pytest.raises(ConnectionClosed) as closed:
            client.recv(PATIENCE_S)
        assert closed.value.rcvd.code == 1009
        assert works(witness)


def test_of_too_many_clients_one_that_was_silent_makes_room(server):
    until(lambda: not server.sessions)
    with ExitStack() as clients:
        first = clients.enter_context(connect(server))
        assert works(first)
        silent = [clients.enter_context(connect(server)) for _ in range(QUICK.connections + 5)]
        assert works(first) and works(silent[-1])
        until(lambda: len(server.sessions) <= QUICK.connections)
        with pytest.raises(ConnectionClosed) as closed:
            silent[0].recv(PATIENCE_S)
        assert closed.value.rcvd.code == 1013
    until(lambda: not server.sessions)
    with connect(server) as client:
        assert works(client)


def test_a_flood_is_read_slowly(server):
    with connect(server) as flooder, connect(server) as witness:
        start_s = time.monotonic()
        for _ in range(int(QUICK.messages_per_s) + 60):
            flooder.send('{"op": "status", "msg": "flood"}')
        assert works(witness) and time.monotonic() - start_s < 1.0
        assert works(flooder)
        assert time.monotonic() - start_s > 0.15  # 60 messages beyond the allowance, at 300 per second


def test_who_does_not_read_loses_its_own_messages_and_nobody_else_notices(server):
    subscribe = '{"op": "subscribe", "topic": "/big", "type": "std_msgs/String", "queue_length": 2}'
    with connect(server) as publisher, connect(server) as reader, connect(server, max_queue=1) as sleeper:
        for client in (reader, sleeper):
            client.send(subscribe)
            assert works(client)
        publisher.send('{"op": "advertise", "topic": "/big", "type": "std_msgs/String"}')
        for k in range(200):
            publisher.send(json.dumps({"op": "publish", "topic": "/big", "msg": {"data": str(k).ljust(90_000)}}))
            assert json.loads(reader.recv(PATIENCE_S))["msg"]["data"].strip() == str(k)
        lost = [session.outbox.lost for session in server.sessions.values()]
        waiting = [len(box.samples) for s in server.sessions.values() for box in s.outbox._mailboxes.values()]
        assert sorted(lost)[-1] > 0 and sorted(lost)[-2] == 0 and max(waiting) <= 2


def test_tls(tmp_path):
    write_certificate(tmp_path)
    with RosbridgeServer(None, certfile=tmp_path / "cert.pem", keyfile=tmp_path / "key.pem") as server:
        trusted = ssl.create_default_context(cafile=str(tmp_path / "cert.pem"))
        assert json.loads(first_frame(f"wss://localhost:{server.port}", REQUEST, ssl=trusted))["result"]
    for certfile, keyfile in (("key.pem", "key.pem"), ("nothing.pem", "key.pem")):
        with pytest.raises((ValueError, OSError), match=certfile):
            RosbridgeServer(None, certfile=tmp_path / certfile, keyfile=tmp_path / keyfile)


def test_wrong_options_are_refused(server):
    for options, complaint in (
        ({"port": 70000}, "port = 70000"),
        ({"token": "short"}, "token: must have 8 to 256"),
        ({"ros": 3}, "ros = 3: must be 1 or 2"),
        ({"keyfile": "key.pem"}, "keyfile: needs certfile"),
        ({"origins": ["station"]}, "origin = 'station'"),
    ):
        with pytest.raises(ValueError, match=complaint):
            RosbridgeServer(None, **options)
    with pytest.raises(ValueError, match=r"limits.frame_bytes = 0: must be positive"):
        Limits(frame_bytes=0)
    with pytest.raises(OSError, match=f"cannot listen on 127.0.0.1:{server.port}"):
        RosbridgeServer(None, port=server.port).start()
    with pytest.warns(UserWarning), pytest.raises(OSError, match=r"cannot listen on a\.\.b:"):
        RosbridgeServer(None, host="a..b").start()


def test_listening_beyond_this_machine_is_warned_of():
    with pytest.warns(UserWarning, match="anyone who reaches this machine can drive the vehicle.*plain text"):
        RosbridgeServer(None, host="0.0.0.0").start().stop()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        RosbridgeServer(None, host="::1").start().stop()


# Fuzzing: whatever arrives, a session answers or ignores it, has charged for it beforehand, and leaks nothing.

NAMES = st.sampled_from(["/t", "t", "u", "/rosapi/topics", "service", "", " ", "é"])
TYPES = st.sampled_from(["std_msgs/String", "std_msgs/msg/UInt8", "sensor_msgs/LaserScan", "nonsense", "a/b"])
OPS = st.sampled_from([*Session(Graph(), "/one").operations, "png", "auth"])
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20) | st.binary(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=12,
)
FIELDS = {
    "topic": NAMES,
    "service": NAMES,
    "type": TYPES,
    "id": st.sampled_from(["a", "b", 1]) | st.sampled_from([f"service_request:service:{k}" for k in range(1, 5)]),
    "msg": st.fixed_dictionaries({"data": VALUES}) | st.fixed_dictionaries({"ranges": st.lists(st.floats())}),
    "args": VALUES,
    "values": VALUES,
    "result": st.booleans(),
    "compression": st.sampled_from(["none", "cbor", "cbor-raw", "png", "zip"]),
    "throttle_rate": st.integers(-1, 100),
    "queue_length": st.integers(-1, 5),
    "latch": st.booleans(),
    "level": st.sampled_from(["info", "none", "x"]),
    "data": st.text(max_size=30),
    "num": st.integers(-1, 3),
    "total": st.integers(-1, 3),
}
OPERATIONS = st.builds(
    lambda op, fields, odd: {"op": op} | fields | odd,
    OPS,
    st.fixed_dictionaries({}, optional=FIELDS),
    st.dictionaries(st.sampled_from([*FIELDS, "op"]), VALUES, max_size=1),
)


def as_cbor(operation):
    return cbor2.dumps(operation)


def as_json(operation):
    return json.dumps(operation, default=lambda value: value.hex())


def damaged(frame, at, byte):
    place = at % max(len(frame), 1)
    return frame[:place] + (bytes([byte]) if isinstance(frame, bytes) else chr(byte)) + frame[place + 1 :]


FRAMES = st.one_of(
    OPERATIONS.map(as_json),
    OPERATIONS.map(as_cbor),
    st.builds(damaged, OPERATIONS.map(as_cbor) | OPERATIONS.map(as_json), st.integers(0, 300), st.integers(0, 255)),
    st.binary(max_size=60),
    st.text(max_size=60),
)


@settings(max_examples=100)
@given(st.lists(st.tuples(st.integers(0, 2), FRAMES), max_size=30))
def test_fuzz(steps):
    records = []
    handler = logging.Handler()
    handler.emit = records.append
    logger = logging.getLogger("uwsim.rosbridge")
    logger.addHandler(handler)
    graph = Graph()
    limits = Limits(names=8, replies=20, fragmented_messages=2, open_calls=4)
    sessions = [Session(graph, f"/{k}", limits=limits) for k in range(3)]
    try:
        for k, frame in steps:
            sessions[k].receive(frame)
        for session in sessions:
            while (frame := session.outbox.take()[0]) is not None:
                answer = json.loads(frame) if isinstance(frame, str) else cbor2.loads(frame)
                assert answer["op"] in {"publish", "service_response", "call_service", "status", "png"}
            session.close()
    finally:
        logger.removeHandler(handler)
    assert [record.getMessage() for record in records if record.levelno >= logging.WARNING] == []
    assert (graph.topics, graph.services, graph.nodes) == ({}, {}, {})
